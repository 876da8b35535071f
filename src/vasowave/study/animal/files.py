"""The result of one animal as a netCDF-4 file that xarray, MATLAB and R open.

Every group, variable and attribute is written with one opening of the file and read likewise; xarray opens the file
anew for every group, which takes twenty times as long. Files are made and read in memory, so that a full disk is told
by the system and not by the library, and bytes can be checked before the library sees them.
"""

import hashlib
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np
import xarray as xr

from vasowave.base.errors import InputError
from vasowave.base.io.files import write_file
from vasowave.base.io.remembered import remembered
from vasowave.base.io.textfile import regular_file
from vasowave.base.stores import parsed_as, stored
from vasowave.pulse.inference.model_emulator import KIND, ModelEmulator
from vasowave.study.animal.failure import Failure
from vasowave.study.animal.result import FAILURES, AnimalResult

_INITIAL_BYTES = 1 << 20  # bytes to begin with; the library takes more as it needs
_UNREADABLE = (OSError, RuntimeError, ValueError, LookupError, ArithmeticError, AttributeError, TypeError)
_HEAP = b"GCOL\x01\x00\x00\x00"  # begins a collection of texts, version 1
_LIBRARY = Lock()  # two threads in it at once end the process


def write_result(result: AnimalResult, path: Path) -> None:
    """Write the result of one animal to the netCDF-4 file `path`, whole or not at all.

    Raises
    ------
    InputError
        The file cannot be written; what stood there before is untouched.
    """
    write_file(Path(path), to_bytes(result.to_datatree()))


@stored("result of an animal", "results/animals/*.nc")
def read_result(path: Path, sha256: str | None = None, laws: bool = True) -> AnimalResult:
    """Return the result of one animal from a file that `write_result` made, wholly in memory; the file is closed again.

    Parameters
    ----------
    path : Path
    sha256 : str, optional
        What the file's SHA-256 must be; it is compared before anything else is done.
    laws : bool
        Whether to read what the wall laws say; without them it is quick.

    Raises
    ------
    InputError
        No such file, other content than `sha256` says, not netCDF-4, damaged, or of other origin.
    """
    path = Path(path)
    try:
        content = (path if not path.exists() else regular_file(path)).read_bytes()
    except OSError as error:
        lost = isinstance(error, FileNotFoundError)
        reason = "there is no such file; run the study, which makes it anew" if lost else error.strerror
        raise InputError(f"{path}: cannot be read ({reason})") from None
    if sha256 is not None and hashlib.sha256(content).hexdigest() != sha256:
        raise InputError(f"{path}: damaged or changed since it was written (SHA-256); run again, it is made anew")
    try:
        result = AnimalResult.from_datatree(from_bytes(content, laws))
        _ = result.findings, *map(str, result.assumed_errors)  # which are read where they are shown, too late then
        return result
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    except _UNREADABLE as error:
        raise InputError(f"{path}: not a netCDF-4 file, or damaged ({error}); make it again") from None


def write_emulator(emulator: ModelEmulator, path: str | Path) -> Path:
    """Write an emulator as netCDF, whole or not at all; returns the path. Raises `InputError` where it cannot be."""
    data = emulator.data.assign_attrs(sha256=_digest(emulator.data))
    return write_file(Path(path), to_bytes(xr.DataTree(data)))


def _digest(data: xr.Dataset) -> str:
    values = [(str(name), variable.values.tolist()) for name, variable in data.variables.items()]
    return hashlib.sha256(repr([data.attrs.get("source"), *sorted(values)]).encode()).hexdigest()


@stored("emulator of an animal", "*.nc")
def read_emulator(path: str | Path) -> ModelEmulator:
    """Return the emulator that `ModelEmulator.to_netcdf` wrote.

    Raises
    ------
    InputError
        No such file, or one that is no emulator, is damaged, or was changed.

    Examples
    --------
    >>> import vasowave as vw
    >>> network = vw.Network(("1",), [-1], [0.4], [0.05])  # a quick one: one vessel, and one unknown
    >>> search = vw.Search(starts=1, fixed={"r1": 1.0, "r2": 1.0, "c1": 1.0})
    >>> fit = vw.calibrate(network, vw.virtual_mouse(), search=search)
    >>> path = vw.emulate(fit).to_netcdf("emulator.nc")
    >>> list(vw.read_emulator(path).box.index)
    ['beta']
    """
    path = Path(path)
    try:
        data = from_bytes(regular_file(path).read_bytes()).to_dataset()
        if data.attrs.get("title") != KIND or data.attrs.get("sha256") != _digest(data):
            raise ValueError("no emulator, or changed since it was written by its SHA-256")
        return ModelEmulator(data)
    except _UNREADABLE as error:
        raise InputError(f"{path}: cannot be read ({error}); make it again") from None


def to_bytes(tree: xr.DataTree) -> bytes:
    """Return a tree of labelled data as the bytes of a netCDF-4 file, encoded as xarray does it."""
    import netCDF4

    values: list[tuple[Any, np.ndarray]] = []
    with _LIBRARY:
        file = netCDF4.Dataset("result.nc", "w", format="NETCDF4", memory=_INITIAL_BYTES)
        for node in tree.subtree:
            values += _define(file if node.path == "/" else file.createGroup(node.path), node.to_dataset(inherit=False))
        for stored, array in values:  # after everything is defined: between two definitions the library tidies the file
            stored[...] = array
        return bytes(file.close())


@remembered
def failures_in(path: Path) -> tuple[Failure, ...]:
    """Return what failed of an animal by the file of its result, of which no more is read; none of a damaged file."""
    import netCDF4

    try:
        with _LIBRARY, netCDF4.Dataset("result.nc", "r", memory=_with_sound_heaps(path.read_bytes())) as file:
            return parsed_as(tuple[Failure, ...], file.getncattr(FAILURES))
    except (OSError, AttributeError, ValueError, TypeError):
        return ()


def from_bytes(content: bytes, laws: bool = True) -> xr.DataTree:
    """Return the tree that `to_bytes` made bytes of, or what of it belongs to no wall law."""
    import netCDF4

    groups: dict[str, xr.Dataset] = {}
    with _LIBRARY, netCDF4.Dataset("result.nc", "r", memory=_with_sound_heaps(content)) as file:
        file.set_auto_maskandscale(False)
        _read_groups(file, "/", groups, laws)
    return xr.DataTree.from_dict(groups)


def _with_sound_heaps(content: bytes) -> bytes:
    """Return the bytes of an HDF5 file; `ValueError` where a heap of texts has a gap of no size, over which HDF5 hangs.

    HDF5 File Format Specification 3.0, III.E: a collection is GCOL, its size, and objects of a header and bytes.
    """
    start = content.find(_HEAP)
    while start >= 0:
        place, end = start + 16, start + int.from_bytes(content[start + 8 : start + 16], "little")
        while place + 16 <= min(end, len(content)):
            number, size = (
                int.from_bytes(content[place + low : place + high], "little") for low, high in ((0, 2), (8, 16))
            )
            if number == 0 and size == 0:
                raise ValueError(f"a gap of no size at byte {place}")
            place += 16 + -(-size // 8) * 8 if number else size
        start = content.find(_HEAP, start + 1)
    return content


def _define(group: Any, data: xr.Dataset) -> list[tuple[Any, np.ndarray]]:
    """Define the variables of `data` in `group`; return each with the values that belong into it."""
    values = []
    group.setncatts(data.attrs)
    for dim, size in data.sizes.items():
        group.createDimension(dim, size)
    secondary = [name for name in data.coords if name not in data.dims]
    for name, variable in data.variables.items():
        attributes, array = dict(variable.attrs), variable.values
        if array.dtype == bool:
            attributes["dtype"], array = "bool", array.astype("i1")
        if array.dtype.kind in "OU":
            stored, array = group.createVariable(name, str, variable.dims), array.astype(object)
        else:
            stored = group.createVariable(name, array.dtype, variable.dims, fill_value=False)
        coordinates = [str(coordinate) for coordinate in secondary if set(data[coordinate].dims) <= set(variable.dims)]
        if coordinates and name not in data.coords:
            attributes["coordinates"] = " ".join(coordinates)
        stored.setncatts(attributes)
        values.append((stored, array))
    return values


def _read_groups(group: Any, path: str, groups: dict[str, xr.Dataset], laws: bool) -> None:
    """Add the data of `group` and of all groups in it to `groups`."""
    variables = {name: _read_variable(stored) for name, stored in group.variables.items()}
    coordinates = {name for name, variable in variables.items() if variable.dims == (name,)}
    for variable in variables.values():
        coordinates.update(variable.attrs.pop("coordinates", "").split())
    data = {name: variable for name, variable in variables.items() if name not in coordinates}
    along = {name: variable for name, variable in variables.items() if name in coordinates}
    groups[path] = xr.Dataset(data, along, _attributes(group))
    for name, inner in group.groups.items():
        if laws or "calibration" not in inner.groups:
            _read_groups(inner, f"{path.rstrip('/')}/{name}", groups, laws)


def _read_variable(stored: Any) -> xr.Variable:
    attributes, values = _attributes(stored), stored[...]
    attributes.pop("_FillValue", None)  # xarray's own files have one, of which it says nothing when it reads
    if attributes.pop("dtype", None) == "bool":
        values = np.asarray(values).astype(bool)
    return xr.Variable(stored.dimensions, values, attributes)


def _attributes(owner: Any) -> dict[str, Any]:
    return {name: owner.getncattr(name) for name in owner.ncattrs()}
