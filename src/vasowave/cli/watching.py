"""A run of a study as it goes on: rows with stages on a terminal, lines elsewhere, or JSON for programs."""

import json
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import Any, Protocol

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TaskID, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bars

from vasowave.base.errors import InputError
from vasowave.cli.progress import alive, time_left
from vasowave.study.folder.study import Study
from vasowave.study.results.loading import animal_key
from vasowave.study.running.engine import Progress
from vasowave.study.running.status import POSTERIOR, searches_of

_LOOK = 1.0  # s between looks into the journals
_WORDS = {"kept": "kept from earlier", "computed": "computed", "failed": "FAILED"}
_BEGIN = "reading files; what was never compiled here is compiled, a minute once"
Searches = Mapping[str, Mapping[str, tuple[int, int]]]


class Show(Protocol):
    """Progress events emitted during a run."""

    def step(self, step: Progress) -> None:
        """Tell that an animal is done."""
        ...

    def searches(self, under_way: Searches) -> None:
        """Tell how many searches of which animals have ended."""
        ...


@contextmanager
def watched(study: Study, as_json: bool) -> Iterator[Show]:
    """Give what takes the steps of a run, and tell meanwhile which searches of its animals end."""
    console = Console(stderr=True)
    with _bars(console, len(study.animals)) as bars:
        rows = ProgressRows(console, bars)
        show: Show = JsonLines() if as_json else rows
        ended = threading.Event()
        watcher = threading.Thread(target=_watch, args=(study, show, ended), daemon=True)
        watcher.start()
        try:
            with nullcontext() if as_json else alive(rows.doing):
                yield show
        finally:
            ended.set()
            watcher.join()


def event(event: str, /, **facts: Any) -> None:
    """Print one event of a run as a line of JSON."""
    typer.echo(json.dumps({"event": event, **facts}, ensure_ascii=False))


class JsonLines:
    """Every step as a line of JSON on the standard output.

    Holds state because a count is told only where it is more than what was told before.
    """

    def __init__(self) -> None:
        self.said: dict[tuple[str, str], int] = {}

    def step(self, step: Progress) -> None:
        """Tell that an animal is done."""
        seconds_left = None if step.left is None else round(step.left, 1)
        event("animal", animal=step.name, what=step.what, done=step.done, count=step.count, left_s=seconds_left,
              message=step.message)  # fmt: skip

    def searches(self, under_way: Searches) -> None:
        """Tell how many searches of which animals have ended, where that is more than before."""
        for animal, walls in under_way.items():
            for wall, (done, count) in walls.items():
                if self.said.get((animal, wall)) != done:
                    self.said[animal, wall] = done
                    if count:
                        event("searches", animal=animal, wall=wall, done=done, count=count)
                    else:
                        event("simulations", animal=animal, wall=wall.removesuffix(POSTERIOR), done=done)


class ProgressRows:
    """A bar for the study and a row for every animal that is being computed; lines where there is no terminal.

    Holds state because rows appear and go as animals begin and end.
    """

    def __init__(self, console: Console, bars: Bars) -> None:
        self.console: Console = console
        self.bars: Bars = bars
        self.rows: dict[str, TaskID] = {}
        self.finished: set[str] = set()
        self.stages: dict[str, str] = {}
        self.idle: str = _BEGIN

    def step(self, step: Progress) -> None:
        """Tell that an animal is done."""
        remaining = "" if step.left is None or step.done == step.count else time_left(step.left)
        self.finished.add(step.name)
        self.idle = "writing the results" if step.done == step.count else self.idle
        if step.name in self.rows:
            self.bars.remove_task(self.rows.pop(step.name))
        self.bars.update(self.bars.task_ids[0], completed=step.done, left=remaining)
        reason = f": {step.message}" if step.message else ""
        self.console.print(
            f"{step.done} of {step.count}: {step.name} {_WORDS[step.what]}{reason}"
            f"{f' ({remaining})' if remaining else ''}",
            markup=False, highlight=False, soft_wrap=True,
        )  # fmt: skip

    def searches(self, under_way: Searches) -> None:
        """Tell how many searches of which animals have ended."""
        stages = {name: _stage(walls) for name, walls in under_way.items() if name not in self.finished}
        for name, stage in stages.items():
            if name not in self.rows:
                self.rows[name] = self.bars.add_task(name, total=None, left="")
            done, count = (sum(search[i] for search in under_way[name].values() if search[1]) for i in (0, 1))
            self.bars.update(self.rows[name], completed=done, total=count, left=stage)
        if stages and not self.finished:
            self.bars.update(self.bars.task_ids[0], left="")
        self.stages = stages

    def doing(self) -> str:
        """Return what is under way, in words."""
        stages = {name: stage for name, stage in self.stages.items() if name not in self.finished}
        return "; ".join(f"{name}: {stage}" for name, stage in stages.items()) or self.idle


def _stage(walls: Mapping[str, tuple[int, int]]) -> str:
    wall, (done, count) = list(walls.items())[-1]
    if not count:
        return f"{wall}, {done} simulations"
    return f"{wall} wall, {done} of {count} searches" if done < count else f"{wall} wall fitted, going on"


def _watch(study: Study, show: Show, ended: threading.Event) -> None:
    try:
        keys = {row.animal: animal_key(row, study.settings, study.folder) for row in study.animals}
    except InputError:  # the run itself says which file it is
        return
    while not ended.wait(_LOOK):
        show.searches(searches_of(Path(study.results), keys))


def _bars(console: Console, count: int) -> Bars:
    columns = [TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()]
    bars = Bars(*columns, TextColumn("{task.fields[left]}"), console=console, disable=not console.is_terminal)
    bars.add_task("animals", total=count, left=_BEGIN)
    return bars
