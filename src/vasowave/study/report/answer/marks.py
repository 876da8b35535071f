"""Marks behind numbers that a reader must not take as they are: at a bound of the search, or of a law that misses."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from vasowave.base.descriptions import AT_BOUND, FORBIDDEN
from vasowave.pulse.quantities import described
from vasowave.study.animal.result import AnimalResult
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.cohort.effects import Effect
from vasowave.study.figures.matplotlib_style import short
from vasowave.study.report.wording import listed, some_of

Mark = Callable[[Effect], str]
"""Returns what stands behind the number of an effect."""

MAX_NAMES = 4  # animals named in a sentence


def unmarked(effect: Effect) -> str:
    """Return no mark."""
    return ""


@dataclass(frozen=True, eq=False)
class Marks:
    """What stands behind the numbers of a law of a cohort, and what that means."""

    cohort: Cohort
    law: str
    """The law whose numbers are shown; empty where nothing was fitted."""

    def of_effect(self, effect: Effect) -> str:
        """Return the marks of an effect: those of the animals on both of its sides."""
        if effect.source == "measured":
            return ""
        sides = {effect.contrast.reference, effect.contrast.group} & {*self.cohort.groups} or {*self.cohort.groups}
        return self.of_quantity(effect.quantity, [result for group in sides for result in self.cohort.groups[group]])

    def of_quantity(self, name: str, results: list[AnimalResult]) -> str:
        """Return the marks of a quantity of the law in some animals."""
        whose = {result.name for result in results}
        forbidden = whose & {result.name for result in self._forbidden}
        bound = any(result.name in whose and stopped_at(result, self.law, name) for result in self.cohort.results)
        return f"{FORBIDDEN if forbidden else ''}{AT_BOUND if bound else ''}"

    def legend(self, answers: Sequence[tuple[str, str]], written: Mapping[str, str]) -> list[tuple[str, str]]:
        """Say what the marks mean that stand in answers."""
        sentences, shown = [], " ".join(text for _, text in answers)
        if FORBIDDEN in shown and self._forbidden:
            whom = "this animal" if self.cohort.single else shortened([result.name for result in self._forbidden])
            sentences.append(
                f"{FORBIDDEN} rests on the {self.law} wall's numbers of {whom}, and these must not be used: "
                "see Problems."
            )
        if AT_BOUND in shown:
            count = Counter(
                name for result in self.cohort.calibrated(self.law) for name in stopped_at(result, self.law)
            )
            all_ = len(self.cohort.calibrated(self.law))
            bounds = [
                f"{written.get(n, n)}{'' if self.cohort.single else f' in {k} of {all_}'}" for n, k in count.items()
            ]
            sentences.append(
                f"{AT_BOUND} rests on a value at a bound of the search ({listed(bounds)}): it may lie beyond."
            )
        return [("What do marks mean?", " ".join(sentences))] if sentences else []

    @cached_property
    def _forbidden(self) -> list[AnimalResult]:
        return self.cohort.forbidden(self.law) if self.law else []


def stopped_at(result: AnimalResult, law: str, quantity: str = "") -> list[str]:
    """Return the parameters at a bound of the search on which a quantity rests; without one all of them."""
    if law not in result.laws or ((drawn := result.laws[law].posterior) is not None and drawn.trusted):
        return []
    fit, walls = result.laws[law].calibration, result.laws[law].parameters
    names = [str(name) for name in fit["parameter"].values[fit["at_bound"].values.astype(bool)]]
    rests_on = "wall" if quantity in walls else described(quantity).rests_on
    return [name for name in names if not rests_on or (name in walls) == (rests_on == "wall")]


def shortened(names: list[str]) -> str:
    """Return animals as a sentence names them: a few, each cut where it is long, and how many more there are."""
    return some_of([short(name, 40) for name in names], MAX_NAMES)
