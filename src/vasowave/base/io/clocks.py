"""Times of day and dates as recorders write them into the rows of a table."""

import re
from collections.abc import Sequence

_TIME = (
    r"(?:(?P<days>\d{1,4}) days?,? )?"
    r"(?:(?P<hours>\d{1,3}):)?(?P<minutes>\d{1,5}):(?P<seconds>\d{1,2})(?:[.,:](?P<fraction>\d{1,9}))?"
    r"\s*(?P<half>[apAP]\.?[mM]\.?)?(?:\.(?P<late>\d{1,9}))?(?:Z|[+-]\d\d:?\d\d)?"
)
_DATE = (
    r"(?:\d{1,4}(?P<mark>[./-])\d{1,2}(?P=mark)\d{1,4}|\d{1,2}[ -][A-Za-z]{3,9}\.?[ -]\d{2,4}"
    r"|[A-Za-z]{3,9}\.? \d{1,2},? \d{4})"
)
_DATE_AFTER = _DATE.replace("mark", "mark_after")
_CLOCK = re.compile(rf"(?:(?P<date>{_DATE})(?:\s*-\s*|[ T,]\s*))?{_TIME}(?:\s+(?P<date_after>{_DATE_AFTER}))?")
_DAY = re.compile(_DATE)
_DURATION = re.compile(r"(?P<number>\d+(?:\.\d+)?(?:e-?\d+)?) (?P<unit>msec|ms|sec|s|min|hr)s?", re.IGNORECASE)
_SECONDS = {"msec": 1e-3, "ms": 1e-3, "sec": 1.0, "s": 1.0, "min": 60.0, "hr": 3600.0}
_DAY_S = 86400.0
_HALF_DAY_S = 43200.0


def bare(cell: str) -> str:
    """Return a cell without blanks and quotation marks around it, and without brackets around a time of day."""
    text = cell.strip().strip("'\"").strip()
    return text[1:-1].strip() if text[:1] == "[" and text[-1:] == "]" and ":" in text else text


def is_clock(cell: str) -> bool:
    """Whether a cell is a time of day (``1:02:03.004 PM``), perhaps with a date, or a duration (``0.004 sec``)."""
    return any(form.fullmatch(bare(cell)) for form in (_CLOCK, _DURATION))


def is_date(cell: str) -> bool:
    """Whether a cell is a date alone."""
    return _DAY.fullmatch(bare(cell)) is not None


def decimals(cells: Sequence[str]) -> int:
    """Return how many decimals the seconds of times of day have."""
    matches = [match for cell in cells if (match := _CLOCK.fullmatch(bare(cell)))]
    return max((len(match["fraction"] or match["late"] or "") for match in matches), default=0)


class Clock:
    """A column of times of day, and perhaps one of dates, read row by row as seconds since the first row.

    Parameters
    ----------
    column : int
    dates : int, optional
        Column of the dates. Only a change of them counts: nobody needs to know whether the day or the month is first.
    digits : int
        Decimals of the seconds; see `decimals`.

    Holds state because midnight is where the time of a row falls behind that of the row before.
    """

    def __init__(self, column: int, dates: int | None, digits: int) -> None:
        self.column: int = column
        self.dates: int | None = dates
        self.digits: int = digits
        self.start: float | None = None
        """Time of day of the first row, s."""
        self._last, self._days, self._date = 0.0, 0, ""

    def seconds(self, cells: Sequence[str]) -> str:
        """Return the seconds of a row since the first one, as a number is written; empty where there is no time."""
        cell = bare(cells[self.column]) if self.column < len(cells) else ""
        if duration := _DURATION.fullmatch(cell):
            time = float(duration["number"]) * _SECONDS[duration["unit"].lower()]
            self.start = time if self.start is None else self.start
            return f"{time - self.start:.9f}"
        match = _CLOCK.fullmatch(f"{cell} 0:00:00" if is_date(cell) else cell)  # a workbook's midnight is a date
        if match is None:
            return ""
        time = (
            60.0 * int(match["minutes"]) + int(match["seconds"]) + float(f"0.{match['fraction'] or match['late'] or 0}")
        )
        hours = int(match["hours"] or 0)
        if match["half"]:
            hours = hours % 12 + 12 * (match["half"][0] in "pP")
        time += 3600.0 * hours + _DAY_S * int(match["days"] or 0)
        date = (
            match["date"]
            or match["date_after"]
            or (bare(cells[self.dates]) if self.dates is not None and self.dates < len(cells) else "")
        )
        if self.start is None:
            self.start, self._date = time, date
        elif date != self._date or (not date and time < self._last - _HALF_DAY_S):
            self._days, self._date = self._days + 1, date
        self._last = time
        return f"{self._days * _DAY_S + time - self.start:.{self.digits}f}"
