"""The network of an input file of svOneDSolver (SimVascular's one-dimensional solver): nodes, joints and segments."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.findings import Finding
from vasowave.base.io.textfile import read_lines
from vasowave.pulse.network.graph import numbered
from vasowave.pulse.network.network import Network
from vasowave.pulse.network.remarks import LEFT_OUT, UNUSED
from vasowave.pulse.network_formats import NETWORKS, NetworkFormat, number_in, taper_of

_SEGMENT_WORDS = 8  # of a segment, that say its place and its size
_LOSS, _BED = 10, 14  # words of a segment
_NONE = ("NONE", "NOBOUND")
_NAMED = 5  # words that a finding names
_LEFT_OUT = {
    "MATERIAL": "walls",
    "DATATABLE": "inflow and beds",
    "SOLVEROPTIONS": "options of the solver",
}
_CARDS = {*_LEFT_OUT, "MODEL", "NODE", "SEGMENT", "JOINT", "JOINTINLET", "JOINTOUTLET", "ENDDATATABLE", "OUTPUT"}


class _Segment(NamedTuple):
    line: int
    name: str
    number: int
    length: float
    start: int
    end: int
    area: tuple[float, float]
    loss: str  # empty for none
    bed: str


def is_input(path: Path, start: bytes) -> bool:
    """Return whether a file is such an input, by its name and its cards."""
    return path.suffix.lower() == ".in" and any(card in start for card in (b"MODEL", b"NODE", b"SEGMENT", b"# ="))


def read_input(path: Path, scale: float) -> tuple[Network, list[Finding]]:
    """Read the segments, cm; what joins them are the joints, and where there are none the nodes that they share."""
    segments: list[_Segment] = []
    joints: dict[str, list[int]] = {}
    pairs: list[tuple[str, str]] = []
    cards: set[str] = set()
    for block in read_lines(path):
        for line, text in enumerate(block.texts, block.first):
            card, *words = text.split("#")[0].split() or [""]
            cards.add(card.upper())
            if card and card.upper() not in _CARDS and not card[-1].isdigit():  # tables are rows of numbers
                raise InputError(f"{path}, line {line}: '{card[:40]}' is no card of svOneDSolver; write the file again")
            if card == "SEGMENT":
                segments.append(_segment(path, line, words))
            elif card in ("JOINTINLET", "JOINTOUTLET"):
                joints[_word(path, line, words, 0)] = _listed(path, line, card, words[1:])
            elif card == "JOINT":
                pairs.append((_word(path, line, words, 2), _word(path, line, words, 3)))
    if not segments:
        raise InputError(f"{path}: has no SEGMENT; is it an input of svOneDSolver?")
    nodes = _joined(path, segments, joints, pairs) if pairs else [(segment.start, segment.end) for segment in segments]
    radii = np.sqrt(np.array([segment.area for segment in segments]) / np.pi)
    length = np.array([segment.length for segment in segments])
    network = Network(
        tuple(segment.name for segment in segments), None, length, radii.mean(axis=1),
        lambda row: f"{path}, line {segments[row].line}", nodes=numbered(nodes),
        taper=taper_of(radii[:, 0], radii[:, 1], length),
    )  # fmt: skip
    omissions = [meaning for card, meaning in _LEFT_OUT.items() if card in cards]
    omissions += ["beds"] if "DATATABLE" not in cards and any(segment.bed for segment in segments) else []
    unused = [f"{segment.loss} of SEGMENT {segment.name}" for segment in segments if segment.loss]
    ellipsis = ", …" if len(unused) > _NAMED else ""
    return network, [
        *([LEFT_OUT(what=", ".join(omissions))] if omissions else []),
        *([UNUSED(what=", ".join(unused[:_NAMED]) + ellipsis)] if unused else []),
    ]


def _listed(path: Path, line: int, card: str, words: list[str]) -> list[int]:
    """Return the numbers of a list that begins with how many they are."""
    count, *numbers = [_whole(path, line, word) for word in words] or [0]
    if count != len(numbers):
        raise InputError(f"{path}, line {line}: {card} says {count} segments and lists {len(numbers)}")
    return numbers


def _segment(path: Path, line: int, words: list[str]) -> _Segment:
    if len(words) < _SEGMENT_WORDS:
        raise InputError(
            f"{path}, line {line}: a SEGMENT of {len(words)} words; name, number, length, elements, inlet and outlet "
            "node, inlet and outlet area are needed"
        )
    number, start, end = (_whole(path, line, words[i]) for i in (1, 4, 5))
    length, first, last = (number_in(path, line, words[i]) for i in (2, 6, 7))
    if not (first > 0 and last > 0):
        raise InputError(f"{path}, line {line}: segment '{words[0]}' has areas {first:g} and {last:g} cm²")
    loss, bed = ("" if len(words) <= i or words[i].upper() in _NONE else words[i] for i in (_LOSS, _BED))
    return _Segment(line, words[0], number, length, start, end, (first, last), loss, bed)


def _joined(
    path: Path, segments: list[_Segment], joints: dict[str, list[int]], pairs: list[tuple[str, str]]
) -> list[tuple[int, int]]:
    """Return every segment's two nodes by the joints: each is one, and so is an end that is in none."""
    place = {segment.number: row for row, segment in enumerate(segments)}
    starts, ends = ([-1] * len(segments) for _ in range(2))
    for joint, (inlet, outlet) in enumerate(pairs):
        for verb, names, side in (("end", inlet, ends), ("begin", outlet, starts)):
            numbers = joints.get(names, [])
            unknown = [number for number in numbers if number not in place]
            if not numbers or unknown:
                raise InputError(f"{path}: the joint of {inlet} and {outlet} needs known segments that {verb} in it")
            for number in numbers:
                if side[place[number]] >= 0:
                    raise InputError(f"{path}: segment {number} {verb}s in two joints; name it in one")
                side[place[number]] = joint
    first, after = len(pairs), len(pairs) + len(segments)
    starts = [first + row if node < 0 else node for row, node in enumerate(starts)]
    return list(zip(starts, (after + row if node < 0 else node for row, node in enumerate(ends)), strict=True))


def _word(path: Path, line: int, words: list[str], index: int) -> str:
    if index >= len(words):
        raise InputError(f"{path}, line {line}: the line ends too early; write the file again")
    return words[index]


def _whole(path: Path, line: int, word: str) -> int:
    value = number_in(path, line, word)
    if not np.isfinite(value) or value != int(value):
        raise InputError(f"{path}, line {line}: '{word[:40]}' is not a whole number")
    return int(value)


NETWORKS.register(NetworkFormat("svonedsolver", "svOneDSolver input", (".in",), is_input, read_input))
