"""The model of one animal: a network, its walls, its outlets and its blood, checked together."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from vasowave.base.accessors import Accessor
from vasowave.base.errors import InputError
from vasowave.base.notebook import card
from vasowave.pulse.model.blood import Blood
from vasowave.pulse.model.numerics import Numerics
from vasowave.pulse.model.outlets import BUILT_IN as CIRCUITS
from vasowave.pulse.model.outlets import Bed, Outlets
from vasowave.pulse.model.per_vessel import one_per_vessel
from vasowave.pulse.model.shape import Shape
from vasowave.pulse.model.walls import BUILT_IN as WALLS
from vasowave.pulse.model.walls import Wall
from vasowave.pulse.network.network import Network

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import ArrayLike

    from vasowave.pulse.cycle.cycle import Inflow, Recording


@dataclass(frozen=True, eq=False)
class Model:
    """Everything a simulation needs besides its inflow.

    The radii of the network are those of an image taken at its `pressure`. A law is written in the area ratio A/A0, and
    A0 follows from it: A(image pressure) is the measured area, whatever the law.

    Attributes
    ----------
    network : Network
    wall : LinearWall or TangentWall
        Parameters as one number for all vessels or one per vessel; kept as one per vessel.
    outlets : Windkessel, other Bed, or ImpedanceSpectrum
        One value per terminal vessel, in the order of ``network.terminals``.
    blood : Blood
    outlet_pressure : float or array, shape (terminal,)
        Pressure behind the outlets, mmHg: of the left atrium, or the wedge pressure; 0 in the paper. What the pressure
        before a bed is above it drives the flow; walls feel the whole pressure. Kept as one value per terminal. The
        mean over the cycle of what `outlet_pulsation` (mmHg, shape (sample,) or (sample, terminal), by default
        nothing) adds to it.
    shape : Shape, optional
        How radius and stiffness change along the vessels; by default the tapers that the network was measured with,
        `Shape.of`. ``Shape()`` makes all of them straight.
    junctions : "static" or "total", optional
        Which pressure is one at both sides of a junction: the static one, as in the paper, or the total one, p + ½ρu²,
        with which no energy is lost there. By default total where any vessel has a shape, else static.
    loss : float or array, shape (vessel,)
        Loss coefficient K of each vessel's inlet: what enters or leaves it there loses K ½ρu², with its own velocity u.
        That of the root is not used.
    resistance : float or array, shape (vessel,)
        Steady viscous resistance of a vessel that is a narrowing, mmHg s/ml at the areas of the image: where its own
        drag takes less, its inlet takes the rest. 0, the default, leaves a vessel its own drag alone; so does any of
        the root.
    wall_viscosity : float or array, shape (vessel,)
        Viscosity η of the wall, mmHg s, with any law: a wall that stretches meets η ∂√(A/A0)/∂t beside the pressure of
        its law, so that p = (β + η ∂/∂t)(√(A/A0) - 1) with the linear one (Kelvin and Voigt). 0 is an elastic wall.

    Raises
    ------
    InputError
        A parameter that is not a positive finite number or has the wrong shape, or a law without an area at the
        pressure of the image; the vessel is named. A shape of another number of vessels; junctions of another kind, a
        loss that is negative.

    Examples
    --------
    >>> import vasowave as vw
    >>> network = vw.control_network()
    >>> beds = vw.estimate_nominal(network, vw.virtual_mouse()).outlets
    >>> vw.Model(network, vw.LinearWall(beta=60.0), beds)
    Model(LinearWall(beta 60), Windkessel, Network(21 vessels, ...))
    """

    network: Network
    wall: Any
    outlets: Outlets
    blood: Blood = field(default_factory=Blood)
    outlet_pressure: float | np.ndarray = 0.0
    shape: Shape | None = None
    junctions: Literal["static", "total"] | None = None
    loss: float | np.ndarray = 0.0
    wall_viscosity: float | np.ndarray = 0.0
    outlet_pulsation: np.ndarray | None = None
    resistance: float | np.ndarray = 0.0

    def __post_init__(self) -> None:
        """Expand every parameter to one value per vessel or terminal, and check it."""
        if type(self.wall) not in WALLS and not isinstance(self.wall, Wall):  # which takes long to tell
            raise InputError(f"{self.wall!r} is not a wall law; use one of `walls`, as in LinearWall(beta)")
        if type(self.outlets) not in CIRCUITS and not isinstance(self.outlets, Outlets):
            raise InputError(f"{self.outlets!r} is not an outlet; use Windkessel(R1, R2, C) or ImpedanceSpectrum(Z)")
        terminals = [self.network.name[row] for row in self.network.terminals]
        object.__setattr__(self, "wall", one_per_vessel(self.wall, self.network.name, "wall"))
        object.__setattr__(self, "outlets", self.outlets.checked(terminals))
        if not isinstance(self.shape, Shape | None):
            raise InputError(f"shape: {self.shape!r} is no shape; give Shape(radius), as in Shape([1.0, 0.8])")
        if self.shape is not None and not set(self.shape.rows) <= {1, len(self.network)}:
            raise InputError(f"shape: give one row of points, or one for each of the {len(self.network)} vessels")
        object.__setattr__(self, "outlet_pressure", _pressures(self.outlet_pressure, terminals))
        if self.outlet_pulsation is not None:
            object.__setattr__(self, "outlet_pulsation", _pulsation(self.outlet_pulsation, terminals))
            self.pulsation_before_beds(1.0)
        if self.junctions not in (None, "static", "total"):
            raise InputError(f"junctions: {self.junctions!r} is not known; give 'static' or 'total'")
        object.__setattr__(self, "loss", _not_negative("loss", self.loss, self.network.name))
        object.__setattr__(self, "resistance", _not_negative("resistance", self.resistance, self.network.name))
        viscosity = _not_negative("wall_viscosity", self.wall_viscosity, self.network.name)
        object.__setattr__(self, "wall_viscosity", viscosity)
        bad = np.flatnonzero(~(np.isfinite(self.area0) & (self.area0 > 0)))
        if len(bad):
            raise InputError(
                f"vessel '{self.network.name[bad[0]]}': its wall has no area at {self.network.pressure:g} mmHg, the "
                "pressure of the image; check its parameters"
            )

    @cached_property
    def area0(self) -> np.ndarray:
        """Cross-sectional area A0 at zero pressure, cm², shape (vessel,): measured area over the law's ratio there.

        It is that of the vessel's own radius; where the vessel changes along its way, `at` knows more.
        """
        return self._area0(self.wall, self.network.area)

    def _area0(self, wall: Any, area: np.ndarray) -> np.ndarray:
        with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
            return area / np.asarray(wall.ratio_at(self.network.pressure, *wall))

    @cached_property
    def profile(self) -> Shape | None:
        """The shape that was given or, if none was, measured; nothing where all vessels are straight."""
        if self.shape is None and self.network.taper is None:
            return None
        shape = self.shape or Shape.of(self.network)
        return shape if shape.changes.any() else None

    @cached_property
    def changing(self) -> np.ndarray:
        """True for a vessel whose radius or stiffness changes along its way, shape (vessel,)."""
        return np.zeros(len(self.network), dtype=bool) | (self.profile is not None and self.profile.changes)

    @cached_property
    def total_pressure(self) -> bool:
        """Whether junctions share the total pressure."""
        return self.junctions == "total" or (self.junctions is None and self.profile is not None)

    @cached_property
    def dynamic(self) -> bool:
        """Whether velocities count where vessels meet: where the total pressure is shared, or some of it lost."""
        return self.total_pressure or bool(np.any(self.loss)) or bool(np.any(self.resistance))

    @cached_property
    def narrowings(self) -> np.ndarray:
        """The resistance of every vessel that is a narrowing, mmHg s/ml, shape (vessel,): 0 of others and of inlets."""
        values = np.array(np.broadcast_to(self.resistance, len(self.network)), dtype=float)
        values[self.network.inlets] = 0.0
        return values

    def narrowing_drag(self, period: float) -> np.ndarray:
        """Return what inlets take of pressure beside the drag of their vessels to make `resistance`.

        In proportion to the velocity, mmHg s/cm, shape (vessel,).
        """
        resistance = self.narrowings
        if not resistance.any():
            return resistance
        k0, k1 = self.blood.friction.coefficients(self.blood.viscosity, period)
        area = self.network.area
        vessel_resistance = self.blood.inertia * self.network.length * (k0 + k1 * np.sqrt(area)) / area**2
        return area * np.where(resistance > 0, np.maximum(resistance - vessel_resistance, 0.0), 0.0)

    @cached_property
    def stiffening(self) -> np.ndarray:
        """True for a vessel whose stiffness does, shape (vessel,)."""
        return np.zeros(len(self.network), dtype=bool) | (self.profile is not None and self.profile.stiffens)

    def at(self, vessel: "ArrayLike", share: "ArrayLike") -> tuple[Any, np.ndarray]:
        """Return the wall law and A0 (cm²) at places: rows of vessels, and shares of their length from the inlet.

        Both have the same shape, which is that of A0 and of every parameter of the law.
        """
        vessel, share = np.asarray(vessel), np.asarray(share)
        wall = type(self.wall)(*(value[vessel] for value in self.wall))
        if self.profile is None:
            return wall, self.area0[vessel]
        stiffness, parameters = self.profile.at(vessel, share)[1], self.wall.law().parameters
        wall = type(wall)(
            *(value * parameter.scale(stiffness) for value, parameter in zip(wall, parameters, strict=True))
        )
        return wall, self._area0(wall, self.image_area(vessel, share))

    def pulsation_before_beds(self, period: float) -> np.ndarray | None:
        """Return what stands of `outlet_pulsation` before the beds where nothing flows, shape (sample, terminal), mmHg.

        Raises
        ------
        InputError
            Beds that are no circuits: what they let through is not known.
        """
        if self.outlet_pulsation is None:
            return None
        circuit = self.outlets.circuit() if isinstance(self.outlets, Bed) else None
        if circuit is None:
            raise InputError(
                f"outlet_pulsation: what {type(self.outlets).__name__} lets through of it is not known; give beds that "
                "are resistances or Windkessels, or the mean pressure alone"
            )
        count = len(self.outlet_pulsation)
        omega = 2 * np.pi / period * np.arange(count // 2 + 1)[:, np.newaxis]
        return np.fft.irfft(np.fft.rfft(self.outlet_pulsation, axis=0) * circuit.passes(omega), count, axis=0)

    def image_area(self, vessel: np.ndarray, share: np.ndarray) -> np.ndarray:
        """Cross-sectional area, cm², at the pressure of the image, at places as in `at`."""
        area = self.network.area[vessel]
        return area if self.profile is None else area * self.profile.at(vessel, share)[0] ** 2

    def __repr__(self) -> str:
        parameters = ", ".join(
            f"{name} {np.median(value):.4g}" for name, value in zip(self.wall._fields, self.wall, strict=True)
        )
        details = f", {self.profile!r}" if self.profile is not None else ""
        if np.any(self.wall_viscosity):
            details += f", wall viscosity {_spread(np.atleast_1d(self.wall_viscosity))} mmHg s"
        return (
            f"Model({type(self.wall).__name__}({parameters}), {type(self.outlets).__name__}, {self.network!r}{details})"
        )

    def _repr_html_(self) -> str:
        law = self.wall.law()
        facts = {"wall": f"{law.title}: {law.formula}"}
        facts |= {field: _spread(value) for field, value in zip(self.wall._fields, self.wall, strict=True)}
        facts["outlets"] = f"{type(self.outlets).__name__} at {len(self.network.terminals)} terminals"
        if np.any(self.outlet_pressure):
            facts["behind the outlets"] = f"{_spread(np.asarray(self.outlet_pressure))} mmHg"
        if self.outlet_pulsation is not None:
            facts["pulsation behind the outlets"] = f"{np.ptp(self.outlet_pulsation, axis=0).max():.3g} mmHg"
        facts["vessels"] = f"{len(self.network)}, {self.network.length.sum():.4g} cm long in all"
        facts |= {} if self.profile is None else {"shape": repr(self.profile)}
        facts["blood"] = repr(self.blood)
        return card("Model", facts)

    @Accessor
    def simulate(self, inflow: "Inflow | Recording", numerics: Numerics | None = None) -> "xr.Dataset":
        """Return one cycle of the periodic state, see `vasowave.simulate`."""
        raise NotImplementedError

    def changed(self, **fields: Any) -> "Model":
        """Return a model with other parts: ``model.changed(wall=LinearWall(60.0))``."""
        return replace(self, **fields)


def _pressures(pressures: Any, terminals: list[str]) -> np.ndarray:
    try:
        values = np.array(np.broadcast_to(np.asarray(pressures, dtype=float), len(terminals)))
    except (TypeError, ValueError):
        raise InputError(
            f"outlet_pressure: give one number, or one for each of the {len(terminals)} terminal vessels, mmHg"
        ) from None
    bad = np.flatnonzero(~np.isfinite(values))
    if len(bad):
        raise InputError(f"vessel '{terminals[bad[0]]}': the pressure behind its outlet is {values[bad[0]]}")
    return values


def _pulsation(pulsation: Any, terminals: list[str]) -> np.ndarray:
    """Return what pressures do about their means, shape (sample, terminal)."""
    values = np.array(pulsation, dtype=float)
    values = values[:, np.newaxis] if values.ndim == 1 else values
    if values.ndim != 2 or values.shape[1] not in (1, len(terminals)) or not np.all(np.isfinite(values)):
        raise InputError(
            f"outlet_pulsation: give finite samples of one cycle, mmHg, shape (sample,), or a column for each of the "
            f"{len(terminals)} terminal vessels"
        )
    return np.broadcast_to(values - values.mean(axis=0), (len(values), len(terminals)))


def _not_negative(quantity: str, numbers: Any, names: tuple[str, ...]) -> float | np.ndarray:
    """Return one number, or one for each vessel, that is 0 or more."""
    try:
        values = np.array(np.broadcast_to(np.asarray(numbers, dtype=float), len(names)))
    except (TypeError, ValueError):
        raise InputError(f"{quantity}: give one number, or one for each of the {len(names)} vessels") from None
    bad = np.flatnonzero(~(np.isfinite(values) & (values >= 0)))
    if len(bad):
        raise InputError(f"vessel '{names[bad[0]]}': {quantity} {values[bad[0]]:g} is not valid; give 0 or more")
    return values if np.ndim(numbers) else float(numbers)


def _spread(values: np.ndarray) -> str:
    low, high = values.min(), values.max()
    return f"{low:.4g}" if low == high else f"{low:.4g} to {high:.4g}"
