"""What the posteriors of one animal say about its wall laws: evidence, and how well each foretells what is left out."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from vasowave.base.descriptions import CLEAR_EVIDENCE_RATIO
from vasowave.base.errors import InputError
from vasowave.pulse.inference.result import Posterior
from vasowave.pulse.quantities import ACROSS_LAWS
from vasowave.pulse.selection.averaging import averaged_draws


def compare_laws(posteriors: Sequence[Posterior]) -> xr.Dataset:
    """Weigh the wall laws of one animal by their evidence.

    Parameters
    ----------
    posteriors : sequence of Posterior
        Of one recording, one a law, with the same priors of what the laws have in common.

    Returns
    -------
    Dataset
        By ``wall``: ``log_evidence`` and its standard error ``log_evidence_error``, ``weight`` (probability of the law
        if all were as likely before), ``left_out`` by ``block`` of harmonics, with ``left_out_k_hat``. By ``quantity``:
        ``median, interval_low, interval_high`` (95 %) over the laws by their weights, and ``between_laws``, the share
        of the variance of the logarithm that lies between them. The attribute ``said`` is a sentence for a reader.

    Raises
    ------
    InputError
        Fewer than two posteriors, two of one law, or other harmonics compared.
    """
    walls = [posterior.wall for posterior in posteriors]
    if len(set(walls)) < max(len(walls), 2):
        raise InputError("laws are compared by the posteriors of two or more different ones")
    if len({posterior.diagnostics.harmonics for posterior in posteriors}) > 1:
        raise InputError("the posteriors compare different harmonics of the pressure; give all the same number")
    log = np.array([posterior.diagnostics.log_evidence for posterior in posteriors])
    weight = np.exp(log - log.max()) / np.exp(log - log.max()).sum()
    blocks = posteriors[0].left_out.index.to_numpy(object)
    comparison = xr.Dataset(
        {
            "log_evidence": ("wall", log),
            "log_evidence_error": ("wall", [posterior.diagnostics.log_evidence_error for posterior in posteriors]),
            "weight": ("wall", weight),
            "left_out": (("wall", "block"), [posterior.left_out["log_density"].to_numpy() for posterior in posteriors]),
            "left_out_k_hat": (("wall", "block"), [posterior.left_out["k_hat"].to_numpy() for posterior in posteriors]),
        },
        {"wall": np.array(walls, object), "block": blocks},
        {"said": _said(posteriors, weight)},
    )
    for variable in comparison.data_vars.values():
        variable.attrs["units"] = "1"
    return comparison.merge(_averages(posteriors, weight))


def _averages(posteriors: Sequence[Posterior], weight: np.ndarray) -> xr.Dataset:
    """Return the quantities over the mixture of all draws."""
    names = [name for name in ACROSS_LAWS if all(name in posterior.summary.index for posterior in posteriors)]
    rows = [averaged_draws([posterior.draws(name) for posterior in posteriors], weight) for name in names]
    table = dict(zip(("median", "interval_low", "interval_high", "between_laws"), np.transpose(rows), strict=True))
    units = posteriors[0].summary["unit"]
    return xr.Dataset(
        {name: ("quantity", values) for name, values in table.items()},
        {"quantity": np.array(names, object), "unit": ("quantity", [units[name] for name in names])},
    )


def _said(posteriors: Sequence[Posterior], weight: np.ndarray) -> str:
    """Say how much likelier the best law is than the next, and by what of the recording."""
    best, second = np.argsort(weight)[::-1][:2]
    winner, runner_up = posteriors[best], posteriors[second]
    if not all(posterior.diagnostics.trusted for posterior in posteriors):
        return "A posterior that cannot be trusted leaves open which wall law is likelier."
    ratio = np.exp(winner.diagnostics.log_evidence - runner_up.diagnostics.log_evidence)
    degree = "clearly" if ratio >= CLEAR_EVIDENCE_RATIO else "not clearly"
    amount = f"{ratio:.2g} times" if ratio < 1000 else "over 1000 times"
    gain = (winner.left_out["log_density"] - runner_up.left_out["log_density"]).sort_values()
    sentence = (
        f"With image and structure unknown the recording is {amount} as likely under the {winner.wall} law as under "
        f"the {runner_up.wall} law: {degree} likelier."
    )
    if ratio >= CLEAR_EVIDENCE_RATIO:
        sentence += f" What it foretells better is above all harmonic {gain.index[-1]}."
    return sentence
