"""What the data determine: standard errors, 95 % intervals and correlations, and sentences about them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from vasowave.calibration.compared import Compared
from vasowave.calibration.parameters import Space
from vasowave.noise.spectrum import NORMAL, known_variance, least_squares_covariance, likely_spectra

_FARTHEST = 200.0  # in the logarithm: an endless interval stays a finite number
_NEAR_BOUND = 1e-3  # in the logarithm
WIDEST = 4.0
"""A parameter is determined if the ends of its 95 % interval differ by at most this factor."""

_INSEPARABLE = 0.95  # correlation above which two parameters are named together


def covariance(jacobian: np.ndarray, residual: np.ndarray) -> np.ndarray:
    """Covariance of the free parameters' logarithms if every sample had independent noise."""
    N, D = jacobian.shape
    variance = float(residual @ residual) / max(1, N - D)
    return variance * np.linalg.pinv(jacobian.T @ jacobian, rcond=1e-14, hermitian=True)


@dataclass(frozen=True, eq=False)
class Spread:
    """How uncertain the logarithms of the free parameters are, for the smooth noise that the residual shows.

    Attributes
    ----------
    covariance : array, shape (free, free)
        Whose normal 95 % intervals are those of all spectra of the noise that the residual leaves possible.
    independent : array, shape (free,)
        Standard errors if every sample had independent noise.
    assumed : bool
        Whether the prior of the size of the noise decides; see `noise.spectrum`.
    """

    covariance: np.ndarray
    independent: np.ndarray
    assumed: bool


def spread_of(space: Space, jacobian: np.ndarray, residual: np.ndarray, compared: Compared) -> Spread:
    """Return the spread of least-squares estimates under the error of the measurement and the model's discrepancy.

    The error is known from the beats; of the spectrum of the discrepancy the residual tells the rest.
    """
    low, high = space.log_bounds
    known = known_variance(compared.error_power(), len(residual))
    spectra = likely_spectra(residual, jacobian, known)
    independent = np.sqrt(np.diag(covariance(jacobian, residual)))
    return Spread(least_squares_covariance(jacobian, spectra, high - low), independent, spectra.assumed)


def parameter_table(space: Space, x: np.ndarray, spread: Spread) -> pd.DataFrame:
    """One row per parameter; see `Fit.parameters`."""
    values = space.values(x)
    independent, correlated = (np.full(len(values), np.nan) for _ in range(2))
    independent[space.free] = spread.independent
    correlated[space.free] = np.sqrt(np.diag(spread.covariance))
    reach = np.minimum(NORMAL * correlated, _FARTHEST)
    low, high = space.log_bounds
    at_bound = np.zeros(len(values), dtype=bool)
    at_bound[space.free] = (x - low < _NEAR_BOUND) | (high - x < _NEAR_BOUND)
    return pd.DataFrame(
        {
            "unit": [one.unit for one in space.parameters.values()],
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
            "determined": space.free & ~at_bound & (2 * reach <= np.log(WIDEST)),
        },
        index=pd.Index(space.names, name="parameter"),
    )


def correlations(space: Space, spread: Spread) -> pd.DataFrame:
    """Correlation of the free parameters' estimates, for smooth noise."""
    scale = np.sqrt(np.diag(spread.covariance))
    with np.errstate(divide="ignore", invalid="ignore"):
        matrix = spread.covariance / np.outer(scale, scale)
    return pd.DataFrame(matrix, index=list(space.free_names), columns=list(space.free_names))


def sentences(table: pd.DataFrame, correlation: pd.DataFrame, starts: pd.DataFrame, spread: Spread) -> list[str]:
    """Say in words what a reader of the optimum must know."""
    return [
        *_at_bounds(table),
        *undetermined(table),
        *_inseparable(correlation),
        *_assumed(spread),
        *_disagreeing(starts),
    ]


def _at_bounds(table: pd.DataFrame) -> list[str]:
    said = []
    for name, row in table[table["at_bound"]].iterrows():
        low = abs(np.log(row["value"] / row["lower"])) < _NEAR_BOUND
        end, further = ("lower", "smaller") if low else ("upper", "larger")
        said.append(
            f"{name} = {row['value']:.4g} lies at its {end} bound: the best fit would be at a {further} value, so this "
            "is the bound's number and not the data's, and the intervals of the others hold for it as it stands."
        )
    held = table[~table["free"]]
    if len(held):
        values = ", ".join(f"{name} = {row['value']:.4g}" for name, row in held.iterrows())
        said.append(f"Held, not fitted: {values}.")
    return said


def undetermined(table: pd.DataFrame) -> list[str]:
    """Name the free parameters inside their bounds that the data do not determine."""
    loose = table[table["free"] & ~table["determined"] & ~table["at_bound"]]
    return [
        f"The data do not determine {name}: its 95 % interval reaches from {row['interval_low']:.3g} to "
        f"{row['interval_high']:.3g}."
        for name, row in loose.iterrows()
    ]


def _inseparable(correlation: pd.DataFrame) -> list[str]:
    names: Sequence[str] = list(correlation.index)
    pairs = [(one, other) for i, one in enumerate(names) for other in names[i + 1 :]]
    return [
        f"{one} and {other} can hardly be told apart (correlation {correlation[other][one]:.3f}): a change of one is "
        "made up for by the other, and neither means much without it."
        for one, other in pairs
        if abs(float(correlation[other][one])) > _INSEPARABLE
    ]


def _assumed(spread: Spread) -> list[str]:
    """Say where an assumption of `noise.spectrum` decides the width of the intervals."""
    if not spread.assumed:
        return []
    return [
        "The residual hardly tells how strong the noise is that the fit hides at the lowest harmonics: the width of "
        "the intervals rests on the assumption that it is known within a factor of 4."
    ]


def _disagreeing(starts: pd.DataFrame) -> list[str]:
    agree = int(starts["agrees"].sum())
    if agree == len(starts):
        return []
    return [
        f"{agree} of {len(starts)} starts ended at the best optimum; the others found worse ones or failed (see the "
        "table of starts)."
    ]
