"""An animal, and the settings of its analysis."""

import json
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass, field
from importlib.metadata import entry_points
from typing import Annotated, Any, Literal

from annotated_types import Ge
from pydantic import BeforeValidator

from vasowave.base.errors import InputError, did_you_mean
from vasowave.base.settings import Check, Names, settings_class, settings_of
from vasowave.catheter.ensemble import average_beats
from vasowave.catheter.signals.raw import RawRecording
from vasowave.pulse.analysis.operating import WavesAt
from vasowave.pulse.analysis.ventricular_function import VentricularFunction
from vasowave.pulse.calibration.fitting import NUMERICS, Search
from vasowave.pulse.calibration.parameters import fitted_parameters
from vasowave.pulse.cycle.averaged import EnsembleAverage
from vasowave.pulse.cycle.cycle import Recording
from vasowave.pulse.cycle.observation import Observation
from vasowave.pulse.cycle.ventricular import VentricularPressure
from vasowave.pulse.inference.known_errors import KnownErrors
from vasowave.pulse.inference.priors import Priors
from vasowave.pulse.model.blood import Blood
from vasowave.pulse.model.law_files import is_unread, named
from vasowave.pulse.model.laws import BEDS, ENTRY_POINTS, LAWS, find_bed, find_law
from vasowave.pulse.model.numerics import Numerics
from vasowave.pulse.network.network import Network
from vasowave.pulse.noise.fitting import NOISE, Name
from vasowave.study.animal.result import check_law_names


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
    sites : tuple of Observation
        What was observed elsewhere.
    ventricle : VentricularPressure, optional
        The pressure in the ventricle that ejects into the network.
    loops : VentricularFunction, optional
        What loops of pressure and volume tell of a ventricle.

    Raises
    ------
    InputError
        A name or group without a letter.

    Examples
    --------
    >>> import vasowave as vw
    >>> vw.Animal("mouse 6", "CTL", vw.control_network(), vw.virtual_mouse(), synthetic=True).name
    'mouse 6'
    """

    name: str
    group: str
    network: Network
    recording: Recording
    beats: EnsembleAverage | None = None
    raw: RawRecording | None = None
    synthetic: bool = False
    sites: tuple[Observation, ...] = ()
    ventricle: VentricularPressure | None = None
    loops: VentricularFunction | None = None

    def __post_init__(self) -> None:
        """Check the names."""
        for attribute in ("name", "group"):
            if not str(getattr(self, attribute)).strip():
                raise InputError(f"an animal without a {attribute}; every animal needs one")

    @classmethod
    def from_raw(
        cls, name: str, group: str, network: Network, raw: RawRecording, *, synthetic: bool = False, **averaging: Any
    ) -> "Animal":
        """Return the animal of a continuous recording; `averaging` goes to `average_beats`."""
        beats = average_beats(raw, **averaging)
        return cls(name, group, network, beats.recording, beats, raw, synthetic)


def _walls() -> list[str]:
    return [*LAWS, *(point.name for point in entry_points(group=ENTRY_POINTS))]


def _is_law(find: Callable[[str], Any], names: Callable[[], Iterable[str]]) -> Check:
    """Return the condition that `find` knows a name; an editor is told the `names`, or that it is module:Class."""

    def checked(name: str) -> str:
        if not is_unread(name):
            find(name)
        return name

    return Check(checked, lambda: {"anyOf": [{"enum": [*names()]}, {"pattern": ":"}]})


def _each_once(names: tuple[str, ...]) -> tuple[str, ...]:
    if not names or len(set(names)) < len(names):
        raise InputError(f"{', '.join(map(str, names)) or 'nothing'}: choose at least one, each once")
    return names


@settings_class
class Laws:
    """The laws of walls and beds."""

    walls: Annotated[
        tuple[Annotated[str, BeforeValidator(named), _is_law(find_law, _walls)], ...], Check(_each_once), Names(_walls)
    ] = ("linear", "tangent")
    """Wall laws to fit, by name ({names}), or a class of your own as module:Class; see `laws.find_law`."""
    beds: Annotated[str, BeforeValidator(named), _is_law(find_bed, BEDS.keys), Names(BEDS.keys)] = "windkessel"
    """Vascular beds behind the terminal vessels, by name ({names}), or a class of your own as module:Class; see
    `laws.find_bed`."""


@settings_class
class Calibration(Search, Laws):
    """The fit of each wall law to each recording."""


@settings_class
class Analysis(KnownErrors):
    """The analyses of an animal beside its fits, and the errors that are known."""

    model_selection: bool = True
    """Whether the wall laws are compared by AICc and BIC."""
    noise_models: Annotated[tuple[Name, ...], Check(_each_once)] = NOISE
    """Under which models of the noise; the paper's practice asks for its own, too."""
    waves_at: WavesAt = "mean pressure"
    """Where waves take area and wave speed from: at mean pressure, measurement and models alike, or as the paper: A0
    and A0 Z_c/ρ for the measurement, those of each instant for a model."""
    inference: Literal["intervals", "reference", "posterior"] = "intervals"
    """What is said of the parameters beside their best values: the intervals of fits, or posteriors too, with geometry
    and the model's own error unknown: of the first wall law alone (reference), on which the answer stands unless
    `report.law` names another, or of every law (posterior). One takes 3 to 10 s of a processor."""


@settings_class
class Settings(Analysis, Calibration):
    """How an animal is analyzed: the laws, how to search (see `Search`), and what else is computed.

    Raises
    ------
    InputError
        An unknown law or parameter, the same law twice, or a value outside its limits.

    Examples
    --------
    >>> import vasowave as vw
    >>> vw.Settings(walls=("linear", "power"), starts=8).starts
    8
    """

    blood: Blood = field(default_factory=Blood)
    """Density, viscosity and friction."""
    numerics: Numerics = NUMERICS
    """How finely fits are simulated."""
    harmonics: Annotated[int, Ge(1)] = 14
    """Highest harmonic of the impedance spectra."""

    def __post_init__(self) -> None:
        """Check what belongs together."""
        names = [find_law(wall).law().name for wall in self.walls if not is_unread(wall)]
        if len(set(names)) < len(names):
            raise InputError(f"{', '.join(names)}: two of these wall laws have one name; give each law() its own")
        check_law_names(names)
        known_names = known_parameters(self.walls, self.beds, self.viscous) if self.bounds or self.fixed else []
        unread = any(map(is_unread, (*self.walls, self.beds)))  # whose parameters nobody knows
        for name in (*self.bounds, *self.fixed):
            if name not in known_names and not (unread and "." in name):
                raise InputError(
                    f"no parameter '{name}'{did_you_mean(name, known_names)}; there are: {', '.join(known_names)}"
                )

    def search(self, wall: str | type) -> Search:
        """Return how to search with one wall law: the bounds and fixed values of the parameters that it has."""
        parameters = fitted_parameters(wall, self.beds, self.viscous)
        values = {name: getattr(self, name) for name in settings_of(Search)}
        mine = {
            name: {key: values[name][key] for key in values[name] if key in parameters} for name in ("bounds", "fixed")
        }
        return Search(**values | mine)

    @property
    def sampled_walls(self) -> tuple[str, ...]:
        """Those of the wall laws whose posteriors are asked for."""
        return self.walls[: {"intervals": 0, "reference": 1, "posterior": len(self.walls)}[self.inference]]

    @property
    def priors(self) -> Priors:
        """The priors of its posteriors: the errors that are known, and the usual ones."""
        return Priors(**{name: getattr(self, name) for name in settings_of(KnownErrors)})

    def as_json(self) -> str:
        """Return all settings as text that does not depend on the order in which they were given."""
        friction = {"law": type(self.blood.friction).__name__, **asdict(self.blood.friction)}  # type: ignore[call-overload]
        plain = {key: value for key, value in asdict(self).items() if value is not None}
        plain["blood"] = {"density": self.blood.density, "viscosity": self.blood.viscosity, "friction": friction}
        return json.dumps(plain, sort_keys=True)


def known_parameters(walls: Sequence[str], bed: str = "windkessel", viscous: bool | None = None) -> list[str]:
    """Return the parameters that the beds, and the wall laws `walls` or those of `laws.LAWS`, have.

    A law or bed whose program must not run adds none.
    """
    read, bed = [wall for wall in walls if not is_unread(wall)], "windkessel" if is_unread(bed) else bed
    return list(dict.fromkeys(name for wall in (*LAWS, *read) for name in fitted_parameters(wall, bed, viscous)))
