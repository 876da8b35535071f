"""What is kept: other values have other keys, and nothing is believed that is damaged or another's."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from vasowave.base.runtime import PART, digest_of, keep, program, put, recall


@dataclass(frozen=True)
class _One:
    value: object
    about: str = field(default="", compare=False)


VALUES = [
    *(1, 1.0, "1", True, None, (), (1,), ((1,), 1), (1, (1,)), {}, {"a": 1}, {"b": 1}, {"a": (1,)}),
    *(np.zeros(2), np.zeros((2, 1)), np.zeros(2, int), np.zeros(3), _One(1), _One(2), int, digest_of),
]


def test_values_that_differ_in_kind_shape_or_content_have_different_digests():
    assert len({digest_of(value) for value in VALUES}) == len(VALUES)
    assert digest_of("a", "b") != digest_of("ab")


def test_the_order_of_a_mapping_and_what_is_not_compared_do_not_count():
    assert digest_of({"a": 1, "b": 2}) == digest_of({"b": 2, "a": 1})
    assert digest_of(_One(1, "here")) == digest_of(_One(1, "there"))
    assert digest_of(np.float64(0.1)) == digest_of(0.1)


def test_a_part_of_the_program_a_library_and_the_whole_are_different_programs():
    some = [program(), program("base"), program("", ("base/io",)), program("base", libraries=("numpy",))]
    assert len(set(some)) == 4
    assert program("imaging", libraries=("no-such-library",)) not in some


def recalled(path, key):
    with path.open("rb") as file:
        return recall(file, key)


def test_no_flipped_bit_and_no_missing_byte_is_believed(tmp_path):
    path = tmp_path / "piece"
    keep(path, "key", b"some", np.arange(5, dtype=np.uint8))
    assert recalled(path, "key").tobytes() == b"some\0\1\2\3\4"
    assert recalled(path, "kez") is None
    whole = path.read_bytes()
    for bit in range(8 * len(whole)):
        broken = bytearray(whole)
        broken[bit // 8] ^= 1 << bit % 8
        path.write_bytes(broken)
        assert recalled(path, "key") is None, bit
    for content in (whole + b"x", *(whole[:count] for count in range(len(whole)))):
        path.write_bytes(content)
        assert recalled(path, "key") is None


def test_what_cannot_be_written_whole_leaves_the_earlier_file_and_nothing_else(tmp_path):
    def parts():
        yield b"half"
        raise OSError(28, "no space")

    put(tmp_path / "piece", [b"whole"])
    with pytest.raises(OSError, match="no space"):
        put(tmp_path / "piece", parts())
    assert (tmp_path / "piece").read_bytes() == b"whole"
    assert not list(tmp_path.glob(f"{PART}*"))
