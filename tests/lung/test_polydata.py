"""VTK's XML written by hand, after its description: encodings, pieces, arrays, and counts that do not agree."""

import base64
import lzma
import struct
import zlib

import numpy as np
import pytest

from vasowave.base import InputError
from vasowave.lung.exchange import read_polydata
from vasowave.lung.read import lz4_block

POINTS = np.array([[0.0, 1, 2], [3, 4, 5], [6, 7, 8]])


def element(name, kind, text, form="ascii", width=""):
    width = f' NumberOfComponents="{width}"' if width else ""
    return f'<DataArray type="{kind}" Name="{name}"{width} format="{form}">{text}</DataArray>'


def listed(name, kind, values, width=""):
    return element(name, kind, " ".join(str(one) for one in np.ravel(values)), width=width)


def piece(points=POINTS, lines=((0, 1), (2,)), more="", of=None, count=None):
    joined = np.concatenate([[*line] for line in lines]) if lines else []
    ends = np.cumsum([len(line) for line in lines]).astype(int)
    of = len(points) if of is None else of
    count = len(lines) if count is None else count
    return (
        f'<Piece NumberOfPoints="{of}" NumberOfLines="{count}"><Points>{listed("P", "Float32", points, 3)}</Points>'
        f"<Lines>{listed('connectivity', 'Int32', joined)}{listed('offsets', 'Int32', ends)}</Lines>{more}</Piece>"
    )


def file(*pieces, head='type="PolyData"', behind=""):
    return f"<VTKFile {head}><PolyData>{''.join(pieces)}</PolyData>{behind}</VTKFile>"


def read(tmp_path, content):
    path = tmp_path / "a.vtp"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return read_polydata(path)


def refused(tmp_path, content):
    with pytest.raises(InputError) as error:
        read(tmp_path, content)
    return str(error.value).partition("a.vtp: ")[2]


def test_pieces_follow_each_other_and_keep_what_all_of_them_have(tmp_path):
    def values(first, *names):
        both = "".join(listed(name, "Float64", first + np.arange(3)) for name in names)
        return f"<PointData>{both}{element('s', 'String', 'x')}</PointData>"

    cells = "<CellData>" + listed("id", "Int8", [4, 5]) + listed("pair", "UInt8", [1, 2, 3, 4], 2) + "</CellData>"
    one = piece(more=values(0, "Radius", "own") + cells)
    two = piece(POINTS + 10, lines=((2, 0), (1,)), more=values(7, "Radius") + cells)
    found = read(tmp_path, file(one, piece(POINTS[:0], lines=()), two))
    assert np.array_equal(found.points, np.vstack([POINTS, POINTS + 10]))
    assert [line.tolist() for line in found.lines] == [[0, 1], [2], [5, 3], [4]]
    assert {name: array.tolist() for name, array in found.fields.items()} == {"Radius": [0, 1, 2, 7, 8, 9]}
    assert found.cells["id"].tolist() == [4, 5, 4, 5]
    assert found.cells["pair"].tolist() == [[1, 2], [3, 4]] * 2


def test_a_surface_has_points_and_no_lines(tmp_path):
    bare = f'<Piece NumberOfPoints="3" NumberOfLines="0"><Points>{listed("P", "Float32", POINTS, 3)}</Points></Piece>'
    found = read(tmp_path, file(bare))
    assert [len(found.points), *map(len, found.lines)] == [3, 0]


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (file(), "no points; are these centerlines?"),
        (file(head='type="ImageData"'), "not VTK PolyData; export the centerlines as .vtp"),
        (file().replace("VTKFile", "File"), "not VTK PolyData; export"),
        (file(piece(of=4)), "3 points where 4 were announced; write the file again"),
        (file(piece(count=3)), "2 lines where 3 were announced; write the file again"),
        (file(piece()).replace(">2 3<", ">2 4<"), "the lines hold 3 point numbers, their offsets say otherwise"),
        (file(piece()).replace(">2 3<", ">4 3<"), "the lines hold 3 point numbers, their offsets say otherwise"),
        (file(piece()).replace(">2 3<", ">-1 3<"), "the lines hold 3 point numbers, their offsets say otherwise"),
        (file(piece(lines=((0, 1), (3,)))), "line 1 names a point that does not exist (3 points)"),
        (file(piece(lines=((0, -1), (2,)))), "line 0 names a point that does not exist (3 points)"),
        (file(piece(more=f"<PointData>{listed('r', 'Int8', [1, 2])}</PointData>")), "array 'r' has 2 values for 3"),
        (file(piece(np.where(POINTS == 4, np.nan, POINTS))), "points are not finite triples x, y, z"),
        (file(piece()).replace("connectivity", "con"), "damaged or truncated PolyData ('connectivity'); write"),
        (file(piece()).replace(">2 3<", ">2 3_0<"), "numbers with signs that no number has"),
        (file(piece())[:-3], "not valid XML"),
    ],
)  # fmt: skip
def test_what_does_not_agree_is_refused_with_its_numbers(tmp_path, content, said):
    assert refused(tmp_path, content).startswith(said)


def test_data_of_lines_that_are_not_one_a_line_are_left_out(tmp_path):
    found = read(tmp_path, file(piece(more=f"<CellData>{listed('id', 'Int8', [1, 2, 3])}</CellData>")))
    assert found.cells == {}


def coded(*parts):
    return b"".join(map(base64.b64encode, parts)).decode()


def streams(order, values):
    """Return the ways to write an array in base64: in one stream, in two, in blocks of 40 bytes, of any packer."""
    content = values.tobytes()
    length = struct.pack(order + "I", len(content))
    blocks = [content[at : at + 40] for at in range(0, len(content), 40)]

    def packed(pack):
        each = [pack(block) for block in blocks]
        last = len(blocks[-1]) % 40
        return coded(struct.pack(f"{order}{3 + len(each)}I", len(each), 40, last, *map(len, each)), b"".join(each))

    return {
        "one": (coded(length + content), ""), "two": (coded(length, content), ""),
        "zlib": (packed(zlib.compress), ' compressor="vtkZLibDataCompressor"'),
        "lzma": (packed(lzma.compress), ' compressor="vtkLZMADataCompressor"'),
        "lz4": (packed(lambda block: bytes([0xF0, len(block) - 15]) + block), ' compressor="vtkLZ4DataCompressor"'),
    }  # fmt: skip


@pytest.mark.parametrize("way", ["one", "two", "zlib", "lzma", "lz4"])
@pytest.mark.parametrize(("order", "word"), [("<", "LittleEndian"), (">", "BigEndian")])
def test_binary_arrays_hold_the_same_numbers_in_every_encoding(tmp_path, way, order, word):
    """Nine doubles are 72 bytes: a block of 40 and one of 32."""
    text, packer = streams(order, POINTS.astype(order + "f8"))[way]
    bare = f'<Piece NumberOfPoints="3"><Points>{element("P", "Float64", text, "binary", 3)}</Points></Piece>'
    head = f'type="PolyData" byte_order="{word}"{packer}'
    assert np.array_equal(read(tmp_path, file(bare, head=head)).points, POINTS)
    cut = bare.replace(text, text[: len(text) // 8 * 4])
    assert refused(tmp_path, file(cut, head=head)).startswith("truncated; write the file again")


@pytest.mark.parametrize("raw", [True, False])
def test_appended_arrays_begin_at_their_offsets(tmp_path, raw):
    arrays = np.arange(3, dtype="<i4"), POINTS.astype("<f4")
    content = [struct.pack("<I", one.nbytes) + one.tobytes() for one in arrays]
    parts = content if raw else [base64.b64encode(one) for one in content]
    at = len(parts[0])
    head = (
        '<Piece NumberOfPoints="3"><Points><DataArray type="Float32" NumberOfComponents="3" {}/></Points><PointData>'
        '<DataArray type="Int32" Name="n" format="appended" offset="0"/></PointData></Piece>'
    )
    encoding = ' encoding="raw"' if raw else ' encoding="base64"'

    def written(offset):
        before = file(head.format(f'format="appended" offset="{offset}"'), behind="@")
        behind = f"<AppendedData{encoding}>_".encode() + b"".join(parts) + b"</AppendedData>"
        return before.encode().replace(b"@", behind)

    found = read(tmp_path, written(at))
    assert np.array_equal(found.points, POINTS)
    assert found.fields["n"].tolist() == [0, 1, 2]
    end = sum(map(len, parts))
    assert refused(tmp_path, written(end)) == f"an array begins at byte {end} of {end}; write the file again"
    assert refused(tmp_path, written(-1)).startswith(f"an array begins at byte -1 of {end}")


@pytest.mark.parametrize(
    ("packed", "size", "content"),
    [
        (bytes([0x10]) + b"a", 1, b"a"),
        (bytes([0x11]) + b"a" + bytes([1, 0, 0x10]) + b"b", 7, b"aaaaaab"),  # a copy of 1 + 4
        (bytes([0x2F]) + b"ab" + bytes([2, 0, 1]) + bytes([0x10]) + b"c", 23, b"ab" * 11 + b"c"),  # of 15 + 1 + 4
        (bytes([0x3F]) + b"abc" + bytes([3, 0, 255, 0]) + bytes([0]), 277, b"abc" * 92 + b"a"),  # of 15 + 255 + 0 + 4
        (bytes([0xF0, 255, 0]) + bytes(270), 270, bytes(270)),
        (bytes([0xF0, 241]) + bytes(range(256))[:-1], 256, None),
        (bytes([0x11]) + b"a" + bytes([0, 0, 0x10]) + b"b", 7, None),  # a copy from nowhere back
        (bytes([0x11]) + b"a" + bytes([2, 0, 0x10]) + b"b", 7, None),
        (bytes([0x10]) + b"a", 2, None),
        (bytes([0x20]) + b"ab", 1, None),
    ],
)  # fmt: skip
def test_a_sequence_of_lz4_is_literals_and_a_copy(packed, size, content):
    if content is None:
        with pytest.raises(InputError, match="truncated or damaged LZ4 data; write the file again"):
            lz4_block(packed, size)
    else:
        assert lz4_block(packed, size) == content
