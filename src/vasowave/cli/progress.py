"""Progress of long work on the terminal."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn


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
