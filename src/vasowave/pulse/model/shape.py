"""How radius and stiffness change along the vessels: a vessel that tapers, or any other shape given by points."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np

from vasowave.base.errors import InputError
from vasowave.pulse.network.network import Network, measured_falls, tapers

Factors = float | Sequence[float] | Sequence[Sequence[float]] | np.ndarray
"""One number, one row of points for all vessels, or a row for each."""


@dataclass(frozen=True, eq=False)
class Shape:
    """Radius and stiffness along every vessel, as shares of its own: straight lines between evenly spaced points.

    Attributes
    ----------
    radius : array, shape (vessel, point)
        Radius at points from the inlet to the outlet over the network's radius of the vessel; two points are a linear
        taper. One row serves all vessels, one number all points.
    stiffness : array, shape (vessel, point)
        Likewise the factor of all parameters of the wall law that are pressures.

    Raises
    ------
    InputError
        A factor that is not positive and finite.

    Examples
    --------
    >>> import vasowave as vw
    >>> network = vw.control_network()
    >>> beds = vw.estimate_nominal(network, vw.virtual_mouse()).outlets
    >>> tapering = vw.Model(network, vw.LinearWall(60.0), beds, shape=vw.Shape([1.1, 0.9]))
    >>> wall, area0 = tapering.at([0, 0], [0.0, 1.0])  # at both ends of the first vessel
    >>> round(float(area0[1] / area0[0]), 4)  # (0.9/1.1)²
    0.6694
    """

    radius: Factors = 1.0
    stiffness: Factors = 1.0

    def __post_init__(self) -> None:
        """Keep both as tables, and check them."""
        for name in ("radius", "stiffness"):
            try:
                table: np.ndarray = np.atleast_2d(np.array(getattr(self, name), dtype=float))
            except (TypeError, ValueError):
                table = np.zeros((0, 0, 0))
            if table.ndim != 2 or not np.all(np.isfinite(table) & (table > 0)) or not table.size:
                raise InputError(f"shape: every {name} is a positive number, in one row or one row per vessel")
            table.setflags(write=False)
            object.__setattr__(self, name, table)

    def __repr__(self) -> str:
        return f"Shape(radius {_ends(self.radius)}, stiffness {_ends(self.stiffness)})"

    @classmethod
    def of(cls, network: Network, prior: float = 0.3) -> Self:
        """Return the linear tapers that a network was measured with; vessels whose taper is not known are straight.

        A taper that was measured with an error is drawn towards none by a prior of SD `prior`, in shares of the radius.
        A tree whose tapers are all within their errors is straight, so that noise does not choose what junctions share.

        Examples
        --------
        >>> import vasowave as vw
        >>> vw.Shape.of(vw.Network(("only",), [-1], [1.0], [0.05], taper=[0.02])).radius
        array([[1.2, 0.8]])
        """
        falls, _ = measured_falls(network, prior)
        return cls.falling(falls if tapers(network) else np.zeros_like(falls))

    @classmethod
    def falling(cls, fall: np.ndarray) -> Self:
        """Return linear tapers: what each vessel's radius falls from inlet to outlet, in shares of it."""
        return cls(1.0 + np.outer(fall, [0.5, -0.5]))

    @property
    def rows(self) -> tuple[int, int]:
        """Number of rows of both tables."""
        return len(np.asarray(self.radius)), len(np.asarray(self.stiffness))

    @cached_property
    def changes(self) -> np.ndarray:
        """True for a row where radius or stiffness change, or differ from the vessel's own; shape (vessel,) or (1,)."""
        return np.any(np.asarray(self.radius) != 1.0, axis=1) | self.stiffens

    @cached_property
    def stiffens(self) -> np.ndarray:
        """The same of the stiffness alone."""
        return np.any(np.asarray(self.stiffness) != 1.0, axis=1)

    @property
    def pieces(self) -> int:
        """Number of equal pieces of every vessel in which radius and stiffness change evenly."""
        return math.lcm(*(max(np.shape(table)[1] - 1, 1) for table in (self.radius, self.stiffness)))

    @cached_property
    def bend(self) -> np.ndarray:
        """Largest change of log radius, or of half the log of the stiffness, in a piece; shape (vessel,) or (1,).

        Both change the wave speed by as much.
        """
        places = np.linspace(0.0, 1.0, self.pieces + 1)
        rows = np.arange(max(self.rows))[:, np.newaxis]
        radius, stiffness = self.at(*np.broadcast_arrays(rows, places))
        return np.max(np.abs(np.diff([np.log(radius), 0.5 * np.log(stiffness)])), axis=(0, 2))

    def at(self, vessel: np.ndarray, share: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the factors of radius and stiffness in vessels (rows), at a share of their length from the inlet."""
        radius, stiffness = (_between(np.asarray(table), vessel, share) for table in (self.radius, self.stiffness))
        return radius, stiffness


def _ends(factors: Factors) -> str:
    """Return the factors at the inlet and at the outlet, of several vessels their medians, in words."""
    values = np.median(np.asarray(factors), axis=0)
    return f"{values[0]:.4g}" if np.all(values == values[0]) else f"{values[0]:.4g} to {values[-1]:.4g}"


def _between(table: np.ndarray, vessel: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Return the values of rows of a table between their points."""
    row = vessel if len(table) > 1 else np.zeros_like(vessel)
    place = np.clip(share, 0.0, 1.0) * (table.shape[1] - 1)
    lower = np.minimum(place.astype(int), max(table.shape[1] - 2, 0))
    upper = np.minimum(lower + 1, table.shape[1] - 1)
    return table[row, lower] + (place - lower) * (table[row, upper] - table[row, lower])
