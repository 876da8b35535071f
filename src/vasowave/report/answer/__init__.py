"""The one result on the first page: an answer to each question, one forest plot, what is not known, what is wrong."""
