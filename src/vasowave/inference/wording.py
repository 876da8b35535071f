"""What a posterior means, in sentences a physiologist acts on."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from vasowave.findings import Finding
from vasowave.inference.result import Diagnostics
from vasowave.inference.reweighting import UNTRUSTED, trusted
from vasowave.inference.unknowns import Unknown
from vasowave.recording import Recording

FEWEST_EFFECTIVE = 100.0
"""Effective draws below which the ends of a 95 % interval rest on two draws each."""

_SILENT = 0.1  # contraction below which the data count as saying nothing
_FAR = 2.0  # SD of the prior between its median and the posterior's, from which they disagree
_MAINLY = 0.5  # share of the variance from one source that is worth a sentence
_WIDEST = 4.0  # ratio of the ends of an interval beyond which a number is not determined


def sentences(
    summary: pd.DataFrame,
    scores: pd.Series,
    unknowns: dict[str, Unknown],
    diagnostics: Diagnostics,
    found: Sequence[Finding],
    zero: str,
) -> tuple[str, ...]:
    """Say what a reader must know; `scores` are the medians of the unknowns in SD of their priors, `zero` as said."""
    return (
        *_trust(diagnostics),
        *map(str, found),
        *_silent(summary, unknowns),
        *_wide(summary, unknowns),
        *_conflicts(scores, unknowns),
        *_sources(summary),
        *([zero] if zero else []),
    )


def zero_unseen(recording: Recording, sd: float) -> str:
    """Say what the zero of an averaged cycle is taken for; nothing of a cycle whose beats were looked at for drift."""
    if recording.pressure_error is not None:
        return ""
    return (
        f"An averaged cycle does not show whether the pressure's zero drifted: it is taken to be right within "
        f"{2 * sd:.2g} mmHg (two SD, `zero_sd`). Every mmHg that it is off moves R_T by "
        f"{100 / recording.mean_pressure:.0f} %."
    )


def _trust(diagnostics: Diagnostics) -> list[str]:
    said = []
    if not trusted(diagnostics.k_hat, diagnostics.effective / diagnostics.draws):
        said.append(
            "Do not believe these numbers: the weights of the draws have a heavy tail (Pareto k "
            f"{diagnostics.k_hat:.2f}, above {UNTRUSTED}). Ask for more draws, start from another fit, or give "
            "narrower priors."
        )
    if diagnostics.effective < FEWEST_EFFECTIVE:
        said.append(
            f"The draws are worth {diagnostics.effective:.0f} independent ones: medians hold, the ends of intervals "
            "are rough. Ask for more draws."
        )
    return said


def _silent(summary: pd.DataFrame, unknowns: dict[str, Unknown]) -> list[str]:
    names = list(summary.index[(summary["contraction"] < _SILENT) & summary.index.isin(list(unknowns))])
    if not names:
        return []
    return [
        f"The recording says nothing about {_listed(names)}: posterior and prior are the same, and the interval is "
        "that of the assumption."
    ]


def _wide(summary: pd.DataFrame, unknowns: dict[str, Unknown]) -> list[str]:
    silent = (summary["contraction"] < _SILENT) & summary.index.isin(list(unknowns))
    loose = summary[
        (summary["prior_low"] > 0) & (summary["interval_high"] > _WIDEST * summary["interval_low"]) & ~silent
    ]
    return [
        f"{name} is known only within a factor of {row['interval_high'] / row['interval_low']:.1f} "
        f"({row['interval_low']:.3g} to {row['interval_high']:.3g})."
        for name, row in loose.iterrows()
    ]


def _conflicts(scores: pd.Series, unknowns: dict[str, Unknown]) -> list[str]:
    return [
        f"Recording and assumption disagree about {name} ({unknowns[str(name)].meaning}): the median lies "
        f"{abs(score):.1f} SD of the prior {'above' if score > 0 else 'below'} its center. Either the assumption or "
        "the model is wrong for this animal."
        for name, score in scores.items()
        if abs(score) > _FAR
    ]


_REMEDIES = {
    "image": "a better image would narrow it, more beats would not",
    "model": "it is what the model leaves out, and neither a better image nor more beats would narrow it",
    "recording": "a better recording would narrow it",
}


def _sources(summary: pd.DataFrame) -> list[str]:
    said = []
    for source, remedy in _REMEDIES.items():
        rows = summary.index[(summary[source] > _MAINLY) & (summary["contraction"] >= _SILENT)]
        parts = [f"{name} ({100 * np.round(summary.loc[name, source], 2):.0f} %)" for name in rows]
        if parts:
            said.append(f"Mostly from the {source} comes the uncertainty of {_listed(parts)}: {remedy}.")
    return said


def _listed(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
