"""The tree of one animal as a netCDF-4 file, written whole or not at all."""

import os
import tempfile
from pathlib import Path

import xarray as xr

from vasowave.errors import InputError

KIND = "vasowave animal"
"""Title of the files; a file with another title is not one of ours."""


def write_tree(tree: xr.DataTree, path: Path) -> None:
    """Write the tree of one animal to the netCDF-4 file `path`, whole or not at all.

    Raises
    ------
    InputError
        The file cannot be written; what stood there before is untouched.
    """
    path = Path(path)
    unfinished = None
    try:
        handle, name = tempfile.mkstemp(prefix=f".{path.name}-", suffix=".part", dir=path.parent)
        os.close(handle)
        unfinished = Path(name)
        tree.to_netcdf(unfinished, engine="netcdf4", format="NETCDF4")
        with unfinished.open("rb+") as file:
            os.fsync(file.fileno())  # a file that has its final name is complete, also after a power cut
        unfinished.chmod(0o644)
        os.replace(unfinished, path)
    except (OSError, RuntimeError) as error:  # the netCDF library reports a full disk as RuntimeError
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{path}: cannot be written ({reason}); choose another place or make room") from None
    finally:
        if unfinished is not None:
            unfinished.unlink(missing_ok=True)


def read_tree(path: Path) -> xr.DataTree:
    """Return the tree of one animal from a file that `write_tree` made, wholly in memory; the file is closed again.

    Raises
    ------
    InputError
        No such file, not netCDF-4, damaged, or of other origin.
    """
    path = Path(path)
    if not path.is_file():
        raise InputError(f"{path}: there is no such file")
    try:
        tree = load_file(path)
    except (OSError, RuntimeError, ValueError, KeyError) as error:
        raise InputError(f"{path}: not a netCDF-4 file, or damaged ({error}); make it again") from None
    if tree.attrs.get("title") != KIND:
        raise InputError(f"{path}: not the result of one animal (its title is not '{KIND}')")
    return tree


def load_file(path: Path) -> xr.DataTree:
    """Return all groups of a netCDF-4 file wholly in memory; the file is closed again."""
    with xr.open_datatree(path, engine="netcdf4", decode_timedelta=False) as tree:
        for node in tree.subtree:
            # DataTree.load passes over a variable that is called like a group (here 'nominal').
            for variable in node.variables.values():
                variable.load()
    return tree
