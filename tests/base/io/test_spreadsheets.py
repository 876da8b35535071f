"""Excel workbooks wherever a table is read."""

import datetime
import zipfile

import openpyxl
import pytest

from made_workbook import BOOK, MAIN, sheet, write_ods, write_workbook, write_xlsb
from vasowave.base import InputError
from vasowave.base.io import read_columns, read_lines


def saved(path, *rows, **sheets):
    """Save rows with openpyxl, an independent implementation of the format."""
    book = openpyxl.Workbook()
    for row in rows:
        book.active.append(row)
    for title, more in sheets.items():
        page = book.create_sheet(title)
        for row in more:
            page.append(row)
    book.save(path)
    return path


def test_empty_rows_gaps_and_remarks_leave_the_rows_their_numbers(tmp_path):
    book = openpyxl.Workbook()
    book.active["A3"], book.active["B3"] = "x [cm]", "remark"
    book.active["A5"], book.active["B9"], book.active["A9"] = 1.5, 'a "word",\nand a line', 2
    book.save(tmp_path / "t.xlsx")
    table = read_columns(tmp_path / "t.xlsx")
    assert table.lines == (5, 9)
    assert table.cells == (("1.5", ""), ("2", 'a "word", and a line'))
    book.active["A9"] = "two"
    book.save(tmp_path / "t.xlsx")
    with pytest.raises(InputError, match="line 9, column 'x': 'two' is not a number"):
        read_columns(tmp_path / "t.xlsx").numbers(0, "length")


def test_dates_times_errors_and_truths_are_never_taken_for_numbers(tmp_path):
    day, hour = datetime.datetime(2026, 3, 1), datetime.time(0, 0, 1, 500000)
    values = [day, hour, datetime.timedelta(seconds=90), True, "#DIV/0!"]
    for number, value in enumerate(values):
        path = saved(tmp_path / f"{number}.xlsx", ("x [cm]", "y"), (value, 1))
        with pytest.raises(InputError, match=r"is not a number|the cell is empty"):
            read_columns(path).numbers(0, "length")
    assert read_columns(tmp_path / "0.xlsx").cells[0][0] == "2026-03-01"


def test_a_number_shown_with_a_color_a_unit_or_an_exponent_stays_a_number(tmp_path):
    book = openpyxl.Workbook()
    book.active.append(["x [cm]", "y"])
    for row, shown in enumerate(("0.00E+00", '0.0" mmHg days"', "[Red]0.0", "#,##0.00_);\\(#,##0.00\\)", "0%"), 2):
        book.active.cell(row, 1, 0.25).number_format = shown
        book.active.cell(row, 2, 1)
    book.save(tmp_path / "t.xlsx")
    assert read_columns(tmp_path / "t.xlsx").numbers(0, "length").tolist() == [0.25] * 5


def test_the_first_visible_sheet_is_read(tmp_path):
    path = saved(tmp_path / "t.xlsx", ("hidden",), data=[("x [cm]",), (3,)])
    book = openpyxl.load_workbook(path)
    book.worksheets[0].sheet_state = "hidden"
    book.active = 1
    book.save(path)
    assert read_columns(path).numbers(0, "length").tolist() == [3]


def test_formulas_count_with_the_value_that_was_last_shown(tmp_path):
    rows = f'<row r="1"><c r="A1" t="str"><f>"x [cm]"</f><v>x [cm]</v></c></row><row r="2"><c r="A2"><f>1+1</f><v>2</v></c></row>'  # noqa: E501, F541
    xml = f'<worksheet xmlns="{MAIN}"><sheetData>{rows}</sheetData></worksheet>'
    path = write_workbook(tmp_path / "t.xlsx", xl__worksheets__sheet1=xml)
    assert read_columns(path).numbers(0, "length").tolist() == [2]


def test_the_pronunciation_of_a_word_is_no_part_of_it(tmp_path):
    words = "<sst><si><r><t>x </t></r><r><t>[cm]</t></r><rPh><t>EKS</t></rPh></si></sst>"
    xml = f'<worksheet xmlns="{MAIN}"><sheetData><row><c t="s"><v>0</v></c></row><row><c><v>3</v></c></row></sheetData></worksheet>'  # noqa: E501
    path = write_workbook(tmp_path / "t.xlsx", xl__sharedStrings=words, xl__worksheets__sheet1=xml)
    assert read_columns(path).numbers(0, "length").tolist() == [3]
    assert read_columns(path).names == ("x",)


def test_the_longest_text_that_a_cell_may_hold_is_read_and_no_longer_one(tmp_path):
    path = write_workbook(tmp_path / "t.xlsx", [["x" * 65536]])
    assert "".join(text for lines in read_lines(path) for text in lines.texts) == "x" * 65536
    path = write_workbook(tmp_path / "t.xlsx", [["x" * 65537]])
    with pytest.raises(InputError, match="more than 65536 characters"):
        list(read_lines(path))


BOMB = '<!DOCTYPE a [<!ENTITY b "bbbbbbbbbb"><!ENTITY c "&b;&b;&b;&b;">]>'


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ({"xl__workbook": None}, "no visible sheet"),
        ({"xl__workbook": "<workbook"}, "damaged, or not a workbook"),
        ({"xl__workbook": "<workbook/>"}, "no visible sheet"),
        ({"xl__workbook": BOOK.replace("rId1", "rId7")}, "damaged, or not a workbook"),
        ({"xl__worksheets__sheet1": None}, "damaged"),
        ({"xl__worksheets__sheet1": BOMB + "<worksheet/>"}, "no visible sheet"),
        ({"xl__worksheets__sheet1": "<worksheet>" + "<a>" * 100000}, "no visible sheet"),
        ({"xl__worksheets__sheet1": sheet([[1]]).replace('r="A1"', 'r="A1" t="s"')}, "damaged, or not a workbook"),
        ({"xl__worksheets__sheet1": sheet([["x" * 100000]])}, "more than 65536 characters"),
        (
            {"xl__worksheets__sheet1": sheet([[1], [2]]).replace('"A1"', '"XFD1"').replace('"A2"', '"A1048576"')},
            "more cells than any table|ended the process",
        ),
    ],
)
def test_a_damaged_or_hostile_workbook_is_one_of_our_errors(tmp_path, parts, words):
    path = write_workbook(tmp_path / "t.xlsx", [["x [cm]"], [1.0]], **parts)
    with pytest.raises(InputError, match=words) as caught:
        list(read_lines(path))
    assert str(caught.value).startswith(str(path))


def test_a_workbook_that_says_to_unpack_to_a_thousandfold_is_refused_before_it_is_unpacked(tmp_path):
    path = write_workbook(tmp_path / "bomb.xlsx", [["x [cm]"], *([1.0] for _ in range(9000))])
    raw = bytearray(path.read_bytes())
    with zipfile.ZipFile(path) as archive:
        size = archive.getinfo("xl/worksheets/sheet1.xml").file_size
    at = raw.rfind(size.to_bytes(4, "little"))
    raw[at : at + 4] = (1 << 31).to_bytes(4, "little")
    path.write_bytes(raw)
    with pytest.raises(InputError, match="unpacks to 2048 MB"):
        list(read_lines(path))


def test_a_workbook_that_lies_about_its_size_is_refused(tmp_path):
    path = write_workbook(tmp_path / "liar.xlsx", [["x [cm]"], *([1.0] for _ in range(9000))])
    raw = bytearray(path.read_bytes())
    with zipfile.ZipFile(path) as archive:
        size = archive.getinfo("xl/worksheets/sheet1.xml").file_size
    at = raw.rfind(size.to_bytes(4, "little"))
    raw[at : at + 4] = (1000).to_bytes(4, "little")
    path.write_bytes(raw)
    with pytest.raises(InputError, match=r"liar\.xlsx"):
        list(read_lines(path))


def test_one_long_text_in_every_cell_of_many_rows_is_refused_and_not_gathered(tmp_path):
    text = f"<sst><si><t>{'x' * 60000}</t></si></sst>"
    cells = "".join(f'<c r="{letter}{{0}}" t="s"><v>0</v></c>' for letter in "ABCDEFGHIJKLMNOPQRSTUVWXYZ")
    rows = "".join(f'<row r="{n}">{cells.format(n)}</row>' for n in range(1, 2000))
    path = write_workbook(tmp_path / "t.xlsx", xl__sharedStrings=text,
                          xl__worksheets__sheet1=f"<worksheet><sheetData>{rows}</sheetData></worksheet>")  # fmt: skip
    with pytest.raises(InputError, match=r"ended the process|more memory|longer than"):
        list(read_lines(path))


def test_what_is_no_workbook_is_refused_with_what_to_do(tmp_path):
    (tmp_path / "old.xls").write_bytes(b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(512))
    with zipfile.ZipFile(tmp_path / "text.docx", "w") as archive:
        archive.writestr("content.xml", "<x/>")
    (tmp_path / "cut.xlsx").write_bytes(write_workbook(tmp_path / "t.xlsx", [["a"]]).read_bytes()[:300])
    for name, words in (("old.xls", "by a password"), ("text.docx", "not a workbook"), ("cut.xlsx", "truncated")):
        with pytest.raises(InputError, match=words) as caught:
            read_columns(tmp_path / name)
        assert "CSV" in str(caught.value)


def test_sheets_of_every_kind_of_workbook_hold_the_numbers_that_were_written(tmp_path):
    rows = [("x [cm]", "remark"), (0.1, "a"), (2, "b"), (1 / 3, "c")]
    for name, write in (("t.ods", write_ods), ("t.xlsb", write_xlsb), ("t.xlsx", lambda p, r: saved(p, *r))):
        write(tmp_path / name, rows)
        assert read_columns(tmp_path / name).numbers(0, "length").tolist() == pytest.approx([0.1, 2, 1 / 3], abs=1e-15)


def test_a_sheet_is_chosen_by_its_name_and_a_slip_is_answered_by_the_names(tmp_path):
    path = saved(tmp_path / "t.xlsx", ("x [cm]",), (1,), Second=[("x [cm]",), (2,)])
    assert read_columns(path, sheet="second").numbers(0, "length").tolist() == [2]
    with pytest.raises(
        InputError, match=r"no visible sheet 'Secund' \(did you mean 'Second'\?\); it has: Sheet, Second"
    ):
        read_columns(path, sheet="Secund")
    (tmp_path / "t.csv").write_text("x [cm]\n1\n")
    with pytest.raises(InputError, match="is not a workbook and has no sheet 'Second'"):
        read_columns(tmp_path / "t.csv", sheet="Second")
