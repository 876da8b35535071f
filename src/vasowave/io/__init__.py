"""Reading and writing files of any content: text, tables, workbooks, columns with units."""
