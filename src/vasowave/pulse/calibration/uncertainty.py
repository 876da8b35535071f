"""What the data determine: standard errors, 95 % intervals and correlations, and what is found of them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from vasowave.base.descriptions import MAX_LOG_DISTANCE, NORMAL
from vasowave.base.findings import Finding, look_kind, note_kind
from vasowave.pulse.calibration.compared import Compared
from vasowave.pulse.calibration.parameters import ParameterSpace
from vasowave.pulse.model.outlets import OF_DROP
from vasowave.pulse.noise.spectrum import Beside, known_variance, least_squares_covariance, likely_spectra

_BOUND_DISTANCE = 1e-3  # in the logarithm
MAX_INTERVAL_RATIO = 4.0
"""A parameter is determined if the ends of its 95 % interval differ by at most this factor."""

_MAX_CORRELATION = 0.95  # correlation above which two parameters are named together

_BOUND_TEXT = (
    "{{parameter}} = {{value:.4g}} lies at its {} bound: the best fit would be at a {} value, so this is the bound's "
    "number and not the data's, and the intervals of the others hold for it as it stands."
)
_BOUND_REMEDY = "Widen its bounds, or ask whether the law suits this animal."
AT_LOWER = look_kind("fit.at-lower-bound", _BOUND_TEXT.format("lower", "smaller"), _BOUND_REMEDY)
AT_UPPER = look_kind("fit.at-upper-bound", _BOUND_TEXT.format("upper", "larger"), _BOUND_REMEDY)
HELD = note_kind("fit.held", "Held, not fitted: {values}.")
UNDETERMINED = note_kind(
    "fit.undetermined", "The data do not determine {parameter}: its 95 % interval reaches from {low:.3g} to {high:.3g}."
)
INSEPARABLE = note_kind(
    "fit.inseparable",
    "{one} and {other} can hardly be told apart (correlation {correlation:.3f}): a change of one is made up for by the "
    "other, and neither means much without it.",
)
NOISE_ASSUMED = note_kind(
    "fit.noise-assumed",
    "The residual hardly tells how strong the noise is that the fit hides at the lowest harmonics: the width of the "
    "intervals rests on the assumption that it is known within a factor of 4.",
)
STARTS_DISAGREE = note_kind(
    "fit.starts-disagree",
    "{agree} of {starts} starts ended at the best optimum; the others found worse ones or failed (see the table of "
    "starts).",
)


def covariance(jacobian: np.ndarray, residual: np.ndarray) -> np.ndarray:
    """Covariance of the free parameters' logarithms if every sample had independent noise."""
    N, D = jacobian.shape
    variance = float(residual @ residual) / max(1, N - D)
    return variance * np.linalg.pinv(jacobian.T @ jacobian, rcond=1e-14, hermitian=True)


@dataclass(frozen=True, eq=False)
class ParameterSpread:
    """How uncertain the logarithms of the free parameters are, for the smooth noise that the residual shows.

    Attributes
    ----------
    covariance : array, shape (free, free)
        Whose normal 95 % intervals are those of all spectra of the noise that the residual leaves possible.
    independent : array, shape (free,)
        Standard errors if every sample had independent noise.
    assumed : bool
        Whether the prior of the size of the noise decides; see `noise.spectrum`.
    response : sequence of float
        Standard errors of what is fitted of the response of the pressure, in SD of the prior.
    """

    covariance: np.ndarray
    independent: np.ndarray
    assumed: bool
    response: Sequence[float] = ()


def spread_of(
    space: ParameterSpace,
    x: np.ndarray,
    jacobian: np.ndarray,
    residual: np.ndarray,
    compared: Compared,
    of_response: np.ndarray | None = None,
) -> ParameterSpread:
    """Return the spread of least-squares estimates under the error of the measurement and the model's discrepancy.

    The error is known from the beats; of the spectrum of the discrepancy the residual tells the rest. Its mean is
    bounded by what the pressure falls along the vessels (`outlets.OF_DROP`). `of_response` are the derivatives of
    the residual by what was fitted of the response of the pressure, in SD of the prior.
    """
    count, free = compared.samples, len(x)
    pressure, flow = compared.mean_state(residual[:count])
    drop = pressure - space.outlet_pressure - flow * total_resistance(space, x)
    of_mean = OF_DROP * max(drop, 0.0) * compared.per_pressure
    low, high = space.log_bounds
    ranges = high - low
    if of_response is not None:
        jacobian = np.column_stack([jacobian, of_response])
        ranges = np.append(ranges, np.full(jacobian.shape[1] - free, np.sqrt(12.0)))  # variance 1, as the prior
    variance = known_variance(compared.error_power(), count)
    pulse, site_terms = compared.recording.pulse_pressure, _beside(compared, jacobian, residual)
    at_inlet = jacobian[:count]
    spectra = likely_spectra(residual[:count], at_inlet, pulse, variance, of_mean, site_terms)
    independent = np.sqrt(np.diag(covariance(jacobian, residual)))
    full_covariance = least_squares_covariance(at_inlet, spectra, ranges, site_terms)
    return ParameterSpread(
        full_covariance[:free, :free],
        independent[:free],
        spectra.assumed,
        tuple(np.sqrt(np.diag(full_covariance)[free:])),
    )


def _beside(compared: Compared, jacobian: np.ndarray, residual: np.ndarray) -> Beside | None:
    """Return what further sites say, from residuals and Jacobian of an objective."""
    sites = compared.sites
    if sites is None:
        return None
    plain = np.linalg.inv(sites.balance)
    in_units = plain @ residual[compared.samples :], plain @ jacobian[compared.samples :]
    return Beside(sites.harmonic, *in_units, sites.balance, sites.covariance)


def total_resistance(space: ParameterSpace, x: np.ndarray) -> float:
    """Return R_T, mmHg s/ml, at the logarithms `x` of the free parameters."""
    return float(space.model(space.values(x)).outlets.total_resistance())


def parameter_table(space: ParameterSpace, x: np.ndarray, spread: ParameterSpread) -> pd.DataFrame:
    """One row per parameter; see `Fit.parameters`."""
    values = space.values(x)
    independent, correlated = (np.full(len(values), np.nan) for _ in range(2))
    independent[space.free] = spread.independent
    correlated[space.free] = np.sqrt(np.diag(spread.covariance))
    reach = np.minimum(NORMAL * correlated, MAX_LOG_DISTANCE)
    low, high = space.log_bounds
    at_bound = np.zeros(len(values), dtype=bool)
    at_bound[space.free] = (x - low < _BOUND_DISTANCE) | (high - x < _BOUND_DISTANCE)
    return pd.DataFrame(
        {
            "unit": [parameter.unit for parameter in space.parameters.values()],
            "nominal": space.nominal,
            "lower": space.lower,
            "upper": space.upper,
            "value": values,
            "standard_error": independent * values,
            "standard_error_correlated": correlated * values,
            "interval_low": values * np.exp(-reach),
            "interval_high": values * np.exp(reach),
            "at_bound": at_bound,
            "free": space.free,
            "determined": space.free & ~at_bound & (2 * reach <= np.log(MAX_INTERVAL_RATIO)),
        },
        index=pd.Index(space.names, name="parameter"),
    )


def correlations(space: ParameterSpace, spread: ParameterSpread) -> pd.DataFrame:
    """Correlation of the free parameters' estimates, for smooth noise."""
    scale = np.sqrt(np.diag(spread.covariance))
    with np.errstate(divide="ignore", invalid="ignore"):
        matrix = spread.covariance / np.outer(scale, scale)
    return pd.DataFrame(matrix, index=list(space.free_names), columns=list(space.free_names))


def fit_findings(
    table: pd.DataFrame, correlation: pd.DataFrame, starts: pd.DataFrame, spread: ParameterSpread
) -> list[Finding]:
    """Return what a reader of the optimum must know."""
    agree = int(starts["agrees"].sum())
    return [
        *_at_bounds(table),
        *undetermined(table),
        *_inseparable(correlation),
        *([NOISE_ASSUMED()] if spread.assumed else []),
        *([STARTS_DISAGREE(agree=agree, starts=len(starts))] if agree < len(starts) else []),
    ]


def _at_bounds(table: pd.DataFrame) -> list[Finding]:
    findings = []
    for name, row in table[table["at_bound"]].iterrows():
        low = abs(np.log(row["value"] / row["lower"])) < _BOUND_DISTANCE
        findings.append((AT_LOWER if low else AT_UPPER)(parameter=str(name), value=float(row["value"])))
    held = table[~table["free"]]
    if len(held):
        findings.append(HELD(values=", ".join(f"{name} = {row['value']:.4g}" for name, row in held.iterrows())))
    return findings


def undetermined(table: pd.DataFrame) -> list[Finding]:
    """Return the free parameters inside their bounds that the data do not determine."""
    loose = table[table["free"] & ~table["determined"] & ~table["at_bound"]]
    return [
        UNDETERMINED(parameter=str(name), low=float(row["interval_low"]), high=float(row["interval_high"]))
        for name, row in loose.iterrows()
    ]


def _inseparable(correlation: pd.DataFrame) -> list[Finding]:
    names: Sequence[str] = list(correlation.index)
    pairs = [(first, second) for i, first in enumerate(names) for second in names[i + 1 :]]
    return [
        INSEPARABLE(one=first, other=second, correlation=float(correlation[second][first]))
        for first, second in pairs
        if abs(float(correlation[second][first])) > _MAX_CORRELATION
    ]
