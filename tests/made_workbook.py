"""Workbooks as programs store them, written part by part, for the tests that damage them."""

# ruff: noqa: E501

import struct
import zipfile
from xml.sax.saxutils import escape

import numpy as np
import openpyxl

TIME = np.arange(0, 3.2, 2e-3)
TITLES = ("time [s]", "PAP [mmHg]", "PA flow [ml/s]")

MAIN = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
LINKS = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"
PACKAGE = "http://schemas.openxmlformats.org/package/2006/relationships"
BOOK = (
    f'<workbook xmlns="{MAIN}" xmlns:r="{LINKS}"><sheets><sheet name="A" sheetId="1" r:id="rId1"/></sheets></workbook>'
)
RELS = f'<Relationships xmlns="{PACKAGE}"><Relationship Id="rId1" Type="{LINKS}/worksheet" Target="worksheets/sheet1.xml"/></Relationships>'
TYPES = '<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types"/>'
ROOT = f'<Relationships xmlns="{PACKAGE}"><Relationship Id="rId1" Type="{LINKS}/officeDocument" Target="xl/workbook.xml"/></Relationships>'


def column(number):
    letters = ""
    while number:
        number, rest = divmod(number - 1, 26)
        letters = chr(65 + rest) + letters
    return letters


def cell(place, value):
    if isinstance(value, str):
        return f'<c r="{place}" t="inlineStr"><is><t>{escape(value)}</t></is></c>' if value else ""
    return f'<c r="{place}"><v>{value!r}</v></c>'


def sheet(rows):
    """Return a sheet's XML; an empty text is an empty cell."""
    lines = "".join(
        f'<row r="{n}">{"".join(cell(f"{column(c)}{n}", value) for c, value in enumerate(row, 1))}</row>'
        for n, row in enumerate(rows, 1)
    )
    return f'<worksheet xmlns="{MAIN}"><sheetData>{lines}</sheetData></worksheet>'


def write_workbook(path, rows=(), **parts):
    """Write rows as the only sheet; `parts` replace or add parts of the package, None leaves one out."""
    content = {"[Content_Types].xml": TYPES, "_rels/.rels": ROOT}
    content |= {"xl/workbook.xml": BOOK, "xl/_rels/workbook.xml.rels": RELS, "xl/worksheets/sheet1.xml": sheet(rows)}
    content |= {f"{name.replace('__', '/')}.xml": text for name, text in parts.items()}
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in content.items():
            if text is not None:
                archive.writestr(name, text)
    return path


def write_ods(path, rows, name="A", more=()):
    """Write rows as a sheet of an OpenDocument spreadsheet; `more` are further pairs of name and rows."""
    space = "urn:oasis:names:tc:opendocument:xmlns"

    def cell(value):
        if isinstance(value, str):
            return f'<table:table-cell office:value-type="string"><text:p>{escape(value)}</text:p></table:table-cell>'
        return f'<table:table-cell office:value-type="float" office:value="{value!r}"><text:p>{value!r}</text:p></table:table-cell>'

    lines = "".join(
        f'<table:table table:name="{title}">'
        + "".join(f"<table:table-row>{''.join(map(cell, row))}</table:table-row>" for row in table)
        + "</table:table>"
        for title, table in [(name, rows), *more]
    )
    mime = "application/vnd.oasis.opendocument.spreadsheet"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(zipfile.ZipInfo("mimetype"), mime)
        archive.writestr(
            "content.xml",
            f'<office:document-content xmlns:office="{space}:office:1.0" xmlns:table="{space}:table:1.0" xmlns:text="{space}:text:1.0">'
            f"<office:body><office:spreadsheet>{lines}</office:spreadsheet></office:body></office:document-content>",
        )
        archive.writestr(
            "META-INF/manifest.xml",
            f'<manifest:manifest xmlns:manifest="{space}:manifest:1.0"><manifest:file-entry manifest:full-path="/" manifest:media-type="{mime}"/>'
            "</manifest:manifest>",
        )
    return path


def write_xlsb(path, rows):
    """Write rows as the only sheet of a binary workbook ([MS-XLSB]): records of a type, a length and a payload."""

    def record(kind, payload=b""):
        tag = bytes([kind]) if kind < 128 else bytes([kind & 127 | 128, kind >> 7])
        size, length = len(payload), b""
        while size > 127:
            length, size = length + bytes([size & 127 | 128]), size >> 7
        return tag + length + bytes([size]) + payload

    def text(letters):
        return struct.pack("<I", len(letters)) + letters.encode("utf-16le")

    body = record(129) + record(148, struct.pack("<4I", 0, len(rows) - 1, 0, len(rows[0]) - 1)) + record(145)
    for number, row in enumerate(rows):
        body += record(0, struct.pack("<IIHHBI", number, 0, 300, 0, 0, 0))
        for place, value in enumerate(row):
            words = isinstance(value, str)
            body += record(
                6 if words else 5, struct.pack("<II", place, 0) + (text(value) if words else struct.pack("<d", value))
            )
    book = record(131) + record(143) + record(156, struct.pack("<II", 0, 1) + text("rId1") + text("A"))
    link = f'<Relationship Id="rId1" Type="{LINKS}/{{}}" Target="{{}}"/>'
    content = {
        "[Content_Types].xml": TYPES,
        "_rels/.rels": f'<Relationships xmlns="{PACKAGE}">{link.format("officeDocument", "xl/workbook.bin")}</Relationships>',
        "xl/_rels/workbook.bin.rels": f'<Relationships xmlns="{PACKAGE}">{link.format("worksheet", "worksheets/sheet1.bin")}</Relationships>',
        "xl/workbook.bin": book + record(144) + record(132),
        "xl/worksheets/sheet1.bin": body + record(146) + record(130),
    }  # fmt: skip
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, part in content.items():
            archive.writestr(name, part)
    return path


def beats(pressure=15.0, flow=0.2, period=0.11):
    phase = TIME / period % 1
    ejection = np.where(phase < 0.4, np.sin(np.pi * phase / 0.4), 0.0)
    return pressure + 6 * np.cos(2 * np.pi * (phase - 0.25)), flow * ejection / ejection.mean()


def signals(pressure, flow=0.2, titles=TITLES):
    columns = (TIME, *beats(pressure, flow))
    return [titles, *zip(*(column.tolist() for column in columns), strict=True)]


def saved(path, **sheets):
    book = openpyxl.Workbook()
    book.remove(book.active)
    for name, rows in sheets.items():
        page = book.create_sheet(name)
        for row in rows:
            page.append(row)
    book.save(path)
    return path
