"""Where the variance of an estimate comes from: recording, image, model, or what was assumed before."""

import numpy as np
import pandas as pd

from vasowave.inference.discrepancy import Discrepancy
from vasowave.inference.known_errors import SOURCES


def variance_shares(
    slopes: pd.DataFrame, sources: list[str], jacobian: np.ndarray, noise: Discrepancy, residuals: np.ndarray,
    zero: np.ndarray | None = None,
) -> pd.DataFrame:  # fmt: skip
    """Return each source's share of the variance of each quantity, adding up to 1.

    Around the posterior's middle, where outputs are linear in the scores x with prior N(0, 1), the estimate is
    x̂ = K (data - base) with K = Σ Jᵀ V⁻¹ and Σ = (1 + Jᵀ V⁻¹ J)⁻¹. Its error x - x̂ = (1 - K J) x - K e has the
    covariance Σ, and each independent part of x and of e contributes its own term (Joseph's form).

    Parameters
    ----------
    slopes : DataFrame
        Derivative of each quantity (index) by each score (column).
    sources : list of str
        Of each score: ``recording`` (a parameter, known before only by its prior), ``image``, ``probe``, ``model``.
    jacobian : array, shape (output, score)
    noise : Discrepancy
    residuals : array, shape (draw, output)
    zero : array, shape (output,), optional
        What one SD of the zero of the pressure changes, where `slopes` have a last column for it: it then is an unknown
        beside the scores, and no longer one of the noise's errors of measurement.
    """
    measured = noise.measured
    if zero is not None:
        measured, jacobian = measured - np.outer(zero, zero), np.column_stack([jacobian, zero])
        sources = [*sources, "calibration"]
    parts = {
        "recording": measured,
        "image": noise.vessels @ noise.vessels.T,
        "model": np.diag(noise.variance(residuals)),
    }
    gain = np.linalg.solve(sum(parts.values()), jacobian).T
    covariance = np.linalg.inv(np.eye(len(sources)) + gain @ jacobian)
    K = covariance @ gain
    left = np.eye(len(sources)) - K @ jacobian
    G, table = slopes.to_numpy(float), {}
    for name in SOURCES:
        own = np.array([("prior" if one == "recording" else one) == name for one in sources])
        variance = ((G @ left[:, own]) ** 2).sum(axis=1)
        if name in parts:
            variance = variance + np.einsum("qi,ij,qj->q", G @ K, parts[name], G @ K)
        table[name] = variance
    frame = pd.DataFrame(table, index=slopes.index)
    return frame.div(frame.sum(axis=1), axis=0)
