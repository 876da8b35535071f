"""The difference of one group from another, as a value: the primary comparison, its table and its forest plot."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from vasowave.base.errors import InputError, did_you_mean
from vasowave.base.io.files import check_file, write_file
from vasowave.base.notebook import card
from vasowave.pulse.quantities import short_symbol
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.cohort.primary import Primary
from vasowave.study.cohort.table import column
from vasowave.study.figures.compared import means_figure
from vasowave.study.figures.forest import WIDE, Form, forest_figure
from vasowave.study.figures.matplotlib_style import group_looks, new_figure, short, shown_figure, source_looks, style
from vasowave.study.figures.overview import flow_loops_figure, impedances_figure, waveforms_figure
from vasowave.study.figures.rendering import as_file
from vasowave.study.report.answer.design import design_answer
from vasowave.study.report.answer.forest import group_rows
from vasowave.study.report.answer.groups import doubts_text, group_answer, not_told
from vasowave.study.report.answer.marks import Marks
from vasowave.study.report.terms import caller, defined
from vasowave.study.report.wording import column_label, probability, some_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

GROUP_FIGURES = {
    "ratios": "ratios with intervals",
    "points": "every animal and means",
    "waves": "pressure and flow of all animals",
    "loops": "pressure over flow of all animals",
    "impedance": "impedance",
}
"""Figures of groups, with what they show."""
_NAMED = 3  # quantities, in a sentence


@dataclass(frozen=True, eq=False)
class Comparison:
    """One group against another, by the primary comparison of a study.

    Attributes
    ----------
    group, reference : str
    cohort : Cohort
        All animals of the study: intervals and p hold for all its groups at once.
    primary : Primary
        The comparison; its `effects` are those of `group`.
    """

    group: str
    cohort: Cohort
    primary: Primary

    @property
    def reference(self) -> str:
        """The group that is compared with."""
        return self.cohort.reference

    @property
    def table(self) -> pd.DataFrame:
        """One row a quantity: ratio of the group over the reference, its interval, p and more; see `Primary.table`."""
        return self.primary.table()

    def forest(self) -> "Axes":
        """Draw ratios with their intervals, the other laws' and every animal below, as the report does.

        Returns the axes of the ratios; ``.figure`` is the whole.

        Raises
        ------
        InputError
            No quantity could be compared.
        """
        return next(ax for ax in self._figure(shown_figure).axes if ax.get_xscale() == "log")

    def save(self, path: str | Path, figure: str = "ratios") -> Path:
        """Write a figure of the groups, or the table of numbers: ``results.compare("HPH").save("hph.pdf")``.

        Parameters
        ----------
        path : path
            It ends in .svg, .pdf or .png; in .csv it is `table`.
        figure : str
            Of `GROUP_FIGURES`: ``ratios`` (the figure of `forest`, 174 mm wide), ``points`` (every animal and the means
            of groups with 95 % intervals), ``waves`` (measured pressure and flow of every animal, mean and SD of each
            group), ``loops`` (pressure over flow) or ``impedance`` (modulus and phase over Hz, mean and SD).

        Raises
        ------
        InputError
            No quantity could be compared, there is no such figure, or the file cannot be written.
        """
        check_file(Path(path), ".svg", ".pdf", ".png", ".csv")
        return write_file(Path(path), self.as_file(Path(path).suffix.lower()[1:], figure))

    def as_file(self, kind: str, figure: str = "ratios") -> bytes:
        """Return what `save` writes: svg, pdf, png or csv; raises as `save`."""
        if figure not in GROUP_FIGURES:
            raise InputError(f"there is no figure '{figure}'{did_you_mean(figure, GROUP_FIGURES)}")
        if kind == "csv":
            self._check_compared()
            return self.table.to_csv(index=False).encode()
        drawings = {"waves": waveforms_figure, "loops": flow_loops_figure, "impedance": impedances_figure,
                    "points": lambda cohort: self._points()}  # fmt: skip
        with style():
            drawn = drawings[figure](self.cohort) if figure in drawings else self._figure(new_figure)
            return as_file(drawn, kind)

    def _points(self) -> "Figure":
        """Draw every animal by the quantities that are compared, with p above the group."""
        self._check_compared()
        labels: dict[str, str] = {}
        above: dict[str, dict[str, str]] = {}
        sources = list(dict.fromkeys(effect.source for effect in self.primary.effects))
        looks = source_looks([*self.cohort.sources, "data"])
        for effect in self.primary.effects:
            label = column(self.cohort.table[self.cohort.table["source"] == effect.source], effect.quantity)
            labels[label] = column_label(label).replace(effect.quantity, short_symbol(effect.quantity), 1)
            if self.cohort.design.plain:
                p = "no p" if effect.untested else probability(effect.p)
                texts = above.setdefault(label, {})
                first = f"{texts[effect.contrast.group]}\n" if effect.contrast.group in texts else ""
                texts[effect.contrast.group] = f"{first}{looks[effect.source].short}: {p}"
        return means_figure(self.cohort, labels, sources, above)

    def _check_compared(self) -> None:
        """Raise `InputError` where no quantity could be compared."""
        if not self.primary.effects:
            omissions = not_told(self.primary, caller(self.cohort))
            omissions += [f"{omission.describe()} ({omission.reason})" for omission in self.primary.left_out]
            hint = " (all in `.primary.left_out`)" if len(omissions) > _NAMED else ""
            raise InputError(
                f"{self.group} and {self.reference} could not be compared by {some_of(omissions, _NAMED)}{hint}; "
                "add animals"
            )

    def _figure(self, make: Callable[[float, float], "Figure"]) -> "Figure":
        self._check_compared()
        return groups_figure(self.cohort, self.primary, WIDE, make)

    def __repr__(self) -> str:
        return "\n".join(f"{question}: {answer}" for question, answer in self._items) or "nothing could be compared"

    @property
    def _items(self) -> list[tuple[str, str]]:
        """Questions and answers, how the animals were compared, and what must not be used; empty without a row."""
        marks = Marks(self.cohort, self.primary.law)
        sure = doubts_text(self.cohort, self.primary)
        answers = group_answer(self.primary, caller(self.cohort), marks.of_effect).items(sure=sure)
        if not answers:
            return []
        counts = [f"{group} {len(self.cohort.groups[group])}" for group in (self.group, self.reference)]
        return [*answers, ("Recordings" if self.cohort.repeated else "Animals", ", ".join(counts)),
                *design_answer(self.cohort), *marks.legend(answers, defined(self.cohort))]  # fmt: skip

    def _repr_html_(self) -> str:
        facts = dict(self._items)
        omissions = [f"{omission.describe()}: {omission.reason}" for omission in self.primary.left_out]
        omissions += not_told(self.primary, caller(self.cohort))
        return card(f"{self.group} against {self.reference}", facts, omissions)


def groups_figure(
    cohort: Cohort, primary: Primary, form: Form, make: Callable[[float, float], "Figure"] = new_figure
) -> "Figure":
    """Draw the forest plot of a primary comparison that has rows."""
    rows = group_rows(cohort, primary, caller(cohort), Marks(cohort, primary.law).of_effect)
    looks, sources = group_looks(cohort.groups), source_looks([*cohort.sources, "data"])
    axis = f"ratio to {short(cohort.reference)} [1]" if cohort.design.plain else "ratio [1]"
    return forest_figure(rows, looks, sources, axis, ("ratio [95 %]", "p"), form, make)
