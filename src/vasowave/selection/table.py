"""The table of a comparison: one row for every noise model and wall law, as labelled data."""

import json
from collections.abc import Mapping

import numpy as np
import xarray as xr

from vasowave.noise.models import CirculantNoise, Noise
from vasowave.selection.criteria import UNDECIDED, aicc, bic, verdicts

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


def scored(residuals: Mapping[str, np.ndarray], n_parameters: Mapping[str, int], noise: Noise) -> list[dict]:
    """Return one row for every wall law, the best first."""
    rows: dict[str, dict] = {}
    for wall, one in residuals.items():
        D, N, likelihood = n_parameters[wall], len(one), noise.log_likelihood(one)
        scores = {"AICc": aicc(likelihood, D, N), "BIC": bic(likelihood, D, N)}
        rows[wall] = {"wall": wall, "loglik": likelihood, "D": D, "N": N, **scores}
    for criterion in ("AICc", "BIC"):
        for wall, difference, verdict in verdicts({wall: row[criterion] for wall, row in rows.items()}):
            rows[wall] |= {f"{criterion}_difference": difference, f"{criterion}_verdict": verdict}
    weight = np.nan if isinstance(noise, CirculantNoise) else noise.weight
    noted = {"lambda": weight, "hyperparameters": json.dumps(noise.hyperparameters)}
    return [row | noted for row in sorted(rows.values(), key=lambda row: row["AICc"])]


def noise_bic(rows: list[dict]) -> float:
    """BIC of a noise model: minus twice its log-likelihood of all residuals, plus its hyperparameters' price."""
    count = len(json.loads(rows[0]["hyperparameters"])) - (2 if rows[0]["covariance"] == "ARMA" else 0)
    return sum(-2 * row["loglik"] for row in rows) + count * np.log(sum(row["N"] for row in rows))


def preferred(blocks: list[list[dict]]) -> str:
    """Return the likeliest noise model that is not discarded, empty if there is none."""
    return next((str(rows[0]["covariance"]) for rows in blocks if not rows[0]["discarded"]), "")


def dataset(rows: list[dict]) -> xr.Dataset:
    """Return the rows as labelled data, dim ``candidate``."""
    variables = {}
    for name, meaning in _MEANINGS.items():
        values = np.array([row[name] for row in rows], dtype=object if name in _TEXT else float)
        attributes = {"long_name": meaning} | ({} if name in _TEXT else {"units": "1"})
        variables[name] = ("candidate", values, attributes)
    return xr.Dataset(variables)
