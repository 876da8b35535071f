"""AICc and BIC, what their differences decide, and the table of a comparison of wall laws."""

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from vasowave.base.errors import InputError
from vasowave.base.stores import parsed
from vasowave.pulse.noise.models import CirculantNoise, Noise

UNDECIDED = 5.0
"""Differences of AICc or BIC below this decide nothing."""
_TEXT = ("covariance", "wall", "AICc_verdict", "BIC_verdict", "hyperparameters")
_MEANINGS = {
    "loglik": "log-likelihood (eq. 23)",
    "D": "fitted parameters",
    "N": "pressure samples",
    "AICc": "corrected Akaike information criterion (eq. 21)",
    "BIC": "Bayesian information criterion (eq. 22)",
    "AICc_difference": "AICc minus the least of the wall laws under the same covariance",
    "BIC_difference": "BIC minus the least of the wall laws under the same covariance",
    "AICc_verdict": f"what AICc says; a difference below {UNDECIDED:g} is undecided",
    "BIC_verdict": f"what BIC says; a difference below {UNDECIDED:g} is undecided",
    "lambda": "weight of the regularization",
    "discarded": "1 where the covariance needs too large a weight of the regularization",
    "covariance": "noise model",
    "wall": "wall law",
    "hyperparameters": "hyperparameters of the noise model, JSON",
}


def aicc(log_likelihood: float, parameters: int, samples: int) -> float:
    """AICc = -2 log L + 2D + 2D(D + 1)/(N - D - 1) (eq. 21)."""
    if samples <= parameters + 1:
        raise InputError(f"AICc needs more than {parameters + 1} samples for {parameters} parameters")
    return -2 * log_likelihood + 2 * parameters + 2 * parameters * (parameters + 1) / (samples - parameters - 1)


def bic(log_likelihood: float, parameters: int, samples: int) -> float:
    """BIC = -2 log L + D log N (eq. 22)."""
    return float(-2 * log_likelihood + parameters * np.log(samples))


def verdicts(scores: Mapping[str, float]) -> list[tuple[str, float, str]]:
    """Return (model, difference to the best, verdict), best first.

    The best is "preferred" if the runner-up is at least `UNDECIDED` behind, and whatever is that far behind is "worse";
    all others are "undecided".
    """
    order = sorted(scores, key=lambda key: scores[key])
    best = scores[order[0]]
    decided = len(order) > 1 and scores[order[1]] - best >= UNDECIDED
    judged = []
    for key in order:
        difference = scores[key] - best
        clear = difference >= UNDECIDED or (key == order[0] and decided)
        judged.append((key, difference, ("preferred" if key == order[0] else "worse") if clear else "undecided"))
    return judged


def scored(residuals: Mapping[str, np.ndarray], n_parameters: Mapping[str, int], noise: Noise) -> list[dict[str, Any]]:
    """Return one row for every wall law, the best first."""
    rows: dict[str, dict[str, Any]] = {}
    for wall, residual in residuals.items():
        D, N, likelihood = n_parameters[wall], len(residual), noise.log_likelihood(residual)
        scores = {"AICc": aicc(likelihood, D, N), "BIC": bic(likelihood, D, N)}
        rows[wall] = {"wall": wall, "loglik": likelihood, "D": D, "N": N, **scores}
    for criterion in ("AICc", "BIC"):
        for wall, difference, verdict in verdicts({wall: row[criterion] for wall, row in rows.items()}):
            rows[wall] |= {f"{criterion}_difference": difference, f"{criterion}_verdict": verdict}
    weight = np.nan if isinstance(noise, CirculantNoise) else noise.weight
    noted = {"lambda": weight, "hyperparameters": json.dumps(noise.hyperparameters)}
    return [row | noted for row in sorted(rows.values(), key=lambda row: row["AICc"])]


def noise_bic(rows: list[dict[str, Any]]) -> float:
    """BIC of a noise model: minus twice its log-likelihood of all residuals, plus its hyperparameters' price."""
    count = len(parsed(rows[0]["hyperparameters"])) - (2 if rows[0]["covariance"] == "ARMA" else 0)
    return sum(-2 * row["loglik"] for row in rows) + count * np.log(sum(row["N"] for row in rows))


def preferred(blocks: list[list[dict[str, Any]]]) -> str:
    """Return the likeliest noise model that is not discarded, empty if there is none."""
    return next((str(rows[0]["covariance"]) for rows in blocks if not rows[0]["discarded"]), "")


def dataset(rows: list[dict[str, Any]]) -> xr.Dataset:
    """Return the rows as labelled data, dim ``candidate``."""
    variables = {}
    for name, meaning in _MEANINGS.items():
        values = np.array([row[name] for row in rows], dtype=object if name in _TEXT else float)
        attributes = {"long_name": meaning} | ({} if name in _TEXT else {"units": "1"})
        variables[name] = ("candidate", values, attributes)
    return xr.Dataset(variables)
