"""What the data determine: standard errors and correlations from the Jacobian, and sentences about them."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from vasowave.calibration.parameters import UNITS, Space

_NEAR_BOUND = 1e-3  # in the logarithm
UNDETERMINED = 0.5  # a parameter whose standard error exceeds half its value is not determined
_INSEPARABLE = 0.95  # correlation above which two parameters are named together


def covariance(jacobian: np.ndarray, residual: np.ndarray) -> tuple[np.ndarray, float]:
    """Covariance of the free parameters' logarithms for independent noise, and the factor for correlated noise.

    Residuals of a fit are smooth, so N samples hold less than N pieces of information. With lag-one correlation φ the
    variance of an estimate grows by (1 + φ)/(1 - φ), the factor that is returned.
    """
    N, D = jacobian.shape
    variance = float(residual @ residual) / max(1, N - D)
    inverse = np.linalg.pinv(jacobian.T @ jacobian, rcond=1e-14, hermitian=True)
    power = float(residual @ residual)
    phi = float(residual @ np.roll(residual, 1)) / power if power > 0 else 0.0
    phi = min(max(phi, 0.0), 0.999)
    return variance * inverse, (1 + phi) / (1 - phi)


def parameter_table(space: Space, x: np.ndarray, jacobian: np.ndarray, residual: np.ndarray) -> pd.DataFrame:
    """One row per parameter; see `Fit.parameters`."""
    values = space.values(x)
    cov, inflation = covariance(jacobian, residual)
    relative = np.full(len(values), np.nan)
    relative[space.free] = np.sqrt(np.diag(cov))
    low, high = space.log_bounds
    at_bound = np.zeros(len(values), dtype=bool)
    at_bound[space.free] = (x - low < _NEAR_BOUND) | (high - x < _NEAR_BOUND)
    correlated = relative * np.sqrt(inflation)
    return pd.DataFrame(
        {
            "unit": [UNITS[name] for name in space.names],
            "nominal": space.nominal,
            "lower": space.lower,
            "upper": space.upper,
            "value": values,
            "standard_error": relative * values,
            "standard_error_correlated": correlated * values,
            "at_bound": at_bound,
            "free": space.free,
            "determined": space.free & ~at_bound & (correlated < UNDETERMINED),
        },
        index=pd.Index(space.names, name="parameter"),
    )


def correlations(space: Space, jacobian: np.ndarray, residual: np.ndarray) -> pd.DataFrame:
    """Correlation of the free parameters' estimates."""
    cov, _ = covariance(jacobian, residual)
    scale = np.sqrt(np.diag(cov))
    with np.errstate(divide="ignore", invalid="ignore"):
        matrix = cov / np.outer(scale, scale)
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
