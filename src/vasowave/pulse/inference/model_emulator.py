"""An emulator of one animal: what its model answers, at once, in a box of parameters about the fit, with its own error.

It is learned by simulations, and judged by others that it has not learned: the largest of 90 errors is one that 95 % of
all others stay below, with a confidence of 99 % (Wilks, Ann. Math. Stat. 12 (1941), 91).
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.base.accessors import Accessor
from vasowave.base.errors import InputError, NumericalError, did_you_mean
from vasowave.pulse.analysis.operating import operating_point
from vasowave.pulse.analysis.prediction import UNITS, cycle_values
from vasowave.pulse.analysis.sensitivity_table import Sensitivity
from vasowave.pulse.analysis.uncertain import UncertainModel, uncertain_model
from vasowave.pulse.calibration.result import CalibratedModel
from vasowave.pulse.inference.emulator import Emulator, fit_emulator
from vasowave.pulse.inference.sobol import sobol_table
from vasowave.pulse.model.model import Model
from vasowave.pulse.solver.dataset import as_dataset
from vasowave.pulse.solver.result import Run
from vasowave.pulse.solver.simulation import simulate_runs


@dataclass(frozen=True)
class EmulatorBoxRules:
    """Where an emulator is made, and from how many simulations.

    Attributes
    ----------
    standard_errors : float
        Half width of the box along each parameter, in standard errors of its logarithm.
    min_factor, max_factor : float
        The box reaches at least and at most so far, as factors of the fitted value; its search's bounds end it, too.
    learned : int
        Simulations that are learned, for each parameter.
    checked : int
        Simulations that judge it: the fewest of which the largest error is a bound of 95 % with a confidence of 99 %.
    shrinkage : float
        Share of its width that is left of a box in which something cannot be simulated.
    max_shrinkages : int
    scale : float
        Share of the SD of an answer over the box that counts as an error.
    """

    standard_errors: float = 4.0
    min_factor: float = 1.25
    max_factor: float = 2.0
    learned: int = 30
    checked: int = 90
    shrinkage: float = 0.7
    max_shrinkages: int = 5
    scale: float = 0.02


RULES = EmulatorBoxRules()
_BLOCK = 256  # points that are answered at once: more of them wake threads, which wait for each other
EMULATED = {name: unit for name, unit in UNITS.items() if name != "CO"} | {"wave_speed": "cm/s", "Z_c": "mmHg s/ml"}
"""What is emulated, and its unit."""
KIND = "emulator of one animal"
_NOT_HERE = "no parameter of this emulator"


@dataclass(frozen=True, eq=False)
class ModelEmulator:
    """What a fitted model answers to other parameters, in a box about them.

    Attributes
    ----------
    data : Dataset
        Its box (``value`` as fitted, ``low, high, unit`` by parameter) and its simulations: ``answers`` by quantity at
        ``places``, logarithms from -1 to 1 over the box. The first of them, ``learned``, teach it, the others judge it.

    Examples
    --------
    >>> import vasowave as vw
    >>> network = vw.Network(("1",), [-1], [0.4], [0.05])  # a quick one: one vessel, and one unknown
    >>> search = vw.Search(starts=1, fixed={"r1": 1.0, "r2": 1.0, "c1": 1.0})
    >>> fit = vw.calibrate(network, vw.virtual_mouse(), search=search)
    >>> emulator = vw.emulate(fit)
    >>> bool(emulator({"beta": [45.0, 55.0]})["pPAP"].is_monotonic_increasing)
    True
    """

    data: xr.Dataset

    def __repr__(self) -> str:
        reach = ", ".join(f"{name} {row['low']:.4g} to {row['high']:.4g}" for name, row in self.box.iterrows())
        errors = ", ".join(f"{name} ± {row['error']:.2g} {row['unit']}" for name, row in self.quantities.iterrows())
        return f"Emulator({reach}; errors of 95 %: {errors})"

    @cached_property
    def box(self) -> pd.DataFrame:
        """Where it may be asked; index: parameter, columns ``value, low, high, unit``."""
        return self.data[["value", "low", "high", "unit"]].to_dataframe()

    @cached_property
    def quantities(self) -> pd.DataFrame:
        """What it answers; index: quantity, columns ``unit, error``, below which 95 % of its errors lie."""
        places, answers = self._simulations(slice(int(self.data["learned"]), None))
        names = [str(name) for name in self.data["quantity"].values]
        errors = np.abs(self._core(places) - answers).max(axis=0)
        return pd.DataFrame({"unit": [EMULATED[name] for name in names], "error": errors}, names)

    @cached_property
    def _core(self) -> Emulator:
        places, answers = self._simulations(slice(int(self.data["learned"])))
        scale = RULES.scale * answers.std(axis=0) + 1e-9 * np.abs(answers).max(axis=0)
        return fit_emulator(places, answers, places, scale, lambda points: points)

    def _simulations(self, rows: slice) -> tuple[np.ndarray, np.ndarray]:
        return self.data["places"].values[rows], self.data["answers"].values[rows]

    def __call__(self, values: Mapping[str, Any]) -> pd.DataFrame:
        """Return the answers to values of parameters, numbers or arrays; what is not named stays as fitted.

        Raises
        ------
        InputError
            A parameter that it does not know, or a value outside of where it was made.
        """
        check_names(values, self.box.index, _NOT_HERE)
        fitted = {str(name): value for name, value in self.box["value"].items()}
        try:
            columns = [np.atleast_1d(np.array(values.get(name, value), dtype=float)) for name, value in fitted.items()]
            points = np.column_stack(np.broadcast_arrays(*columns))
        except (TypeError, ValueError):
            raise InputError("give each parameter a number, or as many numbers as the others have") from None
        return pd.DataFrame(self.answers(points), columns=[*self.quantities.index])

    def answers(self, points: np.ndarray) -> np.ndarray:
        """Return the answers, shape (point, quantity), at points, shape (point, parameter); raises as a call."""
        points = np.atleast_2d(np.asarray(points, dtype=float))
        low, high = self.data["low"].values, self.data["high"].values
        inside = (points >= low * (1 - 1e-9)) & (points <= high * (1 + 1e-9))
        if not inside.all():
            column = int(np.argmin(inside.all(axis=0)))
            value = points[np.argmin(inside[:, column]), column]
            raise InputError(
                f"{self.box.index[column]} = {value:.4g} lies outside of where this emulator was made, "
                f"{low[column]:.4g} to {high[column]:.4g}; simulate it, or make one that reaches farther"
            )
        return self._of_places(2 * np.log(points / low) / np.log(high / low) - 1)

    def _of_places(self, places: np.ndarray) -> np.ndarray:
        blocks = np.split(places, range(_BLOCK, len(places), _BLOCK))
        return np.concatenate([self._core(block) for block in blocks])

    def sensitivity(
        self, box: Mapping[str, tuple[float, float]] | None = None, *, samples: int = 4096, seed: int = 0
    ) -> Sensitivity:
        """Return Sobol' indices of all quantities.

        Parameters
        ----------
        box : mapping of str to (float, float), optional
            Lowest and highest value of parameters; of those that it does not name, of the emulator's box.
        samples, seed : int
            See `sobol_table`.

        Raises
        ------
        InputError
            A box of no parameter of this emulator, or that reaches beyond its own; samples that are no power of 2.
        """
        limits = self.box[["low", "high"]].astype(float)
        for name, ends in checked_box({} if box is None else box, limits.index, _NOT_HERE).items():
            limits.loc[name] = ends
        _ = self.answers(limits.to_numpy().T)  # which refuses what lies outside
        logarithms, names = np.log(limits.to_numpy()), [*self.quantities.index]

        def answers(points: np.ndarray) -> np.ndarray:
            return self.answers(np.exp(points))

        table = sobol_table(answers, logarithms, [*limits.index], names, samples=samples, seed=seed)
        low, high = logarithms.T
        evenly = low + (high - low) * np.random.default_rng(seed).random((samples, len(limits)))
        quantities = self.quantities.assign(sd=answers(evenly).std(axis=0))[["unit", "sd", "error"]]
        return Sensitivity(table, limits.assign(unit=self.box["unit"]), quantities)

    @Accessor
    def to_netcdf(self, path: str | Path) -> Path:
        """Write it as netCDF, which `read_emulator` reads; returns the path. Raises `InputError` where it cannot."""
        raise NotImplementedError


def emulate(
    fit: CalibratedModel | UncertainModel, *, factors: Mapping[str, float] | None = None, seed: int = 0
) -> ModelEmulator:
    """Return an emulator of a fitted model, learned by simulations.

    Parameters
    ----------
    fit : Fit or UncertainModel
        A fit, or a stored one (`stored_fit`).
    factors : mapping of str to float, optional
        How far the box reaches along parameters, as a factor of the fitted value either way. By default 4 standard
        errors, at least 1.25 and at most 2; the bounds of the search end it. Where something in the box cannot be
        simulated, it is made smaller.
    seed : int

    Returns
    -------
    ModelEmulator
        Of ``mPAP, sPAP, dPAP, pPAP, power, oscillatory_share, mean_shear, wave_speed`` and ``Z_c``.

    Raises
    ------
    InputError
        No fit, no free parameter, a factor that is not above 1.
    NumericalError
        Nothing near the fit can be simulated.

    Examples
    --------
    >>> import vasowave as vw
    >>> network = vw.Network(("1",), [-1], [0.4], [0.05])  # a quick one: one vessel, and one unknown
    >>> search = vw.Search(starts=1, fixed={"r1": 1.0, "r2": 1.0, "c1": 1.0})
    >>> fit = vw.calibrate(network, vw.virtual_mouse(), search=search)
    >>> emulator = vw.emulate(fit, factors={"beta": 1.2})
    >>> round(float(emulator.box.loc["beta", "high"] / emulator.box.loc["beta", "value"]), 3)
    1.2
    """
    uncertain = uncertain_model(fit)
    table, random = uncertain.free, np.random.default_rng(seed)
    half, value = _half_widths(uncertain, factors or {}), table["value"].to_numpy(float)
    count = len(table)
    for _ in range(RULES.max_shrinkages + 1):
        low = np.maximum(table["lower"].to_numpy(float), value * np.exp(-half))
        high = np.minimum(table["upper"].to_numpy(float), value * np.exp(half))
        even = _even_points(count, RULES.learned * count, random)
        places = np.concatenate([even, random.uniform(-1, 1, (RULES.checked, count))])
        answers = _simulated(uncertain, [*table.index], low * (high / low) ** (0.5 * (places + 1)))
        if np.isfinite(answers).all():
            box = {"value": value, "low": low, "high": high, "unit": table["unit"].to_numpy(object)}
            simulations = {
                "learned": ((), len(even)),
                "places": (("simulation", "parameter"), places),
                "answers": (("simulation", "quantity"), answers),
            }
            names = {"parameter": table.index.to_numpy(object), "quantity": np.array([*EMULATED], dtype=object)}
            data = {name: ("parameter", column) for name, column in box.items()} | simulations
            return ModelEmulator(xr.Dataset(data, names, {"title": KIND, "source": repr(uncertain.model)}))
        half = RULES.shrinkage * half
    raise NumericalError("models near this fit cannot be simulated, so that none can be learned from; look at the fit")


def _half_widths(uncertain: UncertainModel, factors: Mapping[str, float]) -> np.ndarray:
    """Return how far the box reaches from the fit, in logarithms, shape (parameter,)."""
    table = uncertain.free
    if table.empty:
        raise InputError("no parameter of this fit is free and away from its bounds; there is nothing to emulate")
    if not isinstance(factors, Mapping):
        raise InputError("factors: give a factor by name: {'beta': 1.5}")
    check_names(factors, table.index, "not free")
    for name, factor in factors.items():
        if not (isinstance(factor, int | float | np.number) and np.isfinite(factor) and factor > 1):
            raise InputError(f"{name}: {factor}; a box reaches a factor above 1 either way")
    limits = np.log([RULES.min_factor, RULES.max_factor])
    usual = np.clip(RULES.standard_errors * uncertain.log_spread(table), *limits)
    widths = dict(zip(table.index, usual, strict=True)) | {name: np.log(factor) for name, factor in factors.items()}
    return np.array(list(widths.values()))


def check_names(names: Iterable[str], known_names: Iterable[str], reason: str) -> None:
    """Raise `InputError` for a name that is none of those, with the reason."""
    for name in names:
        if name not in known_names:
            hint, listed = did_you_mean(str(name), known_names), ", ".join(known_names)
            raise InputError(f"'{name}' is {reason}{hint}; there are: {listed}")


def _even_points(count: int, number: int, random: np.random.Generator) -> np.ndarray:
    """Return points that fill -1 to 1 evenly (a Latin hypercube of small discrepancy), shape (point, parameter)."""
    from scipy.stats import qmc

    return np.asarray(2 * qmc.LatinHypercube(count, optimization="random-cd", seed=random).random(number) - 1)


def _simulated(uncertain: UncertainModel, names: Sequence[str], points: np.ndarray) -> np.ndarray:
    """Return what models with these values of parameters answer, shape (point, quantity); NaN of what cannot be."""
    fixed = {str(name): float(value) for name, value in uncertain.parameters["value"].items()}
    models = []
    for point in points:
        try:
            models.append(uncertain.with_values(fixed | dict(zip(names, map(float, point), strict=True))))
        except InputError:
            return np.full((len(points), len(EMULATED)), np.nan)
    runs = simulate_runs(models, uncertain.inflow, uncertain.numerics)
    missing = [np.nan] * len(EMULATED)
    rows = (_numbers(run.model, as_dataset(run)) if isinstance(run, Run) else missing for run in runs)
    return np.array(list(rows))


def _numbers(model: Model, waves: xr.Dataset) -> list[float]:
    numbers = cycle_values(model, waves)
    place = operating_point(model, float(numbers["mPAP"]))
    speeds = {"wave_speed": place.wave_speed, "Z_c": model.blood.inertia * place.wave_speed / place.area}
    return [float(speeds[name]) if name in speeds else float(numbers[name]) for name in EMULATED]


def checked_box(box: Any, known_names: Iterable[str], reason: str) -> dict[str, tuple[float, float]]:
    """Return the ends of ranges of positive parameters; raises `InputError` for what is none, as `check_names`."""
    if not isinstance(box, Mapping):
        raise InputError(f"box: {box!r}; give lowest and highest value by name: {{'beta': (40.0, 60.0)}}")
    check_names(box, known_names, reason)
    return {str(name): _checked_range(name, ends) for name, ends in box.items()}


def _checked_range(name: str, ends: Any) -> tuple[float, float]:
    try:
        low, high = map(float, () if isinstance(ends, str | bytes) else ends)
    except (TypeError, ValueError):
        raise InputError(f"{name}: {ends!r}; give its lowest and highest value: {{'{name}': (40.0, 60.0)}}") from None
    if not (0 < low < high and np.isfinite(high)):
        raise InputError(f"{name}: {low:g} to {high:g} is not a range of a positive number; give the lower end first")
    return low, high
