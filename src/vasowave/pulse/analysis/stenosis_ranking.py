"""Which of several stenoses is worth most: what the removal of each gives back."""

import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from vasowave.base.descriptions import TAILS
from vasowave.base.errors import InputError, NumericalError, VasowaveWarning
from vasowave.pulse.analysis.changes import changeable_factors, with_factors
from vasowave.pulse.analysis.prediction import (
    FLOW_HELD,
    NO_REGULATION,
    UNITS,
    Progress,
    check_draws,
    cycle_values,
    interval_remarks,
    values_of_draws,
)
from vasowave.pulse.analysis.uncertain import UncertainModel, uncertain_model
from vasowave.pulse.calibration.result import CalibratedModel
from vasowave.pulse.cycle.cycle import Inflow
from vasowave.pulse.model.losses import narrowed
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.numerics import Numerics
from vasowave.pulse.solver.simulation import simulate

GIVEN_BACK = ("mPAP", "pPAP", "power")
"""What is ranked by, and told of each removal."""
ALL = "all of them"


@dataclass(frozen=True)
class RankingRules:
    """How far what is known of a stenosis is wrong, and how exactly the pressure stays the fitted one.

    Attributes
    ----------
    radius_sd : float
        SD of the logarithm of the radius of a narrowing, as of vessels in `Priors`.
    balance : float
        Share of mean and pulse pressure to which beds and walls are set anew.
    max_simulations : int
        Simulations by which they are.
    step, farthest : float
        Of the logarithms of their factors: for derivatives, and at most.
    """

    radius_sd: float = 0.05
    balance: float = 2e-3
    max_simulations: int = 25
    step: float = 0.05
    farthest: float = 3.0


RULES = RankingRules()
_OPEN = 1 - 1e-6  # share of the area of a vessel that is not narrow, as `narrowed` takes it
Removal = tuple[Model, Inflow]


def rank_stenoses(
    fit: CalibratedModel | UncertainModel,
    stenoses: Mapping[str, tuple[float, float]],
    *,
    by: str = "mPAP",
    draws: int = 40,
    seed: int = 0,
    progress: Progress | None = None,
) -> pd.DataFrame:
    """Return what the removal of each stenosis, and of all, gives back, and how surely each is the first to remove.

    The fit knows vessels without stenoses. These are put into it (`narrowed`), and the resistance of all beds and the
    stiffness of all walls changed until mean and pulse pressure are the fitted ones; then each is taken out.

    Parameters
    ----------
    fit : Fit or UncertainModel
    stenoses : mapping of str to (float, float)
        By vessel: the share of its area that is closed, and the length of the narrow part, cm.
    by : str
        ``mPAP``, ``pPAP`` or ``power``: what is ranked by.
    draws : int
        Of the parameters (see `predict`) and of the radius of each narrowing, which errs by 5 %; 0 for no intervals.
    seed : int
    progress : callable, optional
        Called with the draws that are done, and all; a minute may pass where a machine is slow.

    Returns
    -------
    DataFrame
        The best first; index: vessel, and last ``all of them``; columns ``area lost [1], length [cm]``; of each of
        ``mPAP, pPAP`` (mmHg) and ``power`` (mW) what is given back (positive: it falls), as in ``mPAP, mPAP_low,
        mPAP_high`` (95 %); ``first``, the probability that no other single removal gives back more. Its ``attrs`` say
        what was held (``assumptions``), and how many draws could not be simulated (``failures``).

    Raises
    ------
    InputError
        No stenosis, or one that cannot be (see `narrowed`); beds without a resistance.
    NumericalError
        The stenoses alone take more than the fitted pressure, or a model cannot be simulated.

    Examples
    --------
    >>> import vasowave as vw
    >>> fit = vw.calibrate(vw.control_network(), vw.virtual_mouse(), search=vw.Search(starts=1))
    >>> list(vw.rank_stenoses(fit, {"2": (0.8, 0.05), "3": (0.5, 0.05)}, draws=0).index)
    ['3', '2', 'all of them']
    """
    if by not in GIVEN_BACK:
        raise InputError(f"by='{by}'; stenoses are ranked by {', '.join(GIVEN_BACK)}")
    sizes = _checked(stenoses)
    check_draws(draws)
    uncertain = uncertain_model(fit)
    if "R_T" not in changeable_factors(uncertain.model):
        raise InputError(
            f"{type(uncertain.model.outlets).__name__} has no resistance that could leave room for stenoses"
        )
    random = np.random.default_rng([seed, len(sizes)])

    def uncertain_sizes(model: Model, inflow: Inflow) -> Iterator[Removal]:
        scores = random.normal(size=len(sizes))
        opened = np.minimum((1 - sizes[:, 0]) * np.exp(2 * RULES.radius_sd * scores), _OPEN)
        drawn_sizes = dict(zip(stenoses, zip(1 - opened, sizes[:, 1], strict=True), strict=True))
        yield from _removals(model, inflow, drawn_sizes, uncertain.numerics)

    measured_sizes = dict(zip(stenoses, sizes.tolist(), strict=True))
    removals = _removals(uncertain.model, uncertain.inflow, measured_sizes, uncertain.numerics)
    numbers = np.array([cycle_values(model, simulate(model, inflow, uncertain.numerics)) for model, inflow in removals])
    drawn, failures = values_of_draws(uncertain, draws, seed, uncertain_sizes, progress)
    columns = [list(UNITS).index(name) for name in GIVEN_BACK]
    gains = (numbers[:1] - numbers[1:])[:, columns]
    of_draws = (drawn[:, :1] - drawn[:, 1:])[..., columns] if len(drawn) else np.empty((0, *gains.shape))
    if uncertain.drawn and len(of_draws):  # whose optimum may lie beside the posterior
        gains = np.median(of_draws, axis=0)
    errors = f"the radius of each narrowing errs by {100 * RULES.radius_sd:g} %, and its length not"
    table = _table(stenoses, sizes, gains, of_draws, by)
    intervals = interval_remarks(uncertain, of_draws)
    table.attrs["assumptions"] = (FLOW_HELD, NO_REGULATION, *intervals, *([errors] if intervals else []))
    table.attrs["failures"] = failures
    return table


def _checked(stenoses: Mapping[str, tuple[float, float]]) -> np.ndarray:
    """Return share of the area and length of every stenosis, shape (stenosis, 2)."""
    shape = "{'2': (0.8, 0.05)}: the share of the area that is closed, and the length, cm"
    if not isinstance(stenoses, Mapping) or not stenoses:
        raise InputError(f"no stenoses to rank; give those of each vessel as {shape}")
    try:
        sizes = np.array([[float(number) for number in size] for size in stenoses.values()])
    except (TypeError, ValueError):
        sizes = np.empty(0)
    if sizes.shape != (len(stenoses), 2):
        raise InputError(f"stenoses: give those of each vessel as {shape}")
    return sizes


def _removals(
    model: Model, inflow: Inflow, stenoses: Mapping[str, tuple[float, float]], numerics: Numerics
) -> Iterator[Removal]:
    """Yield a model with its stenoses, without each of them, and without all, with what flows in."""

    def stenosed(names: Sequence[str]) -> Model:
        changed = model
        for name in names:
            changed = narrowed(changed, name, *stenoses[name])
        return changed

    def measured(tried: Model) -> np.ndarray:
        return _mean_and_pulse(tried, inflow, numerics)

    factors = _balanced(stenosed(list(stenoses)), measured, measured(model))
    for removed in (set[str](), *({name} for name in stenoses), set(stenoses)):
        yield _set_anew(stenosed([name for name in stenoses if name not in removed]), factors), inflow


def _mean_and_pulse(model: Model, inflow: Inflow, numerics: Numerics) -> np.ndarray:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VasowaveWarning)  # of models that are tried
        waves = simulate(model, inflow, numerics)
    inlet = waves["pressure"].sel(vessel=model.network.name[model.network.root], station="inlet").to_numpy()
    return np.array([inlet.mean(), np.ptp(inlet)])


def _set_anew(model: Model, logarithms: np.ndarray) -> Model:
    """Return a model whose beds are as many times as resistant, and its walls as stiff."""
    resistance, stiffness = (float(factor) for factor in np.exp(logarithms))
    parameters = zip(model.wall, model.wall.law().parameters, strict=True)
    stiffer = type(model.wall)(*(value * parameter.scale(stiffness) for value, parameter in parameters))
    return with_factors(model.changed(wall=stiffer), {"R_T": resistance})


def _balanced(model: Model, measured: Callable[[Model], np.ndarray], fitted: np.ndarray) -> np.ndarray:
    """Return the logarithms of the factors by which mean and pulse pressure become the fitted ones (Powell)."""
    from scipy.optimize import root

    def missed(logarithms: np.ndarray) -> np.ndarray:
        inside = np.clip(logarithms, -RULES.farthest, RULES.farthest)
        return np.log(measured(_set_anew(model, inside)) / fitted)

    options = {"eps": RULES.step**2, "factor": 0.5, "xtol": RULES.balance, "maxfev": RULES.max_simulations}
    solved = root(missed, np.zeros(2), method="hybr", options=options)
    if np.abs(solved.fun).max() > RULES.balance:
        raise NumericalError("with these stenoses no beds and walls make the fitted pressure; are they so narrow?")
    return np.clip(solved.x, -RULES.farthest, RULES.farthest)


def _table(
    stenoses: Mapping[str, tuple[float, float]], sizes: np.ndarray, gains: np.ndarray, drawn: np.ndarray, by: str
) -> pd.DataFrame:
    """Return the table from what is given back, shape (removal, number), and the same of draws."""
    table = pd.DataFrame(index=pd.Index([*stenoses, ALL], name="vessel"))
    for column, title in enumerate(("area lost [1]", "length [cm]")):
        table[title] = np.append(sizes[:, column], np.nan)
    low, high = gains * np.nan, gains * np.nan
    if len(drawn) > 1:
        low, _, high = np.quantile(drawn, TAILS, axis=0, method="weibull")
    for column, name in enumerate(GIVEN_BACK):
        table[name], table[f"{name}_low"], table[f"{name}_high"] = gains[:, column], low[:, column], high[:, column]
    table["first"] = np.nan
    if len(drawn):
        first = np.argmax(drawn[:, :-1, GIVEN_BACK.index(by)], axis=1)
        table.loc[[*stenoses], "first"] = np.bincount(first, minlength=len(stenoses)) / len(first)
    order = np.argsort(-table[by].to_numpy()[:-1], kind="stable")
    return table.iloc[[*order, len(stenoses)]]
