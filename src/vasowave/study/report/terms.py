"""The meanings of symbols: in a few words where they are spoken of, in full where a reader asks."""

import re
from collections.abc import Callable, Mapping

from vasowave.pulse.quantities import QUANTITIES
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.report.blocks import Table
from vasowave.study.report.wording import symbols

_OWN = {
    "S": "least-squares objective, the sum of squared residuals (eq. 14)",
    "η": "importance index: relative change of a group's mean (eq. 20)",
    "AICc": "Akaike's information criterion, corrected for small samples; lower is better (eq. 21)",
    "BIC": "Bayesian information criterion; lower is better (eq. 22)",
    "τ": "time constant of the diastolic decay, measured (eq. 12)",
    "CO": "cardiac output, mean flow; 1 ml/s is 60 ml/min",
    "IQR": "from the first to the third quartile",
    "RMSE": "root-mean-square residual of the pressure; where flow is compared, its pulse counts as the pressure's",
}


def words(name: str, meanings: Mapping[str, str]) -> str:
    """Return a quantity in a few words; `meanings` are those as stored."""
    quantity = QUANTITIES.get(name)
    return (quantity and (quantity.words or quantity.meaning)) or meanings.get(name, name).split(",")[0]


def symbol(name: str, written: Mapping[str, str]) -> str:
    """Return the symbol of a quantity, without what defines it."""
    return written.get(name, name).split(" = ")[0]


def caller(cohort: Cohort) -> Callable[[str], str]:
    """Return what gives a quantity in words with its symbol, as the animals' results have them."""
    meanings, written = cohort.meanings, symbols(cohort)

    def called(name: str) -> str:
        phrase, sign = words(name, meanings), symbol(name, written)
        return phrase if phrase == sign else f"{phrase} {sign}"

    return called


def defined(cohort: Cohort) -> dict[str, str]:
    """Return the symbol of every quantity with its meaning, ``r₁ (factor of the nominal R_1 of all beds)``."""
    stored_meanings, written = cohort.meanings, symbols(cohort)
    meanings = {name: words(name, stored_meanings) for name in written}
    return {
        name: sign if meanings[name] in (name, sign) else f"{sign} ({meanings[name]})" for name, sign in written.items()
    }


def glossary(cohort: Cohort) -> dict[str, str]:
    """Return the meaning of every symbol of the animals."""
    written, meanings = symbols(cohort), cohort.meanings
    return {symbol(name, written): meaning for name, meaning in meanings.items()} | _OWN


def glossary_table(entries: Mapping[str, str]) -> Table:
    """Return the glossary as a table."""
    return Table("", "What the symbols mean", ("symbol", "meaning"), list(entries.items()))


def explained(entries: Mapping[str, str]) -> Callable[[str], str]:
    """Return a function that marks the symbols of a text as HTML, each with its meaning.

    In running text only what cannot be a word: symbols of two signs or more, and Greek letters.
    """
    from markupsafe import Markup, escape

    safe = [entry for entry in entries if len(entry) > 1 or not entry.isascii()]
    longest = sorted(map(re.escape, safe), key=len, reverse=True)
    pattern = re.compile(rf"(?<![\w/])({'|'.join(longest)})(?![\w/(₀-₉])") if longest else None

    def abbreviated(sign: str) -> Markup:
        return Markup(f'<abbr tabindex="0" title="{escape(entries[sign])}">{escape(sign)}</abbr>')

    def marked(text: str) -> str:
        text = text.replace("× ", "×\N{NO-BREAK SPACE}")
        # A table's first column and its header may hold single letters: they are whole cells.
        match = re.fullmatch(r"(\S+)( = \S+)?( \[.*\])?", text)
        if match and match[1] in entries:
            return abbreviated(match[1]) + escape(text[len(match[1]) :])
        pieces = pattern.split(text) if pattern else [text]  # every second one is a symbol
        return Markup("").join(abbreviated(piece) if place % 2 else escape(piece) for place, piece in enumerate(pieces))

    return marked
