"""What a calibrated model foretells of a change: of beds, walls, vessels, heart rate or output."""

import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.base.accessors import Accessor
from vasowave.base.descriptions import NORMAL, TAILS
from vasowave.base.errors import InputError, VasowaveError, VasowaveWarning
from vasowave.pulse.analysis.changes import OF_HEART, changeable_factors, with_factors
from vasowave.pulse.analysis.ejection import cycle_indices
from vasowave.pulse.analysis.shear import wall_shear
from vasowave.pulse.analysis.uncertain import BY_FIT, BY_POSTERIOR, UncertainModel, uncertain_model
from vasowave.pulse.calibration.result import CalibratedModel
from vasowave.pulse.cycle.cycle import Inflow, Recording
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.ventricle import Driven, Ventricle
from vasowave.pulse.solver.simulation import simulate

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ROUNDING = 1e-12
"""Share of a number: a smaller change is none."""

MAX_FACTOR, MAX_RATE_FACTOR = 20.0, 4.0
"""By which a model may be changed either way, and its heart rate: beyond, a number was meant, and no factor."""
FLOW_HELD = "the heart pumps the same flow whatever its load, but for HR and CO that are changed; give a ventricle else"
VENTRICLE_HELD = "the ventricle has the same elastance and filling pressure before and after"
NO_REGULATION = "beds and vessels change as they are told and do not answer: nothing regulates itself"
Change = Callable[[Model], Model]
"""What is done to a model."""
Progress = Callable[[int, int], None]
"""Called with the draws that are done, and all."""


@dataclass(frozen=True, eq=False)
class Prediction:
    """What a change does.

    Attributes
    ----------
    table : DataFrame
        Index: ``mPAP, sPAP, dPAP, pPAP`` (mmHg), ``CO`` (ml/s), ``power`` (mW), ``oscillatory_share`` (1) and
        ``mean_shear`` (Pa), all at the inlet of the root; columns ``unit, before, after, change, change_low,
        change_high`` (95 %).
    change : dict
        The factors that were asked for.
    root : str
        Name of the root vessel.
    before, after : Dataset
        The waves of the fit, as `simulate` returns them.
    assumptions : tuple of str
        What was held, and what the intervals hold.
    failures : int
        Draws of parameters whose model could not be simulated, before or after.

    Examples
    --------
    >>> import vasowave as vw
    >>> fit = vw.calibrate(vw.control_network(), vw.virtual_mouse(), search=vw.Search(starts=1))
    >>> vw.predict(fit, {"beta": 1.5}, draws=4).table.loc["pPAP", "unit"]
    'mmHg'
    """

    table: pd.DataFrame
    change: Mapping[str, float]
    root: str
    before: xr.Dataset
    after: xr.Dataset
    assumptions: tuple[str, ...]
    failures: int

    def __repr__(self) -> str:
        rows = [
            f"  {name} {row['before']:.4g} -> {row['after']:.4g} {row['unit'].removeprefix('1')} "
            f"({row['change']:+.3g} [{row['change_low']:+.3g}, {row['change_high']:+.3g}])"
            for name, row in self.table.iterrows()
        ]
        return "\n".join([f"Prediction({self.label})", *rows, *(f"  {text}" for text in self.remarks)])

    @property
    def label(self) -> str:
        """The change in a few words."""
        return ", ".join(f"{name} × {factor:g}" for name, factor in self.change.items()) or "another model"

    @property
    def remarks(self) -> tuple[str, ...]:
        """What a reader of the numbers must know."""
        lost = f"{self.failures} of the drawn models could not be simulated"
        return (*([lost] if self.failures else []), *self.assumptions)

    @Accessor
    def figure(self) -> "Figure":
        """Draw pressure and flow at the inlet of the root, before and after."""
        raise NotImplementedError


def predict(
    fit: CalibratedModel | UncertainModel,
    change: Mapping[str, float],
    *,
    remodel: Change | None = None,
    ventricle: Ventricle | None = None,
    draws: int = 40,
    seed: int = 0,
) -> Prediction:
    """Return what a change does to pressure, power and shear at the inlet, with intervals.

    Parameters
    ----------
    fit : Fit or UncertainModel
        A fit, or a stored one: ``vw.stored_fit(result)``, which holds the draws of its posterior where there is one.
    change : mapping of str to float
        Factors: of parameters of the wall law (``beta``) and of the beds (``r1``, ``c1``; ``R_T``: all their
        resistances), of all radii and lengths (``radius``, ``length``), of heart rate and cardiac output (``HR``,
        ``CO``; with the same CO a faster heart ejects less a beat). Not empty unless something else is done.
    remodel : callable, optional
        What else is done to the model: ``lambda model: vw.narrowed(model, "2", 0.8, 0.05)``.
    ventricle : Ventricle, optional
        Drives the vessels before and after, so that output follows from the load; by default the flow of the fit does,
        the measured one unless the pressure entered the model.
    draws : int
        Draws of the posterior, else sets of parameters drawn from the errors of the fit, by which intervals are made.
    seed : int

    Returns
    -------
    Prediction
        Of a fit, intervals hold what the recording leaves open of the parameters; errors of image and instruments,
        which move before and after alike, are not in them. Of a posterior, the numbers are medians and quantiles of its
        draws, which know these errors.

    Raises
    ------
    InputError
        No change, an unknown name, a factor that is not positive, a model that cannot be, HR or CO beside a ventricle,
        a network of several inlets.
    NumericalError
        The changed model cannot be simulated.

    Examples
    --------
    >>> import vasowave as vw
    >>> fit = vw.calibrate(vw.control_network(), vw.virtual_mouse(), search=vw.Search(starts=1))
    >>> foretold = vw.predict(fit, {"R_T": 0.7}, draws=4)
    >>> bool(foretold.table.loc["mPAP", "after"] < foretold.table.loc["mPAP", "before"])
    True
    """
    uncertain = uncertain_model(fit)
    _check(uncertain, change, remodel, ventricle)
    check_draws(draws)
    factors = {name: factor for name, factor in change.items() if name not in OF_HEART}

    def changed(model: Model) -> Model:
        return remodel(with_factors(model, factors)) if remodel else with_factors(model, factors)

    def ends(model: Model, inflow: Inflow) -> Iterator[tuple[Model, Driven]]:
        yield model, ventricle or inflow
        yield changed(model), ventricle or _faster(inflow, change)

    pairs = list(ends(uncertain.model, uncertain.inflow))
    before, after = (simulate(*pair, uncertain.numerics) for pair in pairs)
    middle = [cycle_values(pair[0], waves) for pair, waves in zip(pairs, (before, after), strict=True)]
    drawn, failures = values_of_draws(uncertain, draws, seed, ends)
    table = _compared(middle, drawn, bool(uncertain.drawn))
    held = FLOW_HELD if ventricle is None else VENTRICLE_HELD
    root = uncertain.model.network.name[uncertain.model.network.root]
    assumptions = (f"held: {held}", f"held: {NO_REGULATION}", *interval_remarks(uncertain, drawn))
    return Prediction(table, dict(change), root, before, after, assumptions, failures)


def interval_remarks(uncertain: UncertainModel, drawn: np.ndarray) -> tuple[str, ...]:
    """Return what intervals hold; nothing where there are none."""
    return ((BY_POSTERIOR if uncertain.drawn else BY_FIT),) if len(drawn) > 1 else ()


def values_of_draws(
    uncertain: UncertainModel,
    draws: int,
    seed: int,
    variants: Callable[[Model, Inflow], Iterator[tuple[Model, Driven]]],
    progress: Progress | None = None,
    numbers: Callable[[Model, xr.Dataset], pd.Series | pd.DataFrame] | None = None,
) -> tuple[np.ndarray, int]:
    """Return the numbers of all variants of what the data allow, shape (draw, variant, ...), and how many failed.

    `numbers` are those of a model and its waves, `cycle_values` if not given.
    """
    numbers = numbers or cycle_values
    values, failures = [], 0
    for number, drawn in enumerate(uncertain.draws(draws, seed)):
        if progress is not None:
            progress(number, draws)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", VasowaveWarning)  # what the optimum's own waves warn of
                pairs = [] if drawn is None else variants(*drawn)
                rows = [numbers(model, simulate(model, driven, uncertain.numerics)) for model, driven in pairs]
        except VasowaveError:
            rows = []
        if rows:
            values.append(rows)
        failures += not rows
    return np.array(values), failures


def _compared(middle: list[pd.Series], drawn: np.ndarray, by_posterior: bool) -> pd.DataFrame:
    """Return the table of a prediction from the optimum's numbers and those of draws, shape (draw, end, number)."""
    before, after = middle
    if by_posterior and len(drawn):
        before, after = (pd.Series(values, before.index) for values in np.median(drawn, axis=0))
    table = pd.DataFrame({"unit": pd.Series(UNITS), "before": before, "after": after})
    change, low, high = change_interval(after - before, drawn, by_posterior)
    for name, values in (("change", change), ("change_low", low), ("change_high", high)):
        table[name] = np.where(
            np.abs(values) > ROUNDING * before.abs(), values, np.where(np.isnan(values), np.nan, 0.0)
        )
    return table


def change_interval(change: pd.Series, drawn: np.ndarray, by_posterior: bool) -> tuple[np.ndarray, ...]:
    """Return a change and its 95 % interval: quantiles of a posterior's draws, else normal about the optimum's."""
    if len(drawn) < 2:
        return change.to_numpy(), np.full(len(change), np.nan), np.full(len(change), np.nan)
    differences = drawn[:, 1] - drawn[:, 0]
    if by_posterior:
        low, median, high = np.quantile(differences, TAILS, axis=0, method="weibull")
        return median, low, high
    half = NORMAL * differences.std(axis=0, ddof=1)
    return change.to_numpy(), change.to_numpy() - half, change.to_numpy() + half


UNITS = {
    "mPAP": "mmHg", "sPAP": "mmHg", "dPAP": "mmHg", "pPAP": "mmHg", "CO": "ml/s", "power": "mW",
    "oscillatory_share": "1", "mean_shear": "Pa",
}  # fmt: skip


def _check(
    uncertain: UncertainModel, change: Mapping[str, float], remodel: Change | None, ventricle: Ventricle | None
) -> None:
    """Raise `InputError` for a change that is none or cannot be asked for."""
    if not isinstance(change, Mapping):
        raise InputError(f"{type(change).__name__} was given where a change is a factor by name: {{'R_T': 0.8}}")
    if all(factor == 1 for factor in change.values()) and remodel is None:
        names = ", ".join(changeable_factors(uncertain.model))
        raise InputError(f"nothing is changed; there are: {names}, each as a factor, 0.8 for a fifth less")
    for name, factor in change.items():
        if not (isinstance(factor, int | float | np.number) and np.isfinite(factor) and factor > 0):
            raise InputError(f"{name}: {factor}; a change is a positive factor, 0.8 for a fifth less")
        largest = MAX_RATE_FACTOR if name == "HR" else MAX_FACTOR
        if not 1 / largest <= factor <= largest:
            raise InputError(
                f"{name}: {factor:g} times; give a factor from {1 / largest:g} to {largest:g}, 0.7 for 70 %"
            )
    network = uncertain.model.network
    if len(network.inlets) > 1:
        raise InputError(
            f"the network has {len(network.inlets)} inlets; changes of one with a single inlet are foretold"
        )
    if ventricle is not None and (names := " and ".join(name for name in OF_HEART if name in change)):
        raise InputError(f"{names} follow from the ventricle; change the ventricle instead")


def check_draws(draws: int) -> None:
    """Raise `InputError` for a number of draws that is none."""
    if draws < 0:
        raise InputError(f"draws: {draws}; give how many sets of parameters are drawn, 0 for no intervals")


def _faster(inflow: Inflow, change: Mapping[str, float]) -> Inflow:
    return Inflow(inflow.flow * change.get("CO", 1.0), inflow.period / change.get("HR", 1.0))


def cycle_values(model: Model, waves: xr.Dataset) -> pd.Series:
    """Return the numbers of a cycle at the inlet of the root."""
    network = model.network
    inlet = waves.sel(vessel=network.name[network.root], station="inlet")
    period, flow = float(waves.attrs["period"]), inlet["flow"].to_numpy()
    cycle = Recording(inlet["pressure"].to_numpy(), flow, period)
    stress = wall_shear(flow, inlet["area"].to_numpy(), period, model.blood)
    numbers = cycle.indices() | cycle_indices(cycle, np.nan).values | {"mean_shear": stress.mean()}
    return pd.Series({name: numbers[name] for name in UNITS}, dtype=float)
