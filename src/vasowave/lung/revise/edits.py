"""Corrections of a tree by hand: a small text file that is replayed whenever the volume is extracted again.

One edit a line; ``#`` begins a comment; a place is x y z, as a viewer shows the image::

    unit   mm               unit of the places below it: cm (where none is given), mm, um
    root   12.1 3.4 5.0     the blood enters here, whatever the option says; once
    outlet 15.0 9.1 2.2     the network reaches these and no other; where no outlets are given otherwise
    remove 14.0 6.2 7.7     the vessel here goes, and all beyond it; a sister left alone continues the parent
    cut    14.0 6.2 7.7     the vessel here ends here; all beyond goes
    merge  14.0 6.2 7.7     the inner vessel here shrinks to a point: its two junctions are one
    move   14.0 6.2 7.7 14.2 6.2 7.9    the end of a vessel nearest to the first place goes to the second
    radius 14.0 6.2 7.7 0.31            the vessel here, of those that are left in the end, has this radius

Edits name places and not vessels, because vessels are numbered anew in every extraction. They act in the order of
the lines, each on what the ones above left.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from vasowave.base import units
from vasowave.base.errors import InputError, did_you_mean
from vasowave.base.findings import note_kind, warn
from vasowave.base.io.columns import NO_END
from vasowave.base.io.textfile import read_lines
from vasowave.base.stores import stored
from vasowave.lung.measure.measurement import Measurement
from vasowave.lung.options import Options
from vasowave.lung.places import place, written
from vasowave.lung.tree import Line, Tree, without

FILE = "edits.txt"
"""Edits of this name in the folder of an extraction are applied where no other file is named."""
APPLIED = note_kind(
    "image.edits-applied", "{count} edit(s) of {path} were applied; to extract without one, take out its line"
)
REACH = 3.0
"""An edit finds its vessel if its place is within this many radii of the vessel's axis."""


@dataclass(frozen=True, eq=False)
class Edit:
    """One line of the file.

    Attributes
    ----------
    action : {"root", "outlet", "remove", "cut", "merge", "move", "radius"}
    point : float array, shape (3,)
        Place, z, y, x, cm.
    where : str
        File and line, for messages.
    to : float array, shape (3,), optional
        Where a moved end goes, z, y, x, cm.
    radius : float, optional
        cm.
    """

    action: str
    point: np.ndarray
    where: str
    to: np.ndarray | None = None
    radius: float | None = None

    def turned(self, turn: Callable[[np.ndarray], np.ndarray]) -> "Edit":
        """Return the edit with its places where `turn` puts them."""
        return replace(self, point=turn(self.point), to=None if self.to is None else turn(self.to))


def with_edits_in(folder: Path, options: Options) -> Options:
    """Return `options` with the file of edits in the `folder` of an earlier extraction, unless they name one."""
    path = Path(folder) / FILE
    return replace(options, edits=path) if options.edits is None and path.is_file() else options


def applied(path: Path) -> tuple[Edit, ...]:
    """Return the edits of a file, and say how many there are.

    Raises
    ------
    InputError
        As `read_edits`.

    Warns
    -----
    VasowaveWarning
        A note, that there are edits.
    """
    edits = read_edits(path)
    if edits:
        warn(APPLIED(count=len(edits), path=str(path)))
    return edits


@stored("edits of a tree", "edits/*.txt")
def read_edits(path: str | Path) -> tuple[Edit, ...]:
    """Read a file of edits.

    Raises
    ------
    InputError
        Unreadable file, unknown action or unit, a place that is not three numbers, a second root, an edit that stands
        there twice; with the line.

    Warns
    -----
    VasowaveWarning
        The last line has no end, as in a file that was cut off.
    """
    edits: list[Edit] = []
    unit = 1.0
    for number, line in _lines(Path(path)):
        words = line.split("#")[0].replace(",", " ").split()
        if not words:
            continue
        where = f"{path}, line {number}"
        action = words[0].lower()
        if action == "unit":
            unit = _unit(words, where)
            continue
        if action not in _NUMBERS:
            vocabulary = ("unit", *_NUMBERS)
            hint = did_you_mean(action, vocabulary)
            raise InputError(f"{where}: unknown edit '{words[0]}'{hint}; there are: {', '.join(vocabulary)}")
        edits.append(_edit(action, words, unit, where))
        if action == "root" and sum(edit.action == "root" for edit in edits) > 1:
            raise InputError(f"{where}: a second root; a tree has one")
        same = (
            previous
            for previous in edits[:-1]
            if previous.action == action and np.allclose(previous.point, edits[-1].point, atol=1e-9)
        )
        twin = next(same, None)
        if twin is not None:
            raise InputError(f"{where}: the same edit as {twin.where}; remove one of them")
    return tuple(edits)


def _lines(path: Path) -> Iterator[tuple[int, str]]:
    """Yield number and text of each line."""
    try:
        for block in read_lines(path):
            yield from enumerate(block.texts, block.first)
            if block.cut:
                warn(NO_END().at(str(path)), stacklevel=4)
    except InputError as error:
        raise InputError(f"{path}: the edits cannot be read ({error}); they are plain text") from None


def root_of(edits: tuple[Edit, ...]) -> np.ndarray | None:
    """Return the place of the root that `edits` set, z, y, x, cm, or None."""
    return next((edit.point for edit in edits if edit.action == "root"), None)


def outlets_of(edits: tuple[Edit, ...]) -> np.ndarray | None:
    """Return the outlets that `edits` set, shape (outlet, 3), z, y, x, cm, or None without any."""
    outlets = [edit.point for edit in edits if edit.action == "outlet"]
    return np.array(outlets) if outlets else None


def edited(tree: Tree, edits: tuple[Edit, ...]) -> Tree:
    """Return `tree` after `edits`; the root is not moved here, since its place is an input of the extraction.

    Raises
    ------
    InputError
        No vessel at a place, an edit that would leave no root, a merge of the root or a terminal; with the line.
    """
    return edited_alike((tree,), edits)[0]


def edited_alike(trees: Sequence[Tree], edits: tuple[Edit, ...]) -> tuple[Tree, ...]:
    """Return `trees`, which have the same vessels along other axes, after the same edits; see `edited`.

    The vessel that an edit means is looked up in the first tree alone.
    """
    for edit in edits:
        if edit.action in _ACTIONS:
            row, point = _vessel_at(trees[0], edit)
            share = trees[0].lines[row].run[point] / trees[0].lines[row].length
            trees = tuple(_ACTIONS[edit.action](tree, row, share, edit) for tree in trees)
    return tuple(trees)


def _unit(words: list[str], where: str) -> float:
    if len(words) != 2:
        raise InputError(f"{where}: 'unit' takes one word: cm, mm or um")
    try:
        return units.factor(words[1], "length")
    except InputError as error:
        raise InputError(f"{where}: {error}") from None


def _edit(action: str, words: list[str], unit: float, where: str) -> Edit:
    """Return the edit of one line."""
    try:
        numbers = [float(word) for word in words[1:]]
        if len(numbers) != _NUMBERS[action][0]:
            raise ValueError
        to = place(numbers[3:], unit) if action == "move" else None
        radius = unit * numbers[3] if action == "radius" else None
        if radius is not None and not (np.isfinite(radius) and radius > 0):
            raise ValueError
        return Edit(action, place(numbers[:3], unit), where, to, radius)
    except (ValueError, InputError):
        values = " ".join(words[1:]) or "nothing"
        raise InputError(f"{where}: '{words[0]}' takes {_NUMBERS[action][1]}, not {values}") from None


def _vessel_at(tree: Tree, edit: Edit) -> tuple[int, int]:
    """Return row and point of the vessel at the place of `edit`."""
    distance = [np.linalg.norm(line.points - edit.point, axis=1) for line in tree.lines]
    row = int(np.argmin([gaps.min() for gaps in distance]))
    point = int(np.argmin(distance[row]))
    gap = distance[row][point]
    if gap > REACH * np.median(tree.lines[row].radius):
        raise InputError(
            f"{edit.where}: no vessel at {written(edit.point)} cm; the nearest axis passes {gap:.3g} cm away at "
            f"{written(tree.lines[row].points[point])}"
        )
    return row, point


def _removed(tree: Tree, row: int, share: float, edit: Edit) -> Tree:
    parent = int(tree.parent[row])
    if parent < 0:
        raise InputError(f"{edit.where}: this is the root; without it there is no tree")
    sisters = [daughter for daughter in tree.daughters(parent) if daughter != row]
    lines, parents = list(tree.lines), tree.parent.copy()
    gone = _beyond(tree, row)
    if len(sisters) == 1:  # no junction any more: the sister continues the parent
        sister = int(sisters[0])
        lines[parent] = lines[parent].then(lines[sister][1:])
        parents[parents == sister] = parent
        gone.add(sister)
    return without(lines, parents, gone)


def _cut(tree: Tree, row: int, share: float, edit: Edit) -> Tree:
    """Return `tree` with the vessel ending at a `share` of its length."""
    lines = list(tree.lines)
    point = int(np.argmin(np.abs(lines[row].run - share * lines[row].length)))
    if point < 1:
        raise InputError(f"{edit.where}: the place is where the vessel begins; use 'remove' to drop the whole vessel")
    lines[row] = lines[row][: point + 1]
    return without(lines, tree.parent.copy(), _beyond(tree, row) - {row})


def _merged(tree: Tree, row: int, share: float, edit: Edit) -> Tree:
    is_root = tree.parent[row] < 0
    if is_root or len(tree.daughters(row)) == 0:
        kind = "root" if is_root else "terminal vessel; use 'remove'"
        raise InputError(f"{edit.where}: 'merge' makes an inner vessel a point, but this is a {kind}")
    return tree.merged(row)


def _moved(tree: Tree, row: int, share: float, edit: Edit) -> Tree:
    """Return `tree` with the end of the vessel nearest to the place moved; what runs there bends with it."""
    assert edit.to is not None
    before = row if share >= 0.5 else int(tree.parent[row])  # the vessel that ends at what moves; -1: the inlet moves
    after = tree.daughters(before)
    start = tree.lines[row].points[-1 if before == row else 0]
    by = edit.to - start
    touched = [*([before] if before >= 0 else []), *after.tolist()]
    shortest = min(tree.lines[vessel].length for vessel in touched)
    if np.linalg.norm(by) > shortest:
        raise InputError(
            f"{edit.where}: the move of {np.linalg.norm(by):.3g} cm is longer than the shortest vessel that ends there "
            f"({shortest:.3g} cm); remove or merge it, or move by less"
        )
    lines = list(tree.lines)
    for vessel in touched:
        along = lines[vessel].run / lines[vessel].length
        weight = along if vessel == before else 1.0 - along
        lines[vessel] = Line(lines[vessel].points + weight[:, None] * by, lines[vessel].radius)
    return tree.with_lines(lines)


def with_radii(measured: Measurement, edits: tuple[Edit, ...]) -> Measurement:
    """Return `measured` with the radii that a person set; their SD is not known, and they count as reliable.

    Raises
    ------
    InputError
        No vessel at a place; with the line.
    """
    radius, sd, reliable = measured.network.radius.copy(), measured.radius_sd.copy(), measured.reliable.copy()
    for edit in edits:
        if edit.radius is not None:
            row, _ = _vessel_at(measured.tree, edit)
            radius[row], sd[row], reliable[row] = edit.radius, np.nan, True
    return replace(measured, network=replace(measured.network, radius=radius), radius_sd=sd, reliable=reliable)


_ACTIONS: dict[str, Callable[[Tree, int, float, Edit], Tree]] = {
    "remove": _removed, "cut": _cut, "merge": _merged, "move": _moved
}  # fmt: skip
_PLACE = (3, "three finite numbers x y z")
_NUMBERS = dict.fromkeys(("root", "outlet", "remove", "cut", "merge"), _PLACE) | {
    "move": (6, "two places x y z"), "radius": (4, "a place x y z and a radius above 0")
}  # fmt: skip
"""How many numbers stand behind each word, and what they are."""


def _beyond(tree: Tree, row: int) -> set[int]:
    """Return `row` and all rows beyond it (parents stand before daughters)."""
    rows = {row}
    for candidate, parent in enumerate(tree.parent):
        if parent in rows:
            rows.add(candidate)
    return rows
