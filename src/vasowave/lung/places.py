"""Places as people write them, x y z with a unit, and as the package holds them, z y x in cm."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt
from pydantic import BeforeValidator, SkipValidation

from vasowave.base import units
from vasowave.base.errors import InputError
from vasowave.base.io.columns import read_columns


@dataclass(frozen=True, eq=False)
class Frame:
    """How the axes of an image lie in the world, as viewers show it and as people write places.

    An extraction computes along the image's own axes, from the same first voxel; only where places come in and go out
    they are turned.

    Attributes
    ----------
    origin : float array, shape (3,)
        The first voxel, z, y, x, cm: the same place in both.
    axes : float array, shape (3, 3)
        Column k is the direction, in the world, of the image's k-th axis (z, y, x).
    """

    origin: np.ndarray
    axes: np.ndarray

    def world(self, points: npt.ArrayLike) -> np.ndarray:
        """Return points along the image's axes, shape (..., 3), in the world."""
        return self._turned(points, self.axes)

    def own(self, points: npt.ArrayLike) -> np.ndarray:
        """Return points of the world, shape (..., 3), along the image's axes."""
        return self._turned(points, np.linalg.inv(self.axes))

    def _turned(self, points: npt.ArrayLike, turn: np.ndarray) -> np.ndarray:
        places = np.asarray(points, dtype=float)
        straight = np.array_equal(turn, np.eye(3))  # then not a digit changes
        return places if straight else (places - self.origin) @ turn.T + self.origin


_FRAME: ContextVar[Frame | None] = ContextVar("frame", default=None)


@contextmanager
def written_in_the_world(frame: Frame) -> Iterator[None]:
    """Let `written` take places along the axes of `frame` and write them as they are in the world."""
    token = _FRAME.set(frame)
    try:
        yield
    finally:
        _FRAME.reset(token)


def parse_place(text: str) -> np.ndarray:
    """Return the place in ``"x,y,z"`` or ``"x y z unit"`` (cm where no unit is given) as z, y, x, cm.

    Raises
    ------
    InputError
        Not three finite numbers, or a unit that is none of length.
    """
    words = text.replace(",", " ").split()
    unit = words.pop() if words and not _is_number(words[-1]) else "cm"
    if len(words) != 3 or not all(_is_number(word) for word in words):
        raise InputError(f"'{text}' is not a place; write three numbers x,y,z and perhaps a unit: 0.91,1.2,0.45 cm")
    return place([float(word) for word in words], units.factor(unit, "length"))


def place(xyz: Sequence[float], unit: float = 1.0) -> np.ndarray:
    """Return x, y, z in `unit` (cm) as z, y, x, cm; `InputError` unless they are finite."""
    point = unit * np.array(xyz, dtype=float)[::-1]
    if not np.isfinite(point).all():
        raise InputError(f"the place {tuple(xyz)} is not finite")
    return point


def parse_places(texts: Sequence[str]) -> np.ndarray | None:
    """Return the places in `texts`, each a place (`parse_place`) or a table (`read_places`); None without any."""
    places = [read_places(text) if text.lower().endswith(".csv") else parse_place(text)[None] for text in texts]
    return np.concatenate(places) if places else None


def parse_region(text: str) -> Path | tuple[np.ndarray, np.ndarray]:
    """Return the file called `text`, or the corners of the box ``"x,y,z:x,y,z"`` as `parse_place`.

    Raises
    ------
    InputError
        Neither.
    """
    if Path(text).exists():
        return Path(text)
    corners = text.split(":")
    if len(corners) != 2:
        raise InputError(f"region '{text}': no such file, and no box x,y,z:x,y,z")
    return parse_place(corners[0]), parse_place(corners[1])


def read_places(path: str | Path) -> np.ndarray:
    """Return the places in a table with columns x, y, z and a unit in each header, shape (place, 3), z, y, x, cm.

    Raises
    ------
    InputError
        As `read_columns`; a column missing or without a unit.
    """
    table = read_columns(path)
    table.warn()
    return np.column_stack([table.numbers(table.require(axis), "length") for axis in ("z", "y", "x")])


def written(point: np.ndarray) -> str:
    """Return z, y, x (cm) as ``"x,y,z"``, to 0.1 µm, in the world where `written_in_the_world` says how it lies."""
    frame = _FRAME.get()
    point = point if frame is None else frame.world(point)
    return ",".join(f"{value:.5f}".rstrip("0").rstrip(".") for value in point[::-1])


def _is_number(text: str) -> bool:
    try:
        return bool(np.isfinite(float(text)))
    except ValueError:
        return False


def _read(value: Any, parse: Callable[[str], Any]) -> Any:
    return parse(value) if isinstance(value, str) else value


def _read_all(value: Any) -> Any:
    return parse_places(value) if isinstance(value, list) and all(isinstance(text, str) for text in value) else value


def parse_voxel(text: str) -> float | tuple[float, float, float]:
    """Return the edge of cubes in ``"0.002"``, or the edges in ``"x,y,z"`` as z, y, x; cm, or a unit behind them.

    Raises
    ------
    InputError
        Not one or three positive numbers, or a unit that is none of length.
    """
    words = text.replace(",", " ").split()
    unit = units.factor(words.pop(), "length") if words and not _is_number(words[-1]) else 1.0
    if len(words) not in (1, 3) or not all(_is_number(word) and float(word) > 0 for word in words):
        raise InputError(
            f"voxel size '{text}': write one positive number, or three as x,y,z, in cm or with a unit: 20 um"
        )
    sizes = [float(word) * unit for word in words]
    return sizes[0] if len(sizes) == 1 else (sizes[2], sizes[1], sizes[0])


def voxel_text(voxel: float | Sequence[float]) -> str:
    """Return what `parse_voxel` reads."""
    return ",".join(f"{float(edge):.6g}" for edge in np.atleast_1d(voxel)[::-1])


Place = Annotated[Sequence[float], SkipValidation, BeforeValidator(partial(_read, parse=parse_place))]
Places = Annotated[Sequence[Sequence[float]], SkipValidation, BeforeValidator(_read_all)]
Region = Annotated[
    Path | tuple[Sequence[float], Sequence[float]],
    SkipValidation,
    BeforeValidator(partial(_read, parse=parse_region)),
]
VoxelSize = Annotated[float | Sequence[float], SkipValidation, BeforeValidator(partial(_read, parse=parse_voxel))]
"""What is text is read as people write it; arrays are z, y, x, cm."""
