"""Which wall law each noise model prefers, for every animal ("AICcBIC")."""

import pandas as pd

from vasowave.animal.reading import data_of
from vasowave.cohort.cohort import Cohort
from vasowave.cohort.votes import ballots
from vasowave.report.blocks import Table
from vasowave.report.tables.cells import who

_NOTE = (
    "λ: weight of the regularization; noise models that need more than allowed are discarded and stand last. D: fitted "
    "parameters of each law, N: pressure samples."
)


def selection_table(cohort: Cohort) -> Table:
    """AICc and BIC of the wall laws under every noise model, for every animal, likeliest noise model first."""
    parts = [ballots(tree).assign(**who(tree)) for tree in cohort.compared]  # type: ignore[arg-type]
    data = pd.concat(parts, ignore_index=True)
    data = data[["animal", "group", *(label for label in data.columns if label not in ("animal", "group"))]]
    verdict = data_of(cohort.compared[0], "selection")["AICc_verdict"].attrs.get("long_name", "")
    note = f"Prefers: {verdict}. {_NOTE}" if verdict else _NOTE
    return Table.of("AICcBIC", "AICc and BIC of the wall laws; the lower score is better", data, note)
