"""What made the change between two states of an animal: heart, walls, beds, geometry or the pressure behind them.

Each component of the model is exchanged, in every order; what the exchange changes on average is that component's share
(Shapley 1953). The shares of all components add up to the whole change.
"""

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, is_dataclass
from itertools import combinations
from math import factorial
from typing import Any

import numpy as np
import pandas as pd

from vasowave.base.errors import InputError, VasowaveWarning
from vasowave.pulse.analysis.prediction import ROUNDING, UNITS, cycle_values
from vasowave.pulse.cycle.cycle import Inflow, Recording
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.numerics import Numerics
from vasowave.pulse.model.outlets import COMPLIANCE, RESISTANCE, Bed, Outlets
from vasowave.pulse.network.network import Network
from vasowave.pulse.solver.simulation import simulate

Drive = Inflow | Recording
"""Of a model: flow and period."""

_FIELDS: dict[str, tuple[str, ...]] = {
    "walls": ("wall", "wall_viscosity"),
    "beds": ("outlets",),
    "geometry": ("network", "shape", "loss", "resistance", "junctions"),
    "pressure behind beds": ("outlet_pressure", "outlet_pulsation"),
    "blood": ("blood",),
}
"""Parts of a model, and the fields that are exchanged with them."""

HEART = "heart"
"""Part that is the flow into the model, with its period."""

_DIFFER = "{name} differ from vessel to vessel and the trees are not the same; fit one tree twice"
_ALIKE = 0.01  # change of the total resistance, as a share, that beds on another tree may bring


@dataclass(frozen=True, eq=False)
class Attribution:
    """The shares of the components of a model in a change.

    Attributes
    ----------
    table : DataFrame
        Index: as of `Prediction.table`; columns ``unit, before, after, change`` and one for each component that
        differs: ``heart`` (flow and rate), ``walls``, ``beds``, ``geometry``, ``pressure behind beds``, ``blood``, in
        the unit of the row; together they are the change.
    undone : DataFrame
        What each component alone does to the state after if it is as it was before; same index, a column for each.

    Examples
    --------
    >>> import vasowave as vw
    >>> network, mouse = vw.control_network(), vw.virtual_mouse()
    >>> soft = vw.Model(network, vw.LinearWall(60.0), vw.estimate_nominal(network, mouse).outlets)
    >>> vw.attribute_change(soft, soft.changed(wall=vw.LinearWall(90.0)), (mouse, mouse)).components
    ('walls',)
    """

    table: pd.DataFrame
    undone: pd.DataFrame

    @property
    def components(self) -> tuple[str, ...]:
        """Those that differ between the two states."""
        return tuple(map(str, self.table.columns[4:]))

    def __repr__(self) -> str:
        rows = [
            f"  {name} {row['before']:.4g} -> {row['after']:.4g} {row['unit'].removeprefix('1')}".rstrip()
            + f" ({row['change']:+.3g}): "
            + (", ".join(f"{component} {row[component]:+.3g}" for component in self.components) or "nothing differs")
            for name, row in self.table.iterrows()
        ]
        return "\n".join(["Attribution", *rows])


def attribute_change(
    before: Model, after: Model, inflows: tuple[Drive, Drive], numerics: Numerics | None = None
) -> Attribution:
    """Return which components of a model made the change between two states, such as before and after a treatment.

    A component that is exchanged alone does not do the same as one that is exchanged last: stiff walls cost more pulse
    at a high pressure. The share of a component is its mean over all orders in which the components can be exchanged.

    Parameters
    ----------
    before, after : Model
        Of the same kind of wall law and of beds. Where the trees are not the same, beds go to the other tree with the
        resistance and compliance that they have together, shared by its flow.
    inflows : tuple of Inflow or Recording
        The flow before and after.
    numerics : Numerics, optional
        How finely is simulated: as the fits were (`Fit.numerics`).

    Returns
    -------
    Attribution

    Raises
    ------
    InputError
        Models with several inlets, of different laws or kinds of beds; walls or beds that differ from vessel to vessel
        where the trees are not the same.
    NumericalError
        A model with components of both states cannot be simulated.

    Notes
    -----
    With n components that differ 2ⁿ models are simulated. What the recordings leave open of the states is not in it.

    Examples
    --------
    >>> import vasowave as vw
    >>> network, mouse = vw.control_network(), vw.virtual_mouse()
    >>> model = vw.Model(network, vw.LinearWall(60.0), vw.estimate_nominal(network, mouse).outlets)
    >>> ill = model.changed(wall=vw.LinearWall(90.0), outlets=model.outlets.scaled(1.5, 1.5, 0.8))
    >>> shares = vw.attribute_change(model, ill, (mouse, mouse)).table
    >>> bool(shares.loc["mPAP", "beds"] > 10 * abs(shares.loc["mPAP", "walls"]))
    True
    """
    _check(before, after, inflows)
    same = before.network.name == after.network.name
    states = _components(before, inflows[0], same), _components(after, inflows[1], same)
    differing = [component for component in states[0] if not _equal(states[0][component], states[1][component])]

    def numbers(exchanged: frozenset[str]) -> pd.Series:
        components = {component: states[component in exchanged][component] for component in states[0]}
        chosen: dict[str, Any] = {}
        for component in _FIELDS:
            chosen |= components[component]
        beds, walls = (after if component in exchanged else before for component in ("beds", "walls"))
        tree = chosen["network"]
        model = before.changed(**chosen | {"outlets": _beds_on(tree, beds), "wall": _wall_on(tree, walls)})
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", VasowaveWarning)  # of states between the two, which no animal is in
            waves = simulate(model, components[HEART]["inflow"], numerics)
        return cycle_values(model, waves)

    values = {subset: numbers(subset) for subset in _subsets(differing)}
    first, last = values[frozenset()], values[frozenset(differing)]
    table = pd.DataFrame({"unit": pd.Series(UNITS), "before": first, "after": last, "change": last - first})
    for component in differing:
        table[component] = _share(component, differing, values.__getitem__)
    undone = pd.DataFrame(
        {component: values[frozenset(differing) - {component}] - last for component in differing}, index=table.index
    )
    moved = table.columns[3:]
    table[moved], undone = (
        changes.where(changes.abs().ge(ROUNDING * first.abs(), axis=0), 0.0) for changes in (table[moved], undone)
    )
    return Attribution(table, undone)


def _check(before: Model, after: Model, inflows: tuple[Drive, Drive]) -> None:
    if not (isinstance(inflows, tuple) and len(inflows) == 2 and all(isinstance(flow, Drive) for flow in inflows)):
        raise InputError("inflows: give the flow before and the flow after, as (before, after)")
    for name, model in (("before", before), ("after", after)):
        if not isinstance(model, Model):
            raise InputError(f"{name}: {type(model).__name__} was given where a Model is needed; of a fit: fit.model")
        if len(model.network.inlets) > 1:
            raise InputError(f"{name}: the network has {len(model.network.inlets)} inlets; give models with one")
    for name, first, second in (
        ("walls", type(before.wall), type(after.wall)),
        ("beds", type(before.outlets), type(after.outlets)),
    ):
        if first is not second:
            raise InputError(
                f"{name}: {first.__name__} before and {second.__name__} after cannot be exchanged; fit both states "
                "with the same kind"
            )


def _components(model: Model, inflow: Drive, same: bool) -> dict[str, dict[str, Any]]:
    """Return the fields of each component of a state; those that fit any tree where the trees are not the same."""
    components = {component: {name: getattr(model, name) for name in fields} for component, fields in _FIELDS.items()}
    if not same:
        behind, walls = components["pressure behind beds"], components["walls"]
        behind["outlet_pressure"] = _common("pressures behind beds", np.asarray(behind["outlet_pressure"]))
        if (pulsation := behind["outlet_pulsation"]) is not None:
            if np.ptp(pulsation, axis=1).max() > _ALIKE * np.abs(pulsation).max():
                raise InputError(_DIFFER.format(name="pulsations behind beds"))
            behind["outlet_pulsation"] = pulsation[:, 0]
        walls["wall_viscosity"] = _common("wall viscosities", np.atleast_1d(walls["wall_viscosity"]))
    return {HEART: {"inflow": inflow}} | components


def _subsets(components: Sequence[str]) -> list[frozenset[str]]:
    return [frozenset(names) for count in range(len(components) + 1) for names in combinations(components, count)]


def _share(component: str, components: Sequence[str], values: Callable[[frozenset[str]], pd.Series]) -> pd.Series:
    """Return the mean change by a component over all orders of exchange."""
    count = len(components)
    remaining = _subsets([name for name in components if name != component])
    weights = [factorial(len(subset)) * factorial(count - len(subset) - 1) / factorial(count) for subset in remaining]
    return sum(
        (
            weight * (values(subset | {component}) - values(subset))
            for weight, subset in zip(weights, remaining, strict=True)
        ),
        start=0.0 * values(frozenset()),
    )


def _beds_on(network: Network, model: Model) -> Outlets:
    """Return the beds of a model on a tree, together with the same resistance and compliance."""
    beds, origin = model.outlets, model.network
    names = [[tree.name[row] for row in tree.terminals] for tree in (network, origin)]
    if names[0] == names[1] or not isinstance(beds, Bed):
        return beds
    old, new = (tree.flow_fraction[tree.terminals] for tree in (origin, network))
    moved = {}
    for name, quantity in beds.bed().quantities.items():
        power = {RESISTANCE: 1, COMPLIANCE: -1}.get(quantity.unit, 0)
        moved[name] = _common(f"beds, {name}", np.asarray(getattr(beds, name)) * old**power) / new**power
    moved_beds = type(beds)(**moved)
    if abs(moved_beds.total_resistance() / beds.total_resistance() - 1) > _ALIKE:
        raise InputError(f"beds: {type(beds).__name__} changes its resistance on another tree; fit Windkessels")
    return moved_beds


def _wall_on(network: Network, model: Model) -> Any:
    """Return the wall of a model for the vessels of a tree."""
    if network.name == model.network.name:
        return model.wall
    return type(model.wall)(*(_common("walls", np.asarray(values)) for values in model.wall))


def _common(name: str, values: np.ndarray) -> float:
    """Return what all vessels have in common."""
    if np.ptp(values) > _ALIKE * abs(values).max():
        raise InputError(_DIFFER.format(name=name))
    return float(np.median(values))


def _equal(first: Any, second: Any) -> bool:
    """Whether two values, or all numbers in them, are the same."""
    if isinstance(first, dict):
        return all(_equal(first[name], second[name]) for name in first)
    if isinstance(first, tuple) and isinstance(second, tuple):
        return len(first) == len(second) and all(map(_equal, first, second))
    if is_dataclass(first) and type(first) is type(second):
        return all(_equal(getattr(first, entry.name), getattr(second, entry.name)) for entry in fields(first))
    return first is second or bool(np.array_equal(first, second))
