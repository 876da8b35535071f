"""The model of one animal: a network, its walls, its outlets and its blood, checked together."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from vasowave.blood import Blood
from vasowave.errors import InputError
from vasowave.network import Network
from vasowave.outlets import ImpedanceSpectrum, Outlets, Windkessel
from vasowave.walls import Wall


@dataclass(frozen=True, eq=False)
class Model:
    """Everything a simulation needs besides its inflow.

    Attributes
    ----------
    network : Network
    wall : LinearWall or TangentWall
        Parameters as one number for all vessels or one per vessel; kept as one per vessel.
    outlets : Windkessel or ImpedanceSpectrum
        One value per terminal vessel, in the order of ``network.terminals``.
    blood : Blood

    Raises
    ------
    InputError
        A parameter that is not a positive finite number or has the wrong shape; the vessel is named.
    """

    network: Network
    wall: Any
    outlets: Outlets
    blood: Blood = field(default_factory=Blood)

    def __post_init__(self) -> None:
        """Expand every parameter to one value per vessel or terminal, and check it."""
        if not isinstance(self.wall, Wall):
            raise InputError(f"{self.wall!r} is not a wall law; use LinearWall(beta) or TangentWall(p1, gamma)")
        everywhere = np.arange(len(self.network))
        wall = _expanded(self.wall, everywhere, self.network, "wall")
        object.__setattr__(self, "wall", wall)
        terminals = self.network.terminals
        if isinstance(self.outlets, Windkessel):
            object.__setattr__(self, "outlets", _expanded(self.outlets, terminals, self.network, "outlet"))
        elif isinstance(self.outlets, ImpedanceSpectrum):
            _check_spectrum(self.outlets, terminals, self.network)
        else:
            raise InputError(f"{self.outlets!r} is not an outlet; use Windkessel(R1, R2, C) or ImpedanceSpectrum(Z)")

    def __repr__(self) -> str:
        parameters = ", ".join(
            f"{name} {np.median(value):.4g}" for name, value in zip(self.wall._fields, self.wall, strict=True)
        )
        return f"Model({type(self.wall).__name__}({parameters}), {type(self.outlets).__name__}, {self.network!r})"

    def changed(self, **parts: Any) -> "Model":
        """Return a model with other parts: ``model.changed(wall=LinearWall(60.0))``."""
        return replace(self, **parts)


def _expanded(values: Any, rows: np.ndarray, network: Network, what: str) -> Any:
    """Return the NamedTuple with every field as a positive array over `rows`."""
    fields = []
    for name, value in zip(values._fields, values, strict=True):
        try:
            array = np.array(np.broadcast_to(np.asarray(value, dtype=float), rows.shape))
        except (TypeError, ValueError):
            raise InputError(
                f"{what} parameter {name} has shape {np.shape(value)}; give one number or {len(rows)} values"
            ) from None
        bad = np.flatnonzero(~(np.isfinite(array) & (array > 0)))
        if len(bad):
            raise InputError(
                f"vessel '{network.name[rows[bad[0]]]}': {what} parameter {name} = {array[bad[0]]:g}; "
                "it must be positive and finite"
            )
        array.setflags(write=False)
        fields.append(array)
    return type(values)(*fields)


def _check_spectrum(outlets: ImpedanceSpectrum, terminals: np.ndarray, network: Network) -> None:
    Z = np.asarray(outlets.Z)
    if Z.ndim != 2 or Z.shape[1] != len(terminals) or len(Z) < 2:
        raise InputError(
            f"impedance spectrum has shape {Z.shape}; "
            f"it must be (harmonics, {len(terminals)}): one column per terminal vessel"
        )
    bad = np.flatnonzero(~np.all(np.isfinite(Z), axis=0) | (Z[0].real <= 0) | (Z[-1].real < 0))
    if len(bad):
        raise InputError(
            f"vessel '{network.name[terminals[bad[0]]]}': its impedance is not finite, "
            "or its resistance is not positive"
        )
