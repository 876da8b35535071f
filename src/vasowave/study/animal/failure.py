"""Failures of an animal: as a whole, with one wall law, or in a part of what was asked of that law."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any, TypeVar

from vasowave.base.errors import VasowaveError
from vasowave.base.runtime.interrupts import is_interrupt
from vasowave.base.runtime.memory import is_starved

_MAX_ERROR_LETTERS = 300  # letters of what a foreign error says; a compiler's goes on for pages

T = TypeVar("T")


class Stage(StrEnum):
    """The stages at which something can fail."""

    READING = "reading"
    FIT = "fit"
    ANALYSIS = "analysis"
    POSTERIOR = "posterior"
    COMPARISON = "comparison"
    COMPUTING = "computing"


@dataclass(frozen=True)
class Failure:
    """One thing that failed.

    Attributes
    ----------
    animal, group : str
    law : str
        The wall law; empty where it is of no single one.
    stage : Stage
        ``reading`` of its files and ``computing`` (what follows without a model cannot be, or the program ended) lose
        the animal; ``fit`` and ``analysis`` of it lose a law; without a ``posterior`` or a ``comparison`` of the laws
        all else is there.
    reason : str
    mean_pressure : float or None
        Measured mPAP, mmHg, where a recording could be read: the animal is lost, what was measured is not.
    """

    animal: str
    group: str
    law: str
    stage: Stage
    reason: str
    mean_pressure: float | None = None

    @property
    def is_total(self) -> bool:
        """Whether the animal has no result at all."""
        return self.stage in (Stage.READING, Stage.COMPUTING)

    @property
    def scope(self) -> str:
        """The part that failed: ``tangent wall, fit``."""
        return f"{self.law} wall, {self.stage}" if self.law else str(self.stage)

    def __str__(self) -> str:
        """Return what failed, and why."""
        return f"{self.scope}: {self.reason}"


def as_plain(failures: Iterable[Failure]) -> list[dict[str, Any]]:
    """Return failures as JSON can hold them."""
    return [asdict(failure) for failure in failures]


def from_plain(entries: Iterable[Mapping[str, Any]]) -> tuple[Failure, ...]:
    """Return the failures that `as_plain` wrote; raises `ValueError` or `TypeError` for anything else."""
    return tuple(Failure(**{**entry, "stage": Stage(entry["stage"])}) for entry in entries)


def attempted(work: Callable[[], T], failed: Callable[[str], None]) -> T | None:
    """Return what `work` returns; where it fails, tell `failed` why, and return nothing.

    A disk that is full, a lack of memory and Ctrl-C are not of the animal, and end the work.
    """
    try:
        return work()
    except Exception as error:
        if is_starved(error) or _is_of_a_disk(error) or is_interrupt(error):
            raise
        failed(str(error) if isinstance(error, VasowaveError) else unforeseen(error))
        return None


def _is_of_a_disk(error: BaseException | None) -> bool:
    return error is not None and (isinstance(error, OSError) or _is_of_a_disk(error.__cause__ or error.__context__))


def unforeseen(error: BaseException, where: str = "") -> str:
    """Return what is said of an error that nobody foresaw, and where it came from."""
    frame = error.__traceback__
    while frame is not None and frame.tb_next is not None:
        frame = frame.tb_next
    if not where and frame is not None:
        where = f'File "{frame.tb_frame.f_code.co_filename}", line {frame.tb_lineno}'
    first_line = next(iter(str(error).splitlines()), "")[:_MAX_ERROR_LETTERS]
    return f"unexpected {type(error).__name__}: {first_line} ({where or 'unknown'}); please report it"
