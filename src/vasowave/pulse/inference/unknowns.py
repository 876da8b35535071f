"""The unknowns of one animal: names, units, priors, and the model that their values make."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from vasowave.base.errors import InputError
from vasowave.pulse.calibration.parameters import ParameterSpace
from vasowave.pulse.cycle.cycle import Recording
from vasowave.pulse.inference.known_errors import Observed, kinds
from vasowave.pulse.inference.priors import Priors
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.names import ParameterName, joined, resolved
from vasowave.pulse.model.nominal import Nominal
from vasowave.pulse.model.outlets import Site
from vasowave.pulse.model.parameters import model_fields
from vasowave.pulse.model.shape import Shape
from vasowave.pulse.network.network import Network, measured_falls


class Unknown(NamedTuple):
    """One unknown number and its normal prior, which is that of its logarithm if the number is positive.

    Attributes
    ----------
    unit, meaning : str
    center : float
        Median.
    spread : float
        SD of the logarithm, or of the number itself.
    positive : bool
    source : str
        Where ignorance of it comes from: ``recording`` (what it is measured by), ``image``, ``probe``, ``calibration``
        or ``model``.
    """

    unit: str
    meaning: str
    center: float
    spread: float
    positive: bool
    source: str

    def value(self, score: np.ndarray) -> np.ndarray:
        """Return the number whose distance from the center is `score` SD of the prior."""
        if not self.positive:
            return self.center + self.spread * score
        with np.errstate(over="ignore"):  # what is infinite is refused as a model
            return self.center * np.exp(self.spread * score)


@dataclass(frozen=True, eq=False)
class Unknowns:
    """All unknowns. A point is given by scores, shape (unknown,): distances from the medians in SD of the prior.

    In scores every prior is the standard normal distribution.

    Attributes
    ----------
    space : ParameterSpace
        The law, the parameters, and what is held.
    nominal : Nominal
    priors : Priors
    recording : Recording
    zero_enters : bool
        Whether the zero of the pressure is one of them: it is where the pressure enters the model. Else it moves the
        mean of the measured pressure alone, which a covariance says.
    taper_enters : bool
        Whether the taper that nobody measured is one of them, for derivatives. Posteriors have what it changes in a
        covariance: junctions of a tree that tapers share another pressure, a step that no emulator learns.
    """

    space: ParameterSpace
    nominal: Nominal
    priors: Priors
    recording: Recording
    zero_enters: bool = False
    taper_enters: bool = False

    def __post_init__(self) -> None:
        """Check that priors speak of parameters that there are, and that something is unknown."""
        if not self.all:
            raise InputError("every parameter is held and every prior has no width: nothing is unknown")

    @property
    def network(self) -> Network:
        """The network as the image shows it."""
        return self.space.network

    @cached_property
    def all(self) -> dict[ParameterName, Unknown]:
        """Every unknown by its name."""
        unknowns = joined(self._parameters(), self._structure())
        return {name: unknown for name, unknown in unknowns.items() if unknown.spread > 0}

    def _parameters(self) -> dict[ParameterName, Unknown]:
        parameters, values = {}, dict(zip(self.space.names, self.space.nominal, strict=True))
        priors = resolved(self.priors.parameters, self.space.names, "the model of these priors")
        for name in self.space.free_names:
            parameter = self.space.parameters[name]
            center, spread = priors.get(name, (values[name], parameter.spread))
            parameters[name] = Unknown(
                parameter.unit, parameter.meaning, float(center), float(spread), True, "recording"
            )
        return parameters

    def _structure(self) -> dict[ParameterName, Unknown]:
        priors, structure = self.priors, dict[ParameterName, Unknown]()
        enters = {"zero": self.zero_enters, "taper": self.taper_enters}
        for name, kind in kinds().items():
            center = float(kind.center(self._seen))
            if enters.get(name, True) and not (kind.positive and center == 0):
                structure[ParameterName(kind.source, name)] = Unknown(
                    kind.unit, kind.meaning, center, priors.sd(name, self.network), kind.positive, kind.source
                )
        behind = self.space.outlet_pressure
        structure[ParameterName("recording", "wedge")] = Unknown(
            "mmHg", "pressure behind the vascular beds", behind, priors.wedge, False, "recording"
        )
        if self.fall.any():
            meaning = "factor of all measured tapers"
            structure[ParameterName("image", "taper_scale")] = Unknown(
                "1", meaning, 1.0, priors.taper_scale, False, "image"
            )
        return structure

    def values(self, scores: np.ndarray) -> dict[str, np.ndarray]:
        """Return the numbers at scores of shape (..., unknown), by name; those that are held or fixed too."""
        return self._medians | {
            name: unknown.value(scores[..., i]) for i, (name, unknown) in enumerate(self.all.items())
        }

    @cached_property
    def _medians(self) -> dict[str, np.ndarray]:
        """What every number is where nothing else is known."""
        held = {name: np.asarray(value) for name, value in zip(self.space.names, self.space.nominal, strict=True)}
        return held | {name: np.asarray(unknown.center) for name, unknown in self._structure().items()}

    def scores(self, values: Mapping[str, float]) -> np.ndarray:
        """Return the scores of a point; unknowns that `values` does not name stand at their medians."""
        scores = np.zeros(len(self.all))
        for i, (name, unknown) in enumerate(self.all.items()):
            if name in values:
                change = np.log(values[name] / unknown.center) if unknown.positive else values[name] - unknown.center
                scores[i] = change / unknown.spread
        return scores

    @cached_property
    def _seen(self) -> Observed:
        network = self.network.resized()
        _ = network.terminals, network.generations  # once for all networks that are made of it
        return Observed(network, self.recording, self.space.blood)

    def model(self, scores: np.ndarray) -> Model:
        """Return the model at scores of shape (unknown,)."""
        return self.posed(scores)[0]

    def posed(
        self,
        scores: np.ndarray,
        radii: np.ndarray | None = None,
        lengths: np.ndarray | None = None,
        falls: np.ndarray | None = None,
    ) -> tuple[Model, Recording]:
        """Return the model at scores of shape (unknown,), and what would have been recorded without errors.

        Each vessel's own errors, shape (vessel,), are those of the logarithms of radius and length, and of what the
        radius falls along the vessel. Nominal vascular beds share the flow by Poiseuille's law in the changed network,
        as in the one of the image.
        """
        value, observed = self.values(scores), self._seen
        for name, kind in kinds().items():
            if name in self.all:
                observed = kind.without(observed, float(value[name]))
        network = observed.network
        if radii is not None or lengths is not None:
            network = network.resized(
                radius=network.radius * np.exp(0.0 if radii is None else radii),
                length=network.length * np.exp(0.0 if lengths is None else lengths),
            )
        stiffer = (network.radius / network.radius[network.root]) ** -value["k"]
        # the wall's material is one, however thick it is
        values = {name: value[name] * parameter.scale(stiffer) for name, parameter in self.space.parameters.items()}
        nominal, blood = self.nominal, observed.blood
        site = Site(nominal.total_resistance, nominal.time_constant, nominal.beta, blood)
        beds = type(self.space.outlets).of(network, site)
        fields = model_fields(values, self.space.law, beds) | {
            "blood": blood, "outlet_pressure": float(value["wedge"]), "outlet_pulsation": self.space.outlet_pulsation
        }  # fmt: skip
        own_falls = self.fall + (0.0 if falls is None else falls)
        fall = value.get("taper", 0.0) + value.get("taper_scale", 1.0) * own_falls
        if not fall.any() and not self.fall.any():
            return Model(network, **fields), observed.recording
        return Model(network, shape=Shape.falling(fall), junctions="total", **fields), observed.recording

    @cached_property
    def own_errors(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """SD of the logarithms of each vessel's radius and length, and of its fall of radius, shape (vessel,) each."""
        count, radius_sd = len(self.network), self.network.radius_sd
        radii = np.full(count, self.priors.radius)
        if radius_sd is not None:
            measured = np.isfinite(radius_sd)
            radii[measured] = radius_sd[measured] / self.network.radius[measured]
        return radii, np.full(count, self.priors.length), self._falls[1]

    @property
    def fall(self) -> np.ndarray:
        """What each vessel's radius falls from inlet to outlet, as a share of its radius, shape (vessel,)."""
        return self._falls[0]

    @cached_property
    def _falls(self) -> tuple[np.ndarray, np.ndarray]:
        """Mean and SD of each vessel's fall by its measured taper and the prior; 0 where no taper was measured."""
        return measured_falls(self.network, self.priors.taper)
