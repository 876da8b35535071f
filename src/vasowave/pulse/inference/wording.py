"""What a posterior means, as findings a physiologist acts on."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pandas as pd

from vasowave.base.findings import Finding, look_kind, note_kind
from vasowave.pulse.cycle.cycle import Recording
from vasowave.pulse.inference.result import Diagnostics
from vasowave.pulse.inference.reweighting import MAX_PARETO_K, trusted
from vasowave.pulse.inference.unknowns import Unknown

MIN_EFFECTIVE_DRAWS = 100.0
"""Effective draws below which the ends of a 95 % interval rest on two draws each."""

_MIN_CONTRACTION = 0.1  # contraction below which the data count as narrowing nothing
_MIN_MEDIAN_SHIFT_SD = 0.5  # SD of the prior between its median and the posterior's, from which they are not the same
_MAX_MEDIAN_SHIFT_SD = 2.0  # SD of the prior between its median and the posterior's, from which they disagree
_MAIN_SOURCE_SHARE = 0.5  # share of the variance from one source that is worth a finding
_MAX_INTERVAL_RATIO = 4.0  # ratio of the ends of an interval beyond which a number is not determined

_DRAWS_REMEDY = "Ask for more draws, start from another fit, or give narrower priors."
HEAVY_TAIL = look_kind(
    "posterior.heavy-tail",
    "Do not believe these numbers: the weights of the draws have a heavy tail (Pareto k {k_hat:.2f}, above {limit:g}). "
    "{remedy}",
    _DRAWS_REMEDY,
)
FEW_DRAWS = look_kind(
    "posterior.few-draws",
    "The draws are worth {effective:.0f} independent ones: medians hold, the ends of intervals are rough. {remedy}",
    "Ask for more draws.",
)
SILENT = note_kind(
    "posterior.silent",
    "The recording says nothing about {names}: posterior and prior are the same, and the interval is that of the "
    "assumption.",
)
MOVED = note_kind(
    "posterior.moved",
    "The recording does not narrow what is known of {names}, but posterior and prior are not the same: {parts}.",
)
WIDE = note_kind("posterior.wide", "{name} is known only within a factor of {factor:.1f} ({low:.3g} to {high:.3g}).")
CONFLICT = look_kind(
    "posterior.prior-conflict",
    "Recording and assumption disagree about {name} ({meaning}): the median lies {distance:.1f} SD of the prior {side} "
    "its center. Either the assumption or the model is wrong for this animal.",
    "Question the assumption (image, pressure, zero) and the wall law.",
)
ZERO_UNSEEN = note_kind(
    "posterior.zero-unseen",
    "An averaged cycle does not show whether the pressure's zero drifted: it is taken to be right within {within:.2g} "
    "mmHg (two SD, `zero_sd`). Every mmHg that it is off moves R_T by {percent:.0f} %.",
)
_SOURCE_TEXT = "The uncertainty of {{names}} comes mostly from the {}: {}."
SOURCE_FINDINGS = {
    source: note_kind(f"posterior.mostly-{source}", _SOURCE_TEXT.format(source, remedy))
    for source, remedy in {
        "image": "a better image would narrow it, more beats would not",
        "model": "it is what the model leaves out, and neither a better image nor more beats would narrow it",
        "recording": "a better recording would narrow it",
        "probe": "a flow probe with a better known gain would narrow it",
        "calibration": "a better known zero of the pressure would narrow it",
    }.items()
}
"""By the source that most of the variance comes from."""


def meanings(summary: pd.DataFrame, scores: pd.Series, unknowns: Mapping[Any, Unknown]) -> Iterator[Finding]:
    """Yield what the numbers mean; `scores` are the medians of the unknowns in SD of their priors."""
    untold = (summary["contraction"] < _MIN_CONTRACTION) & summary.index.isin(list(unknowns))
    wider = summary["contraction"] < -_MIN_CONTRACTION
    moved = untold & (wider | (scores.reindex(summary.index).abs() > _MIN_MEDIAN_SHIFT_SD))
    if (untold & ~moved).any():
        yield SILENT(names=_listed(list(summary.index[untold & ~moved])))
    if moved.any():
        clauses = [
            f"the interval of {name} is wider than that of the prior"
            if wider[name]
            else f"the middle of {name} lies {abs(scores[name]):.1f} SD of the prior {_side(scores[name])} its center"
            for name in summary.index[moved]
        ]
        yield MOVED(names=_listed(list(summary.index[moved])), parts=_listed(clauses))
    factor = summary["interval_high"] / summary["interval_low"]
    for name, row in summary[(summary["prior_low"] > 0) & (factor > _MAX_INTERVAL_RATIO) & ~untold].iterrows():
        low, high = float(row["interval_low"]), float(row["interval_high"])
        yield WIDE(name=str(name), factor=high / low, low=low, high=high)
    for name, score in scores.items():
        if abs(score) > _MAX_MEDIAN_SHIFT_SD:
            meaning = unknowns[str(name)].meaning
            yield CONFLICT(name=str(name), meaning=meaning, distance=float(abs(score)), side=_side(score))
    for source, mostly in SOURCE_FINDINGS.items():
        rows = summary.index[(summary[source] > _MAIN_SOURCE_SHARE) & (summary["contraction"] >= _MIN_CONTRACTION)]
        if len(rows):
            clauses = [f"{name} ({100 * np.round(summary.loc[name, source], 2):.0f} %)" for name in rows]
            yield mostly(names=_listed(clauses))


def zero_unseen(recording: Recording, sd: float) -> list[Finding]:
    """Return what the zero of an averaged cycle is taken for; nothing where its beats were looked at for drift."""
    if recording.pressure_error is not None:
        return []
    return [ZERO_UNSEEN(within=2 * sd, percent=100 / (recording.mean_pressure - recording.wedge_pressure))]


def trust(diagnostics: Diagnostics) -> Iterator[Finding]:
    """Yield why the draws should not be believed."""
    if not trusted(diagnostics.k_hat, diagnostics.even):
        yield HEAVY_TAIL(k_hat=float(diagnostics.k_hat), limit=MAX_PARETO_K)
    if diagnostics.effective < MIN_EFFECTIVE_DRAWS:
        yield FEW_DRAWS(effective=float(diagnostics.effective))


def _side(score: float) -> str:
    return "above" if score > 0 else "below"


def _listed(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
