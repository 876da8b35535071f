"""The results file of a study: the trees of all animals, what failed and why, and the settings."""

import json
from dataclasses import dataclass
from pathlib import Path

import xarray as xr

from vasowave.animal.files import load_file
from vasowave.errors import InputError
from vasowave.provenance import provenance
from vasowave.study.settings import StudyFile
from vasowave.study.store import replace_file

RESULTS_FILE = "results.nc"
_KIND = "vasowave study"


@dataclass(frozen=True, eq=False)
class Outcome:
    """What came out of a study.

    Attributes
    ----------
    trees : dict of str to DataTree
        The tree of every animal that was analyzed, in the order of the table.
    failures : dict of str to str
        Every animal that failed, and why.
    settings : StudyFile
        The settings it was run with.
    """

    trees: dict[str, xr.DataTree]
    failures: dict[str, str]
    settings: StudyFile


def write_outcome(outcome: Outcome, folder: Path) -> Path:
    """Write the results file, one group per animal, whole or not at all."""
    tree = xr.DataTree.from_dict(
        {
            f"/{name}{path}".rstrip("/"): node.to_dataset(inherit=False)
            for name, animal in outcome.trees.items()
            for path, node in _nodes(animal)
        }
    )
    tree.attrs = {
        "title": _KIND,
        "Conventions": "CF-1.11",
        "animals": json.dumps(list(outcome.trees), ensure_ascii=False),
        "failures": json.dumps(outcome.failures, ensure_ascii=False),
        "study": outcome.settings.model_dump_json(),
        **provenance(),
    }
    path = folder / RESULTS_FILE
    replace_file(path, lambda part: tree.to_netcdf(part, engine="netcdf4", format="NETCDF4"))
    return path


def read_outcome(folder: Path) -> Outcome:
    """Read the results file.

    Raises
    ------
    InputError
        There is none, or it is damaged or of other origin.
    """
    path = folder / RESULTS_FILE
    if not path.is_file():
        raise InputError(f"{path}: there are no results yet; `vasowave run` makes them")
    try:
        tree = load_file(path)
    except (OSError, RuntimeError, ValueError, KeyError) as error:
        raise InputError(f"{path}: damaged ({error}); remove it and run again, what had finished is kept") from None
    if tree.attrs.get("title") != _KIND:
        raise InputError(f"{path}: not the results of a study (its title is not '{_KIND}')")
    names = json.loads(tree.attrs["animals"])
    trees = {
        name: xr.DataTree.from_dict({at: node.to_dataset(inherit=False) for at, node in _nodes(tree.children[name])})
        for name in names
    }
    settings = StudyFile.model_validate_json(tree.attrs["study"])
    return Outcome(trees, json.loads(tree.attrs["failures"]), settings)


def _nodes(tree: xr.DataTree) -> list[tuple[str, xr.DataTree]]:
    """Return every node of a tree with its path below the tree's own root."""
    above = len(tree.path.rstrip("/"))
    return [(node.path[above:] or "/", node) for node in tree.subtree]
