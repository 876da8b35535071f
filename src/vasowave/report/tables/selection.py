"""The wall law that the residuals prefer, for every animal ("AICcBIC") and pooled; how well the laws meet the data."""

import pandas as pd

from vasowave.cohort.cohort import Cohort
from vasowave.cohort.evidence import evidences
from vasowave.cohort.misfit import WORSE_THAN_BEST, WORST_SHARE
from vasowave.cohort.votes import DECISIVE, differences
from vasowave.report.blocks import Table
from vasowave.report.tables.cells import who
from vasowave.report.wording import number, with_interval

_NOTE = (
    "λ: weight of the regularization; noise models that need more than allowed are discarded and stand last. D: fitted "
    "parameters of each law, N: pressure samples."
)


def selection_table(cohort: Cohort) -> Table:
    """AICc and BIC of the wall laws under every noise model, for every animal, likeliest noise model first."""
    pairs = zip(cohort.ballots, cohort.compared, strict=True)
    parts = [one.table.assign(**who(result)) for one, result in pairs]  # type: ignore[arg-type]
    data = pd.concat(parts, ignore_index=True)
    data = data[["animal", "group", *(label for label in data.columns if label not in ("animal", "group"))]]
    selection = cohort.compared[0].selection
    verdict = selection["AICc_verdict"].attrs.get("long_name", "") if selection is not None else ""
    note = f"Prefers: {verdict}. {_NOTE}" if verdict else _NOTE
    return Table.of("AICcBIC", "AICc and BIC of the wall laws; the lower score is better", data, note)


def preference_table(cohort: Cohort, law: str) -> Table:
    """The difference of every other law from `law`, pooled over animals, by noise model."""
    parts = [differences(cohort.ballots, law).assign(noise="likeliest of each animal")]
    for covariance in dict.fromkeys(name for one in cohort.ballots for name in one.table["covariance"]):
        parts.append(differences(cohort.ballots, law, covariance=str(covariance)).assign(noise=str(covariance)))
    data = pd.concat([part for part in parts if len(part)] or parts[:1], ignore_index=True)

    def size(row: pd.Series, name: str, low: str, high: str) -> str:
        return with_interval(float(row[name]), float(row[low]), float(row[high]))

    cells = [
        (str(row["wall"]), str(row["noise"]), str(row["n"]), size(row, "mean", "low", "high"), number(row["price"], 2),
         size(row, "residuals", "residuals low", "residuals high"), number(row["residuals SD"], 2),
         str(row["speaks for"]) or "open")
        for _, row in data.iterrows()
    ]  # fmt: skip
    header = ("wall", "noise model", "animals", f"AICc minus that of the {law} wall, per animal [95 %]",
              "fixed price of parameters", "residuals' own part [95 %]", "SD over animals", "speaks for")  # fmt: skip
    note = (
        f"Positive numbers speak for the {law} wall. AICc is the price of a law's parameters, whatever the data say, "
        "and the residuals' own part, minus twice the log-likelihood. Intervals are Student's, from the scatter of the "
        "animals. A law is named where the whole and the residuals' own part "
        f"both speak for it, beyond that scatter and by {DECISIVE:g} over all animals. What the noise model changes, "
        "the data have not decided."
    )
    if evidences(cohort, law):
        note += " Which wall is answered by the evidences of posteriors; AICc, beside them, takes the image as exact."
    return Table("Preference", "Wall laws compared over all animals", header, cells, note, data)


def misfit_table(cohort: Cohort) -> Table:
    """The residual of every law, beside the error of the averaged cycle."""
    data = cohort.misfits
    cells = [
        (row["animal"], row["group"], row["wall"], number(row["RMSE"], 2), number(row["error"], 2),
         f"{100 * row['share']:.1f} %", number(row["over best"], 2),
         "overstrained" if row["growth"] > 0 else "misses" if row["missed"] else "")
        for _, row in data.iterrows()
    ]  # fmt: skip
    header = (
        "animal",
        "group",
        "wall",
        "RMSE [mmHg]",
        "error of the cycle [mmHg]",
        "of the pulse",
        "over the best law",
        "",
    )
    note = (
        "Error of the cycle: standard error of the averaged beats (– if a cycle was given). A law misses its data "
        "where it "
        f"leaves more than {WORSE_THAN_BEST:g} times what the animal's best law leaves, or more than "
        f"{100 * WORST_SHARE:g} % of the pulse pressure. Overstrained: a vessel's area grows beyond what an artery "
        "survives; such a law is never the best."
    )
    return Table("Misfit", "What the wall laws leave of the data", header, cells, note, data)
