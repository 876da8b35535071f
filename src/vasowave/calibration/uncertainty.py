"""What the data determine: standard errors, 95 % intervals and correlations, and sentences about them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from vasowave.calibration.parameters import Space
from vasowave.noise.spectrum import least_squares_covariance, noise_spectrum

LEVEL = 0.95
"""Level of the intervals, symmetric in the logarithm of a parameter."""

_FARTHEST = 200.0  # in the logarithm: an endless interval stays a finite number
_NEAR_BOUND = 1e-3  # in the logarithm
UNDETERMINED = 0.5  # a parameter whose standard error exceeds half its value is not determined
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
    degrees_of_freedom : array, shape (free,)
        Of each variance.
    independent : array, shape (free,)
        Standard errors if every sample had independent noise.
    """

    covariance: np.ndarray
    degrees_of_freedom: np.ndarray
    independent: np.ndarray


def spread_of(space: Space, jacobian: np.ndarray, residual: np.ndarray) -> Spread:
    """Return the spread of least-squares estimates under the one noise spectrum that is fitted to their residual."""
    low, high = space.log_bounds
    matrix, degrees = least_squares_covariance(residual, jacobian, noise_spectrum(residual, jacobian), high - low)
    return Spread(matrix, degrees, np.sqrt(np.diag(covariance(jacobian, residual))))


def parameter_table(space: Space, x: np.ndarray, spread: Spread) -> pd.DataFrame:
    """One row per parameter; see `Fit.parameters`."""
    from scipy.special import stdtrit

    values = space.values(x)
    independent, correlated, freedom = (np.full(len(values), np.nan) for _ in range(3))
    independent[space.free] = spread.independent
    correlated[space.free] = np.sqrt(np.diag(spread.covariance))
    freedom[space.free] = np.minimum(spread.degrees_of_freedom, 1e6)
    reach = np.minimum(stdtrit(freedom, 0.5 + 0.5 * LEVEL) * correlated, _FARTHEST)
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
            "degrees_of_freedom": freedom,
            "interval_low": values * np.exp(-reach),
            "interval_high": values * np.exp(reach),
            "at_bound": at_bound,
            "free": space.free,
            "determined": space.free & ~at_bound & (correlated < UNDETERMINED),
        },
        index=pd.Index(space.names, name="parameter"),
    )


def correlations(space: Space, spread: Spread) -> pd.DataFrame:
    """Correlation of the free parameters' estimates, for smooth noise."""
    scale = np.sqrt(np.diag(spread.covariance))
    with np.errstate(divide="ignore", invalid="ignore"):
        matrix = spread.covariance / np.outer(scale, scale)
    return pd.DataFrame(matrix, index=list(space.free_names), columns=list(space.free_names))


def sentences(table: pd.DataFrame, correlation: pd.DataFrame, starts: pd.DataFrame) -> list[str]:
    """Say in words what a reader of the optimum must know."""
    found = []
    for name, row in table[table["at_bound"]].iterrows():
        end = "lower" if abs(np.log(row["value"] / row["lower"])) < _NEAR_BOUND else "upper"
        found.append(f"{name} = {row['value']:.4g} lies at its {end} bound: the data ask for more; widen the bound.")
    loose = table.index[table["free"] & ~table["determined"] & ~table["at_bound"]]
    for name in loose:
        share = table["standard_error_correlated"][name] / table["value"][name]
        found.append(f"The data do not determine {name}: its standard error is {100 * share:.0f} % of its value.")
    names: Sequence[str] = list(correlation.index)
    for i, first in enumerate(names):
        for second in names[i + 1 :]:
            r = float(correlation[second][first])
            if abs(r) > _INSEPARABLE:
                other = "ratio" if r > 0 else "product"
                found.append(
                    f"{first} and {second} can hardly be told apart (correlation {r:.3f}); trust their {other} only."
                )
    agree = int(starts["agrees"].sum())
    if agree < len(starts):
        found.append(
            f"{agree} of {len(starts)} starts ended at the best optimum; the others found worse ones or failed "
            "(see the table of starts)."
        )
    return found
