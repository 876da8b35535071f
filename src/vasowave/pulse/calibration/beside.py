"""What each further site of a fit adds: the fit without it predicts it, and is beside the fit with all of them."""

import threading
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np
import xarray as xr

from vasowave.base.descriptions import NORMAL
from vasowave.base.errors import NumericalError
from vasowave.base.findings import Finding, look_kind
from vasowave.base.runtime.thread_limits import threads
from vasowave.base.units import ratios
from vasowave.pulse.calibration.compared import Compared
from vasowave.pulse.calibration.objective import Objective
from vasowave.pulse.calibration.optimization import FINAL_TOLERANCE, search
from vasowave.pulse.calibration.parameters import ParameterSpace
from vasowave.pulse.calibration.sites import Sites
from vasowave.pulse.calibration.uncertainty import spread_of, total_resistance
from vasowave.pulse.cycle.cycle import resample
from vasowave.pulse.cycle.observation import NUMBERS
from vasowave.pulse.model.numerics import Numerics
from vasowave.pulse.model.walls import wave_speed
from vasowave.pulse.noise.spectrum import SIZE_PRIOR

_LOG_STEP = 1e-4  # of differences of quantities, in the logarithms
_MIN_RATIO_SD = 4.0  # SD of the ratio to the prediction from which it is not 1
_MAX_SITE_MISFIT = 3.0
"""Root mean square of what a prediction misses, over what was expected, from which a site disagrees."""
_GEOMETRY_POWERS = {"diameter": {"a radius": 0.5}, "area": {"a radius squared": 0.318, "a diameter squared": 1.273}}
"""What else is taken for a quantity, and by what it is then multiplied."""

SITE_UNIT = look_kind(
    "fit.site-unit",
    "The {site} is {ratio:.3g} times what the recording at the inlet predicts, as if {why}, or the like. {remedy}",
    "Correct its unit; until then it pulls the fit to a wrong place.",
)
SITE_APART = look_kind(
    "fit.site-apart",
    "The {site} disagrees with the others: the fit without it misses it by {misfit:.1f} times what its error, the "
    "model's and the spread of the fit let expect. {remedy}",
    "Look at its place, its zero, its timing and its error; then ask whether the network is this animal's.",
)


_COLUMN_MEANINGS = {
    "vessel": "vessel of the site",
    "observed": "what was observed",
    "unit": "unit of what was observed",
    "place": "share of the vessel's length from its inlet",
    "error": "SD of the error of each value",
    "zero_sd": "SD of the zero of a pressure",
    "gain_sd": "SD of a factor of all values",
    "mean": "observed mean, in place of a waveform",
    "systolic": "observed largest value, in place of a waveform",
    "diastolic": "observed smallest value, in place of a waveform",
    "ratio": "observed over what the inlet alone predicts",
    "misfit": "what the fit without the site misses over what was expected, r.m.s.",
    "measured": "observed waveform",
    "simulated": "the fit to all sites",
    "predicted": "the fit without the site",
    "value": "value with all sites",
    "low": "lower end of its 95 % interval",
    "high": "upper end of its 95 % interval",
    "value_without": "value without the site",
    "low_without": "lower end without the site",
    "high_without": "upper end without the site",
}
_SHARES = ("place", "gain_sd", "ratio", "misfit")  # numbers without a unit
_MEANINGS = {
    name: {"long_name": meaning} | ({"units": "1"} if name in _SHARES else {})
    for name, meaning in _COLUMN_MEANINGS.items()
}


@dataclass(frozen=True, eq=False)
class _SiteFit:
    """A fit to some of the sites: where it ended, and what all of them are there."""

    x: np.ndarray
    covariance: np.ndarray
    coefficients: np.ndarray
    jacobian: np.ndarray
    waves: np.ndarray


def what_sites_add(
    space: ParameterSpace, compared: Compared, numerics: Numerics, method: str, x: np.ndarray, x_alone: np.ndarray
) -> tuple[xr.Dataset, list[Finding]]:
    """Return what each site of a fit that ended at the logarithms `x` adds, and what is found of them.

    Without any site the search ended at `x_alone`: what is predicted by the inlet alone owes nothing to a site.

    Returns
    -------
    Dataset
        By ``site``: ``vessel, observed`` (the quantity), ``place`` (share of the length), ``unit, error, zero_sd,
        gain_sd``, and ``mean, systolic, diastolic`` where it is numbers;
        ``measured, simulated, predicted`` by ``time`` (s; NaN of a site that is numbers; predicted by the fit without
        it); ``misfit`` (r.m.s. of what the prediction misses, over what was expected) and ``ratio`` (measured over what
        the fit of the inlet alone predicts). By ``quantity`` (wave_speed, R_T and the free parameters):
        ``value, low, high`` (95 %) with all sites, and ``value_without, low_without, high_without`` by site.
    """
    sites = compared.sites
    assert sites is not None
    names = ["wave_speed", "R_T", *space.free_names]
    complete = _ended(space, compared, sites, numerics, method, x)
    alone = _ended(space, replace(compared, sites=None), sites, numerics, method, x_alone)
    ends, findings = [], list[Finding]()
    for site, observation in enumerate(sites.observations):
        remaining = sites.without(site)
        without = (
            alone
            if remaining is None
            else _ended(space, replace(compared, sites=remaining), sites, numerics, method, x, x_alone)
        )
        ratio, misfit = _ratio(sites, site, alone), _misfit(sites, site, without)
        if (slip := _slip(observation.quantity, ratio, alone, sites, site)) is not None:
            findings.append(SITE_UNIT(site=observation.title, ratio=ratio, why=slip))
        elif misfit > _MAX_SITE_MISFIT:
            findings.append(SITE_APART(site=observation.title, misfit=misfit))
        ends.append((without, ratio, misfit))
    return _dataset(space, compared, sites, names, complete, ends), findings


def _ended(
    space: ParameterSpace, compared: Compared, sites: Sites, numerics: Numerics, method: str, *starts: np.ndarray
) -> _SiteFit:
    """Return the best end of searches with some of the sites, and what all of them are there."""
    searched = []
    for start in starts:
        objective = Objective(space, compared, numerics, threads(), threading.Event())
        searched.append(search(objective, start, method, FINAL_TOLERANCE))
    best = min(searched, key=lambda end: end.S)
    if not np.isfinite(best.S):
        raise NumericalError(f"the fit without a site could not be simulated; {best.message}")
    all_sites = Objective(space, replace(compared, sites=sites), numerics, threads(), threading.Event())
    jacobian = all_sites.jacobian(best.x)
    waves = all_sites.waves(best.x)
    assert waves is not None
    fitted = Objective(space, compared, numerics, threads(), threading.Event())
    residual, fitted_jacobian = fitted.residuals(best.x), fitted.jacobian(best.x)
    spread = spread_of(space, best.x, fitted_jacobian, residual, compared)
    signals = np.array([resample(waves.of(observation.quantity)[:, i], compared.samples)
                        for i, observation in enumerate(sites.observations)])  # fmt: skip
    at_sites = -np.linalg.solve(sites.balance, jacobian[compared.samples :])
    return _SiteFit(best.x, spread.covariance, sites.coefficients(waves), at_sites, signals)


def _ratio(sites: Sites, site: int, end: _SiteFit) -> float:
    """Return what is measured at a site over what a fit predicts there, by least squares."""
    rows = sites.rows[site]
    y, predicted = sites.measured[rows], end.coefficients[rows]
    return float(y @ predicted / (predicted @ predicted))


def _slip(quantity: str, ratio: float, end: _SiteFit, sites: Sites, site: int) -> str | None:
    """Return what unit a site was probably read in; None where its ratio to the prediction may be 1."""
    rows, gain = sites.rows[site], sites.observations[site].gain
    predicted = end.coefficients[rows]
    slope = predicted @ end.jacobian[rows] / (predicted @ predicted)
    sd = np.sqrt(slope @ end.covariance @ slope + gain**2 + SIZE_PRIOR[0] ** 2)
    if ratio <= 0 or abs(np.log(ratio)) < _MIN_RATIO_SD * sd:
        return None
    slips = {1.0: ""}
    for factor, description in _slips(quantity):
        slips.setdefault(factor, description)
    nearest = min(slips, key=lambda candidate: abs(np.log(ratio / candidate)))
    return slips[nearest] or None


def _slips(quantity: str) -> Iterator[tuple[float, str]]:
    """Yield by what a quantity is multiplied where one unit was taken for another, and what happened then.

    Of units of one size the first is named, and pairs with the unit that values are held in come first.
    """
    named = {scale: unit for unit, scale in reversed(ratios(quantity).items())}
    for true_scale, read_scale in sorted(permutations(named, 2), key=lambda pair: 1.0 not in pair):
        yield read_scale / true_scale, f"{named[true_scale]} had been read as {named[read_scale]}"
    for measure, factor in _GEOMETRY_POWERS.get(quantity, {}).items():
        yield factor, f"{measure} had been given for it"
        yield 1 / factor, f"it had been given for {measure}"


def _misfit(sites: Sites, site: int, end: _SiteFit) -> float:
    """Return the r.m.s. of what a fit misses at a site over what is expected of it."""
    rows = sites.rows[site]
    missed = sites.measured[rows] - end.coefficients[rows]
    expected = np.diag(sites.covariance)[rows] + sites.deviation**2
    expected = expected + np.einsum("ki,ij,kj->k", end.jacobian[rows], end.covariance, end.jacobian[rows])
    return float(np.sqrt(missed @ missed / expected.sum()))


def _intervals(space: ParameterSpace, end: _SiteFit, mean: float) -> np.ndarray:
    """Return value, low and high of wave speed, R_T and the free parameters, shape (3, quantity)."""

    def logarithms(x: np.ndarray) -> np.ndarray:
        model = space.model(space.values(x))
        wall, _ = model.at(np.array(model.network.root), np.array(0.0))
        speed = float(np.asarray(wave_speed(wall, mean, model.blood.inertia)))
        return np.log([speed, total_resistance(space, x), *np.exp(x)])

    steps = _LOG_STEP * np.eye(len(end.x))
    slopes = np.array([(logarithms(end.x + h) - logarithms(end.x - h)) / (2 * _LOG_STEP) for h in steps])
    reach = NORMAL * np.sqrt(np.einsum("iq,ij,jq->q", slopes, end.covariance, slopes))
    middle = logarithms(end.x)
    return np.exp([middle, middle - reach, middle + reach])


def _dataset(
    space: ParameterSpace,
    compared: Compared,
    sites: Sites,
    names: list[str],
    complete: _SiteFit,
    ends: list[tuple[_SiteFit, float, float]],
) -> xr.Dataset:
    mean, N = compared.recording.mean_pressure, compared.samples
    waveforms = [observation.waveform for observation in sites.observations]
    measured = [np.full(N, np.nan) if waveform is None else resample(waveform, N) for waveform in waveforms]
    all_of = _intervals(space, complete, mean)
    without = np.array([_intervals(space, end, mean) for end, _, _ in ends])
    by_site = {
        "vessel": [observation.vessel for observation in sites.observations],
        "observed": [observation.quantity for observation in sites.observations],
        "unit": [observation.unit for observation in sites.observations],
    }
    numbers = {
        "place": sites.places.share,
        "error": [observation.error for observation in sites.observations],
        "zero_sd": [observation.zero_sd for observation in sites.observations],
        "gain_sd": [observation.gain for observation in sites.observations],
        **{name: [observation.numbers.get(name, np.nan) for observation in sites.observations] for name in NUMBERS},
        "ratio": [ratio for _, ratio, _ in ends],
        "misfit": [misfit for _, _, misfit in ends],
    }
    waves = {
        "measured": measured,
        "simulated": complete.waves,
        "predicted": [end.waves[site] for site, (end, _, _) in enumerate(ends)],
    }
    quantities = dict(zip(("value", "low", "high"), all_of, strict=True))
    variables = {
        **{name: ("site", np.array(value, object)) for name, value in by_site.items()},
        **{name: ("site", np.array(value, float)) for name, value in numbers.items()},
        **{name: (("site", "time"), np.array(value)) for name, value in waves.items()},
        **{name: ("quantity", value) for name, value in quantities.items()},
        **{f"{name}_without": (("site", "quantity"), without[:, i]) for i, name in enumerate(quantities)},
    }
    return xr.Dataset(
        {name: (*variable, _MEANINGS[name]) for name, variable in variables.items()},
        coords={
            "site": np.array([observation.title for observation in sites.observations], object),
            "time": ("time", compared.time, {"units": "s"}),
            "quantity": np.array(names, object),
        },
    )
