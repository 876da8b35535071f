"""The change of each group by itself, as a table: what a treatment did to the treated, and time to the controls."""

from vasowave.study.cohort.effects import DesignEstimate, grouped
from vasowave.study.cohort.primary import Primary
from vasowave.study.figures.matplotlib_style import short
from vasowave.study.report.answer.effects import Called, EffectVerdict, plain, standing
from vasowave.study.report.blocks import Table
from vasowave.study.report.wording import listed, ratio_with_interval

_NOTE = (
    "Ratios of geometric means [95 %] by the model of the design, each interval for itself and without a p: whether "
    "groups changed unlike, the answer says."
)


def change_table(primary: Primary, called: Called) -> list[Table]:
    """Return the change of each group in the quantities of which any is shown; none where no changes are compared."""
    rows, changeless = [], []
    shown = {effect.quantity for effect in primary.effects
             if effect.contrast.kind == "interaction" and standing(effect) is EffectVerdict.SHOWN}  # fmt: skip
    for quantity, of_quantity in grouped(primary.changes, lambda change: change.quantity).items():
        if quantity in shown or any(not change.low <= 1 <= change.high for change in of_quantity):
            rows.append((plain(quantity, called), _cells(of_quantity)))
        else:
            changeless.append(plain(quantity, called))
    titles = dict.fromkeys(title for _, cells in rows for title in cells)
    if not rows:
        return []
    none = f" No interval leaves out 1 for {listed(changeless)}." if changeless else ""
    texts = [(name, *(cells.get(title, "–") for title in titles)) for name, cells in rows]
    return [Table("", "How each group changed", ("quantity", *titles), texts, _NOTE + none)]


def _cells(changes: list[DesignEstimate]) -> dict[str, str]:
    """Return the ratios by group and occasions."""
    return {
        f"{short(change.contrast.group)}, {short(change.contrast.change)}": ratio_with_interval(
            change.ratio, change.low, change.high
        )
        for change in changes
    }
