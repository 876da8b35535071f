"""What is shown on the terminal of work that is to be done, and of long work while it is done."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

if TYPE_CHECKING:
    from vasowave.study.overview import AnimalRead
    from vasowave.study.settings import StudyFile


def show_read(read: "Sequence[AnimalRead]", settings: "StudyFile") -> None:
    """Print what was read of every animal, and how much there is to compute."""
    from rich.box import SIMPLE_HEAD
    from rich.console import Console
    from rich.table import Table

    from vasowave.law_files import plain
    from vasowave.study.overview import HEADER, expected_seconds
    from vasowave.threads import cores

    table = Table(box=SIMPLE_HEAD)
    for i, title in enumerate(HEADER):
        table.add_column(title.replace("[", r"\["), justify="left" if i in (0, 1, 3) else "right", overflow="fold")
    for one in read:
        table.add_row(*one.row())
    Console().print(table)
    minutes = expected_seconds(read, settings, cores()) / 60
    walls, starts = settings.calibration.walls, settings.calibration.starts
    print(
        f"Animals {len(read)}; wall laws {', '.join(map(plain, walls))}; {starts} starts of each fit: roughly "
        f"{max(1, round(minutes))} min to compute here ({cores()} cores), less where results are kept."
    )


@contextmanager
def counting() -> Iterator[Callable[[str, int, int, float], None]]:
    """Show a bar for every wall law; gives what takes the law, its finished starts, all its starts, and the best S."""
    columns = (
        TextColumn("{task.description}"),
        BarColumn(bar_width=20),
        MofNCompleteColumn(),
        TextColumn("{task.fields[remark]}"),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
    )
    with Progress(*columns) as progress:
        tasks: dict[str, int] = {}

        def show(wall: str, done: int, count: int, best: float) -> None:
            if wall not in tasks:
                tasks[wall] = progress.add_task(f"{wall} wall, starts", total=count, remark="")
            progress.update(tasks[wall], completed=done, remark=f"best S {best:.4g} mmHg²")  # type: ignore[arg-type]

        yield show
