"""LZ4 blocks, as VTK's fast compression writes them: literals and copies of what came before."""

from vasowave.errors import InputError


def lz4_block(packed: bytes) -> bytes:
    """Return the content of one LZ4 block.

    Raises
    ------
    InputError
        A block that ends early or copies from before its beginning.
    """
    unpacked, at = bytearray(), 0
    try:
        while at < len(packed):
            token = packed[at]
            count, at = _count(packed, at + 1, token >> 4)
            if at + count > len(packed):
                raise IndexError
            unpacked += packed[at : at + count]
            at += count
            if at == len(packed):  # the last sequence has no copy
                break
            back = packed[at] | packed[at + 1] << 8
            count, at = _count(packed, at + 2, token & 15)
            if not 0 < back <= len(unpacked):
                raise IndexError
            for _ in range(count + 4):  # may overlap what it writes
                unpacked.append(unpacked[-back])
    except IndexError:
        raise InputError("truncated or damaged LZ4 data; write the file again") from None
    return bytes(unpacked)


def _count(packed: bytes, at: int, first: int) -> tuple[int, int]:
    """Return a length of which `first` is the beginning, and where reading goes on."""
    count = first
    while first == 15:
        count += packed[at]
        at += 1
        if packed[at - 1] != 255:
            break
    return count, at
