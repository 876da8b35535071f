"""What goes in: an animal, and how it is to be analyzed."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from vasowave.blood import Blood
from vasowave.calibration import Search
from vasowave.calibration.parameters import fitted_parameters
from vasowave.errors import InputError, did_you_mean
from vasowave.laws import LAWS
from vasowave.network import Network
from vasowave.recording import EnsembleAverage, RawRecording, Recording, average_beats
from vasowave.solver import Numerics

WALLS = ("linear", "tangent")


@dataclass(frozen=True, eq=False)
class Animal:
    """One animal of a study.

    Attributes
    ----------
    name, group : str
    network : Network
    recording : Recording
        One averaged cycle.
    beats : EnsembleAverage, optional
        Where that cycle came from, if it was averaged here.
    raw : RawRecording, optional
        The continuous recording behind it; a few seconds of it are kept for the figure of beats.
    synthetic : bool
        Whether the recording was made and not measured.

    Raises
    ------
    InputError
        A name or group without a letter.
    """

    name: str
    group: str
    network: Network
    recording: Recording
    beats: EnsembleAverage | None = None
    raw: RawRecording | None = None
    synthetic: bool = False

    def __post_init__(self) -> None:
        """Check the names."""
        for what in ("name", "group"):
            if not str(getattr(self, what)).strip():
                raise InputError(f"an animal without a {what}; every animal needs one")

    @classmethod
    def from_raw(
        cls, name: str, group: str, network: Network, raw: RawRecording, *, synthetic: bool = False, **averaging: Any
    ) -> "Animal":
        """Return the animal of a continuous recording; `averaging` goes to `average_beats`."""
        beats = average_beats(raw, **averaging)
        return cls(name, group, network, beats.recording, beats, raw, synthetic)


@dataclass(frozen=True)
class Settings:
    """How an animal is analyzed.

    Attributes
    ----------
    walls : tuple of {"linear", "tangent"}
        Wall laws to calibrate.
    starts : int
        Starts of every calibration; the paper took 4.
    method : {"least-squares", "sqp"}
    paper_bounds : bool
        The paper's bounds instead of wide ones.
    bounds : mapping of str to (float, float)
        Own bounds of parameters, in their units; each applies to the laws that have the parameter.
    fixed : mapping of str to float
        Parameters held at a value, likewise.
    seed : int
        Of the starts.
    selection : bool
        Compare the wall laws by AICc and BIC (needs two of them).
    selection_optima : tuple of str
        Where: at the optimum of ordinary ("OLS") or of generalized least squares ("GLS", a minute an animal), or both.
    blood : Blood
    numerics : Numerics, optional
        By default those of `calibrate`.
    harmonics : int
        Highest harmonic of the impedance spectra.

    Raises
    ------
    InputError
        An unknown law or parameter, the same law twice, or a value `Search` refuses.
    """

    walls: tuple[str, ...] = WALLS
    starts: int = 20
    method: str = "least-squares"
    paper_bounds: bool = False
    bounds: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    fixed: Mapping[str, float] = field(default_factory=dict)
    seed: int = 0
    selection: bool = False
    selection_optima: tuple[str, ...] = ("OLS",)
    blood: Blood = field(default_factory=Blood)
    numerics: Numerics | None = None
    harmonics: int = 14

    def __post_init__(self) -> None:
        """Check the values."""
        object.__setattr__(self, "walls", tuple(self.walls))
        for wall in self.walls:
            if wall not in WALLS:
                raise InputError(f"unknown wall law '{wall}'{did_you_mean(wall, WALLS)}; there are: {', '.join(WALLS)}")
        if len(set(self.walls)) < len(self.walls):
            raise InputError(f"walls {', '.join(self.walls)}: each law once")
        known = {name: None for wall in LAWS for name in fitted_parameters(wall)}
        for name in (*self.bounds, *self.fixed):
            if name not in known:
                raise InputError(f"no parameter '{name}'{did_you_mean(name, known)}; there are: {', '.join(known)}")
        object.__setattr__(self, "selection_optima", tuple(self.selection_optima))
        if not self.selection_optima or set(self.selection_optima) - {"OLS", "GLS"}:
            raise InputError(f"selection_optima {self.selection_optima}: give 'OLS', 'GLS' or both")
        if self.harmonics < 1:
            raise InputError(f"harmonics {self.harmonics}: at least one")
        self.search(self.walls[0] if self.walls else "linear")

    def search(self, wall: str) -> Search:
        """Return how to search with one wall law: the bounds and fixed values of the parameters that it has."""
        own = fitted_parameters(wall)
        bounds = {name: (float(low), float(high)) for name, (low, high) in self.bounds.items() if name in own}
        fixed = {name: float(value) for name, value in self.fixed.items() if name in own}
        return Search(self.starts, self.method, self.paper_bounds, bounds, fixed, self.seed)

    def as_json(self) -> str:
        """Return all settings as text that does not depend on the order in which they were given."""
        friction = {"law": type(self.blood.friction).__name__, **asdict(self.blood.friction)}  # type: ignore[call-overload]
        plain = asdict(self)
        plain["blood"] = {"density": self.blood.density, "viscosity": self.blood.viscosity, "friction": friction}
        return json.dumps(plain, sort_keys=True)
