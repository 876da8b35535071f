"""What fits of the wall laws came to, animal by animal: how well they meet the data, and which the residuals prefer."""

from collections.abc import Hashable, Iterable, Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.base.descriptions import MOST_LEFT, TAILS
from vasowave.study.animal.result import AnimalResult

MAX_RESIDUAL_RATIO = 2.0
"""A law that leaves more than this times the residual of the animal's best law misses its data; a law whose vessels are
strained beyond what an artery survives is no best law."""

MIN_WEIGHED = 3
"""Animals below which walls are not weighed where others must be left out for a fit that must not be used."""

UNDECIDED_VOTE, DISCARDED_VOTE = "undecided", "discarded"
CRITERIA = ("AICc", "BIC")
DECISIVE_AICC_DIFFERENCE = 5.0
"""Difference of AICc, over all animals together, below which nothing is decided; the verdicts on one animal use it."""

_COLUMNS = ["animal", "group", "wall", "RMSE", "error", "share", "over best", "missed", "growth"]


def misfits(results: Iterable[AnimalResult]) -> pd.DataFrame:
    """Return one row for every animal and wall law: what its fit leaves, and whether it misses the data.

    Columns ``animal, group, wall, RMSE, error, share, over best, missed, growth``: the root-mean-square residual, mmHg;
    the standard error of the averaged cycle, mmHg (NaN if a cycle was given); the residual over the pulse pressure and
    over that of the animal's best law (NaN if there is none); whether it exceeds `MAX_RESIDUAL_RATIO` or `MOST_LEFT`,
    and the error of the cycle; how much a vessel's area grows beyond what an artery survives, % (NaN if none does).
    """
    rows = []
    for result in results:
        rmse_by_wall = {wall: float(result.laws[wall].calibration["RMSE"]) for wall in result.laws}
        pulse, error = float(result.measured.quantities["pPAP"]), _cycle_error(result)
        strained = {wall: overstrain for wall, law in result.laws.items() if (overstrain := law.overstrained)}
        best = min((rmse_by_wall[wall] for wall in rmse_by_wall if wall not in strained), default=np.nan)
        for wall, rmse in rmse_by_wall.items():
            share, over = rmse / pulse, rmse / best
            missed = (over > MAX_RESIDUAL_RATIO or share > MOST_LEFT) and not rmse < error
            growth = float(dict(strained[wall].values)["percent"]) if wall in strained else np.nan
            rows.append((result.name, result.group, wall, rmse, error, share, over, missed, growth))
    return pd.DataFrame(rows, columns=_COLUMNS)


def unusable_walls(misfits: pd.DataFrame) -> dict[str, frozenset[str]]:
    """Return by animal the laws whose fit must not be weighed against another: of `misfits`, those that overstrain.

    A law that misses the data is spoken against by them, and that counts, unless every law of the animal misses them.
    """
    unusable: dict[str, frozenset[str]] = {}
    for name, rows in misfits.groupby("animal", sort=False):
        strained = rows["growth"].notna()
        useless = strained | rows["missed"] if (strained | rows["missed"]).all() else strained
        unusable[str(name)] = frozenset(rows["wall"][useless])
    return unusable


def enough(weighed: int, left_out: int) -> bool:
    """Whether so many animals may speak for all: none is left out, or three at least and half of them remain."""
    return not left_out or weighed >= max(MIN_WEIGHED, left_out)


def is_lone(calibration: xr.Dataset) -> bool:
    """Whether only one of several starts reached the best optimum."""
    return bool(calibration.sizes["start"] > 2 and int(calibration["start_agrees"].sum()) == 1)


def _cycle_error(result: AnimalResult) -> float:
    """Return the standard error of the averaged pressure from the scatter of its beats, mmHg."""
    recording = result.recording
    if "pressure_sd" not in recording.data_vars or result.beats is None:
        return np.nan
    beats = int(result.beats["kept"].sum())
    return float(np.sqrt((recording["pressure_sd"] ** 2).mean() / max(beats, 1)))


def ballots(selection: xr.Dataset) -> pd.DataFrame:
    """Return one row per noise model of one animal, in the order stored, discarded ones last.

    Columns: ``covariance``; ``CRITERION LAW`` and ``CRITERION prefers`` (a law, "undecided" where
    the runner-up is too close, or "discarded"); ``λ``, ``N``, and ``D LAW``.
    """
    candidates = selection.to_dataframe().reset_index(drop=True)
    rows = []
    for covariance, laws in candidates.groupby("covariance", sort=False):
        by_law = laws.set_index("wall")
        row: dict[Hashable, object] = {"covariance": covariance}
        for criterion in CRITERIA:
            row |= {f"{criterion} {wall}": float(score) for wall, score in by_law[criterion].items()}
            row[f"{criterion} prefers"] = _preferred(by_law, criterion)
        row |= {"λ": float(by_law["lambda"].max()), "N": int(by_law["N"].iloc[0])}
        rows.append(row | {f"D {wall}": int(count) for wall, count in by_law["D"].items()})
    table = pd.DataFrame(rows)
    return table.iloc[(table["AICc prefers"] == DISCARDED_VOTE).argsort(kind="stable")]


class Ballots(NamedTuple):
    """The `ballots` of one recording, the noise model that is likeliest for it, whose it is where that is known, and
    the laws whose fit must not be weighed (`unusable_walls`).
    """

    table: pd.DataFrame
    likeliest: str
    animal: str = ""
    unusable: frozenset[str] = frozenset()


def stored(selection: xr.Dataset, animal: str = "", unusable: frozenset[str] = frozenset()) -> Ballots:
    """Return what the comparison of one recording came to."""
    table = ballots(selection)
    likeliest = str(selection.attrs.get("preferred_covariance", table["covariance"].iloc[0]))
    return Ballots(table, likeliest, animal, unusable)


def differences(animals: Sequence[Ballots], reference: str, covariance: str = "") -> pd.DataFrame:
    """Return by how much AICc of every other wall law exceeds that of `reference`, pooled over animals.

    Of each recording counts the noise model that is likeliest for it, or the one named; of several recordings of one
    animal, their mean. Recordings of which the fit of either law must not be used are left out.

    Returns
    -------
    DataFrame
        One row per law: ``wall, n, left out, mean, low, high, sum, price, residuals, residuals low, residuals high,
        residuals SD, speaks for``. ``mean`` is the criterion of the law minus that of the reference, by animal; ``low,
        high`` are the ends of its 95 % interval (Student) from the scatter of the animals. It is the sum of ``price``,
        what the number of parameters costs whatever the data say, and of ``residuals``, minus twice the difference of
        the log-likelihoods. Positive numbers speak for the reference. ``speaks for`` is the law that both the whole and
        the residuals' own part prefer: over all animals by `DECISIVE_AICC_DIFFERENCE` at least and, of several animals,
        beyond their scatter; empty where there is none, or where `left out` animals leave too few (`enough`).
    """
    by_wall: dict[str, dict[Hashable, list[tuple[float, float]]]] = {}
    for place, animal in enumerate(animals):
        scores = _under(animal, covariance or animal.likeliest)
        labels = [label for label in scores.index if label.startswith("AICc ") and label != "AICc prefers"]
        by_law = {label.removeprefix("AICc "): float(scores[label]) for label in labels}
        if reference in by_law and scores["AICc prefers"] != DISCARDED_VOTE:
            prices = {wall: _price(int(scores[f"D {wall}"]), int(scores["N"])) for wall in by_law}
            for wall in (law for law in by_law if law != reference):
                difference = by_law[wall] - by_law[reference]
                animal_scores = by_wall.setdefault(wall, {}).setdefault(animal.animal or place, [])
                if not {wall, reference} & animal.unusable:
                    animal_scores.append((difference, prices[wall] - prices[reference]))
    return pd.DataFrame([_difference(wall, reference, [*by_animal.values()]) for wall, by_animal in by_wall.items()])


def _difference(wall: str, reference: str, scores: Sequence[list[tuple[float, float]]]) -> dict[str, object]:
    """Return the row of a law from the differences and prices of every animal's recordings that may be weighed."""
    means = np.array([np.mean(of_animal, axis=0) for of_animal in scores if of_animal]).reshape(-1, 2)
    (total, price), left_out = means.T, len(scores) - len(means)
    residuals, side = total - price, _side(total) if enough(len(means), left_out) else 0
    columns = ("mean", "low", "high"), ("residuals", "residuals low", "residuals high")
    intervals = {label: end for names, values in zip(columns, (total, residuals), strict=True)
                 for label, end in zip(names, _mean_and_interval(values), strict=True)}  # fmt: skip
    return {"wall": wall, "n": len(total), "left out": left_out, "sum": float(total.sum()),
            "price": _mean_and_interval(price)[0]} | intervals | {
        "residuals SD": float(residuals.std(ddof=1)) if len(residuals) > 1 else np.nan,
        "speaks for": (reference if side > 0 else wall) if side and side == _side(residuals) else "",
    }  # fmt: skip


def _side(values: np.ndarray) -> int:
    """Return the sign of what animals say together, 0 where it is small or within their scatter."""
    mean, low, high = _mean_and_interval(values)
    return 0 if abs(values.sum()) < DECISIVE_AICC_DIFFERENCE or low <= 0 <= high else int(np.sign(mean))


def _price(parameters: int, samples: int) -> float:
    """Return what AICc adds for its parameters (eq. 21)."""
    return 2 * parameters + 2 * parameters * (parameters + 1) / (samples - parameters - 1)


def _mean_and_interval(values: np.ndarray) -> tuple[float, float, float]:
    from scipy.special import stdtrit

    n = len(values)
    mean = float(values.mean()) if n else np.nan
    if n < 2:
        return mean, np.nan, np.nan
    reach = float(stdtrit(n - 1, TAILS[-1]) * values.std(ddof=1) / np.sqrt(n))
    return mean, mean - reach, mean + reach


def _under(animal: Ballots, covariance: str) -> pd.Series:
    """Return the row of a noise model; it says "discarded" if there is none."""
    table = animal.table[animal.table["covariance"] == covariance]
    return (
        table.iloc[0] if len(table) else pd.Series({f"{criterion} prefers": DISCARDED_VOTE for criterion in CRITERIA})
    )


def _preferred(by_law: pd.DataFrame, criterion: str) -> str:
    if by_law["discarded"].astype(bool).any():
        return DISCARDED_VOTE
    verdicts = by_law[f"{criterion}_verdict"]
    return next((str(wall) for wall, verdict in verdicts.items() if verdict == "preferred"), UNDECIDED_VOTE)
