"""Which wall law each noise model prefers, for every animal ("AICcBIC")."""

import pandas as pd
import xarray as xr

from vasowave.animal.reading import data_of
from vasowave.figures.cohort_gallery import Cohort
from vasowave.report.cohort.cells import who
from vasowave.report.document import Table
from vasowave.selection.criteria import UNDECIDED

_NOISE = ("covariance", "sharing", "optimum")
_NOTE = (
    f"Differences below {UNDECIDED:g} decide nothing. λ: weight of the regularization; noise models that need more "
    "than allowed are discarded and stand last. D: fitted parameters of each law, N: pressure samples."
)


def selection_table(cohort: Cohort) -> Table:
    """AICc and BIC of both wall laws under every noise model, for every animal, likeliest noise model first."""
    data = pd.concat([_candidates(tree) for tree in cohort.trees if "selection" in tree.children], ignore_index=True)
    return Table.of("AICcBIC", "AICc and BIC of the wall laws; the lower score is better", data, _NOTE)


def _candidates(tree: xr.DataTree) -> pd.DataFrame:
    """Return one row per noise model, in the order of the tree, discarded ones last."""
    frame = data_of(tree, "selection").to_dataframe().reset_index(drop=True)
    keys = [key for key in _NOISE if key in frame.columns]
    rows = []
    for which, part in frame.groupby(keys, sort=False):
        scores, discarded = part.set_index("wall"), bool(part["discarded"].astype(bool).any())
        row: dict[str, object] = who(tree) | dict(zip(keys, which, strict=True))
        for criterion in ("AICc", "BIC"):
            row |= {f"{criterion} {wall}": float(scores.loc[wall, criterion]) for wall in scores.index}
            gap = float(scores[criterion].max() - scores[criterion].min())
            best = str(scores[criterion].idxmin()) if gap >= UNDECIDED else "undecided"
            row[f"{criterion} prefers"] = "discarded" if discarded else best
        row |= {"λ": float(scores["lambda"].max()), "N": int(scores["N"].iloc[0])}
        rows.append(row | {f"D {wall}": int(scores.loc[wall, "D"]) for wall in scores.index})
    found = pd.DataFrame(rows)
    return found.iloc[(found["AICc prefers"] == "discarded").argsort(kind="stable")]
