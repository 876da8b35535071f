"""Edits that a review page proposes: what would answer each doubt about which vessels there are."""

from typing import NamedTuple

import numpy as np

from vasowave.imaging.extraction import Extraction
from vasowave.imaging.places import written
from vasowave.imaging.witness.doubts import Doubt


class Proposals(NamedTuple):
    """Edits that are proposed; none is made unless a person takes it up.

    Attributes
    ----------
    edits : list of str
        Lines of a file of edits, each a comment: why, then the edit.
    outlets : float array, shape (outlet, 3)
        Ends that only the second tree of the lumen has, z, y, x, cm, in the world.
    """

    edits: list[str]
    outlets: np.ndarray


def proposals(extraction: Extraction) -> Proposals:
    """Return what would answer the doubts about the topology.

    A doubted end may be removed and a doubted inner vessel merged into a point; a place where the tree has neither is
    an end that it lacks.
    """
    tree, names = extraction.tree.times(1 / extraction.factor), extraction.network.name
    ends = np.array([line.points[-1] for line in tree.lines])
    edits: list[str] = []
    outlets: list[np.ndarray] = []
    for doubt in (one for one in extraction.doubts if one.about == "topology"):
        lines = []
        for place in doubt.places:
            row = int(np.argmin(np.linalg.norm(ends - place, axis=1)))
            if not np.allclose(ends[row], place, atol=1e-9) or names[row] not in doubt.vessels:
                outlets.append(place)
                continue
            action = "remove" if row in tree.terminals else "merge"
            at = ends[row] if action == "remove" else tree.lines[row].points[len(tree.lines[row]) // 2]
            lines.append(f"# {action} {written(at).replace(',', ' ')}   # vessel {names[row]}")
        fresh = [line for line in lines if line not in edits]
        edits += [f"# {_why(doubt)}", *fresh] if fresh else []
    return Proposals(edits, np.array(outlets).reshape(-1, 3))


def _why(doubt: Doubt) -> str:
    return doubt.text if len(doubt.text) < 110 else f"{doubt.text[:108]} …"
