"""Where vessels lose energy beside their drag: a stenosis, a web or a band, and branches that leave at an angle."""

from dataclasses import dataclass, replace
from itertools import count
from typing import Any

import numpy as np

from vasowave.base.errors import InputError
from vasowave.pulse.model.model import Model
from vasowave.pulse.network.network import MEASURED, Network


@dataclass(frozen=True)
class Stenosis:
    """Coefficients of the fall of pressure along a narrowing; a result has a note where their source measured nothing.

    Δp = K_v μU/D + ½K_t (A/A_s - 1)² ρ|U|U + K_u ρL dU/dt, with velocity, diameter and area before it, and
    K_v = 32 (length·L + diameter·D_s)/D (A/A_s)² (Young and Tsai, J Biomech 6, 1973; the lengths of K_v: Seeley and
    Young, J Biomech 9, 1976).

    Attributes
    ----------
    turbulent : float
        K_t.
    length, diameter : float
        Shares of the narrowing's length and of its own diameter D_s in the length along which Poiseuille's flow would
        lose as much: the second is what the flow loses to contract and to spread again, and most of it in a web.
    inertial : float, optional
        K_u, at most A/A_s. By default the blood of the narrow part has its own inertia, ρL/A_s, which is K_u = A/A_s;
        the source measured 1.2, for which the cells of the narrow part, and the steps, become shorter.
    least_lost : float
        Share of the area that is lost, below which the viscous term falls in proportion, so that nothing takes nothing:
        milder stenoses were not measured.

    Raises
    ------
    InputError
        A coefficient that is negative or not finite.

    Examples
    --------
    >>> import vasowave as vw
    >>> vw.Stenosis(turbulent=1.2).viscous_length(0.1, 0.05)  # 0.83 L + 1.64 D_s, cm
    0.165
    """

    turbulent: float = 1.52
    length: float = 0.83
    diameter: float = 1.64
    inertial: float | None = None
    least_lost: float = 0.4

    def __post_init__(self) -> None:
        """Check the coefficients."""
        for name in ("turbulent", "length", "diameter", "inertial", "least_lost"):
            value = getattr(self, name)
            if value is not None and not (np.isfinite(value) and value >= 0):
                raise InputError(f"Stenosis: {name} = {value!r}; give 0 or more")
        if self.inertial == 0 or self.least_lost == 0:
            raise InputError("Stenosis: inertial and least_lost are above 0; give more, or leave them out")

    def viscous_length(self, length: float, diameter: float) -> float:
        """Return the length, cm, along which Poiseuille's flow would lose as much, of a narrowing's own (cm)."""
        return self.length * length + self.diameter * diameter


STENOSIS = Stenosis()
"""The coefficients of the sources."""

_TURN = 0.75  # share of a branch's angle by which its stream has turned where it leaves (Mynard, Valen-Sendstad 2015)


def narrowed(
    model: Model,
    vessel: str,
    area_lost: float,
    length: float,
    place: float = 0.5,
    stiffer: float = 1.0,
    *,
    coefficients: Stenosis = STENOSIS,
) -> Model:
    """Return a model with a stenosis, a web or a band in one vessel.

    The vessel becomes three: up to the narrowing, the narrowing, and what lies beyond it, where the jet loses
    1.52 (A/A_s - 1)² ½ρu² with the velocity u there. What viscosity takes, 8πμ (0.83 L + 1.64 D_s)/A_s² of the flow, is
    the drag of the narrow part, and at its inlet the rest (see `Stenosis`). The narrow part stretches as the vessel
    does, unless it is `stiffer`, as a suture is. Where junctions share the total pressure, that of its own velocity is
    taken from the pressure within it.

    Parameters
    ----------
    model : Model
    vessel : str
        Name of a straight vessel.
    area_lost : float
        Share of its area that is closed, above 0 and below 1, at the pressure of the image.
    length : float
        Of the narrow part, cm.
    place : float
        Its middle, as a share of the vessel's length.
    stiffer : float
        How many times as stiff as the vessel the narrow part is.
    coefficients : Stenosis
        Others than those of the sources, as ``Stenosis(turbulent=1.2)``, where they were measured.

    Returns
    -------
    Model
        With two vessels more, "… narrow" and "… beyond", in the rows behind the vessel's.

    Raises
    ------
    InputError
        No such vessel, or one that changes along its way; a narrowing that closes it or does not fit into it; no model.

    Examples
    --------
    >>> import vasowave as vw
    >>> network, mouse = vw.control_network(), vw.virtual_mouse()
    >>> nominal = vw.estimate_nominal(network, mouse)
    >>> model = vw.Model(network, nominal.wall(vw.LinearWall), nominal.outlets)
    >>> vw.narrowed(model, "2", area_lost=0.8, length=0.05).network.name[:5]
    ('1', '2', '2 narrow', '2 beyond', '3')
    """
    if not isinstance(model, Model):
        raise InputError(f"{type(model).__name__} was given where a Model is needed")
    network, row = model.network, model.network.row(vessel)
    if model.changing[row]:
        raise InputError(f"vessel '{vessel}' changes along its way; a narrowing needs a straight one")
    if not 0 < area_lost < 1:
        raise InputError(
            f"a narrowing that closes {area_lost:g} of the area; give the share that is closed, above 0 and below 1"
        )
    if not (np.isfinite(stiffer) and stiffer > 0):
        raise InputError(f"a narrowing that is {stiffer:g} times as stiff; give a positive number")
    total = float(network.length[row])
    inertial = coefficients.inertial
    share = 1.0 if inertial is None else min(1.0, inertial * (1.0 - area_lost))  # of its length, in cells
    before, beyond = place * total - 0.5 * length, (1.0 - place) * total - 0.5 * length
    if not length > 0:
        raise InputError(f"a narrowing of {length:g} cm; give its length, above 0 cm")
    if not (before > 0 and beyond > 0):
        raise InputError(f"a narrowing of {length:g} cm at {place:g} of its length does not fit into vessel "
                         f"'{vessel}', which is {total:g} cm long: some of it must be left on both sides")  # fmt: skip
    rows = np.insert(np.arange(len(network)), row + 1, [row, row])  # of every new vessel, that which it is a part of
    pieces = slice(row, row + 3)
    loss: Any = np.broadcast_to(model.loss, len(network))[rows].copy()
    loss[pieces] = loss[row], 0.0, coefficients.turbulent * (1.0 / (1.0 - area_lost) - 1.0) ** 2
    resistance: Any = np.broadcast_to(model.resistance, len(network))[rows].copy()
    resistance[pieces] = resistance[row], _viscous(model, row, area_lost, length, coefficients), 0.0
    factor = np.where(np.arange(len(rows)) == row + 1, stiffer, 1.0)
    parameters = zip(model.wall, model.wall.law().parameters, strict=True)
    shape = model.shape
    if shape is not None and shape.rows != (1, 1):
        tables = map(np.asarray, (shape.radius, shape.stiffness))
        shape = type(shape)(*(table[rows] if len(table) > 1 else table for table in tables))
    return replace(
        model,
        network=_in_three(network, row, rows, (before, share * length, beyond), np.sqrt(1.0 - area_lost)),
        wall=type(model.wall)(*(value[rows] * parameter.scale(factor) for value, parameter in parameters)),
        shape=shape,
        loss=loss,
        resistance=resistance,
        wall_viscosity=np.broadcast_to(model.wall_viscosity, len(network))[rows],
    )


def _viscous(model: Model, row: int, area_lost: float, length: float, coefficients: Stenosis) -> float:
    """Return the viscous resistance of a narrowing, mmHg s/ml."""
    area = (1.0 - area_lost) * model.network.area[row]
    along = coefficients.viscous_length(length, 2.0 * np.sqrt(area / np.pi))
    share = min(1.0, area_lost / coefficients.least_lost)
    return float(share * 8.0 * np.pi * model.blood.inertia * model.blood.viscosity * along / area**2)


def _in_three(network: Network, row: int, rows: np.ndarray, lengths: tuple[float, ...], factor: float) -> Network:
    """Return the network with one vessel in three pieces, of which the middle one has its radius times a factor."""
    names = [network.name[old] for old in rows]
    for piece, added in ((row + 1, "narrow"), (row + 2, "beyond")):
        name = f"{network.name[row]} {added}"
        candidates = (f"{name} {number}" for number in count(2))
        names[piece] = (
            name if name not in network.name else next(text for text in candidates if text not in network.name)
        )
    length, radius = network.length[rows], network.radius[rows]
    length[row : row + 3] = lengths
    radius[row + 1] *= factor
    measured = {key: getattr(network, key)[rows] for key in MEASURED if getattr(network, key) is not None}
    for key in measured.keys() & {"taper", "taper_sd"}:  # a taper counts once, not for each piece of its vessel
        measured[key][row + 1 : row + 3] = np.nan
    last = np.searchsorted(rows, np.arange(len(network)), side="right") - 1  # where what a vessel was ends now
    parent, nodes = None, None
    if network.nodes is None:
        parent = np.where(network.parent < 0, -1, last[network.parent])[rows]
        parent[row + 1], parent[row + 2] = row, row + 1
    else:
        first = network.nodes.max() + 1
        nodes = network.nodes[rows].copy()
        nodes[row, 1] = nodes[row + 1, 0] = first
        nodes[row + 1, 1] = nodes[row + 2, 0] = first + 1
    return Network(tuple(names), parent, length, radius, pressure=network.pressure, nodes=nodes, **measured)


def angle_losses(network: Network, angles: Any) -> np.ndarray:
    """Return the loss coefficient of every vessel's inlet from the angle at which it leaves its parent.

    The stream has turned by three quarters of the angle (Mynard and Valen-Sendstad 2015); what it loses is the square
    of the change of its velocity, K = 1 + r² - 2 r cos(¾α), r being the parent's mean velocity over the vessel's own,
    which follow from the areas and the division of the mean flow (`Network.flow_fraction`).

    Parameters
    ----------
    network : Network
        A tree.
    angles : float or array, shape (vessel,)
        Angle between the direction of the parent and that of the vessel, degrees: 0 goes straight on.

    Returns
    -------
    array, shape (vessel,)
        For ``Model(loss=...)``; 0 at the root.

    Raises
    ------
    InputError
        Angles of another shape, or outside 0 to 180 degrees; a network with loops or several inlets.

    Examples
    --------
    >>> import vasowave as vw
    >>> network = vw.control_network()
    >>> vw.angle_losses(network, 45.0).shape
    (21,)
    """
    if network.nodes is not None:
        raise InputError("angle_losses: in a network with loops or several inlets no vessel has one parent")
    try:
        turned = np.radians(np.broadcast_to(np.asarray(angles, dtype=float), len(network)))
    except (TypeError, ValueError):
        raise InputError(f"angles: give one number, or one for each of the {len(network)} vessels, degrees") from None
    if not np.all((turned >= 0) & (turned <= np.pi)):
        raise InputError("angles: each is between 0 (straight on) and 180 degrees")
    velocity = network.flow_fraction / network.area
    r = velocity[network.parent] / velocity
    return np.where(network.parent < 0, 0.0, 1.0 + r**2 - 2.0 * r * np.cos(_TURN * turned))
