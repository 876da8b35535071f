"""Commands on a study: demo, new, check, run, report."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vasowave.cli.app import FAILED, app
from vasowave.cli.progress import show_read

if TYPE_CHECKING:
    from vasowave.study.engine import Progress

_STUDY = typer.Argument(help="The study: its folder or its study.yaml.")
_RESULTS = typer.Argument(help="The folder of a study or of a fit.")


@app.command(epilog="Example: vasowave demo --output vasowave-demo")
def demo(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder of the study.")] = Path("vasowave-demo"),
    starts: Annotated[int, typer.Option(min=1, help="Starts of each fit.")] = 4,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the virtual animals.")] = 1,
) -> None:
    """Do a whole study of 7 + 5 virtual mice, from raw recordings to the report. No animal was measured."""
    from vasowave.study.virtual import write_virtual_study

    typer.echo("SYNTHETIC: vasowave makes the twelve mice itself, from published parameters and group statistics.")
    begun = time.monotonic()
    write_virtual_study(output, starts=starts, seed=seed)
    typer.echo(f"Study: {output} ({time.monotonic() - begun:.0f} s)")
    _run(output)


@app.command(epilog="Example: vasowave new my-study")
def new(
    folder: Annotated[Path, typer.Argument(help="Folder to make.")],
    groups: Annotated[str, typer.Option(help="Group labels, the reference first.")] = "CTL,HPH",
) -> None:
    """Make a study: a commented study.yaml, an empty animals.csv, and folders for the files."""
    from vasowave.study.template import new_study

    for path in new_study(folder, [label.strip() for label in groups.split(",")]):
        typer.echo(f"  {path}")
    typer.echo(
        f"Next: vasowave add {folder} FILES… (or put the files into {folder / 'networks'} and {folder / 'recordings'} "
        f"and one row per animal into {folder / 'animals.csv'}; then vasowave check {folder})"
    )


@app.command(
    epilog="Example: vasowave add my-study lab/control lab/hypoxia --network lung.csv. Groups and names are told by "
    "names of files and folders; what nothing tells is said and left empty."
)
def add(
    study: Annotated[Path, _STUDY],
    paths: Annotated[list[Path], typer.Argument(help="Recordings and networks: files, or folders of them.")],
    group: Annotated[str, typer.Option(help="The group of all of them.")] = "",
    network: Annotated[Path | None, typer.Option(help="The vessel table of all of them.")] = None,
    period: Annotated[float | None, typer.Option(help="Period, s, of averaged cycles without a time column.")] = None,
) -> None:
    """Put files into a study: a row in its table for every recording, and what was read of it."""
    from vasowave.study.adding import add_files
    from vasowave.study.checking import check_study

    added = add_files(study, paths, group=group, network=network, period=period)
    names = {row["animal"] for row in added.rows}
    typer.echo(f"{added.table}: {_counted(len(names), 'new row')}")
    problems, read, settings = check_study(study)
    new = [one for one in read if one.animal in names]
    if settings is not None and new:
        show_read(new, settings)
    for said in added.said:
        typer.echo(f"note: {said}")
    errors = sum(problem.error for problem in problems)
    more = f"{_counted(errors, 'error')} in the study" if errors else "The study can run"
    typer.echo(f"{more}; see vasowave check {study}" if errors else f"{more}: vasowave run {study}")


@app.command(epilog="Example: vasowave check my-study")
def check(study: Annotated[Path, _STUDY] = Path()) -> None:
    """Say everything that is wrong or odd about a study. Exit status 1 if it cannot run like this."""
    from vasowave.study.checking import check_study

    problems, read, settings = check_study(study)
    errors = [problem for problem in problems if problem.error]
    if settings is not None and read:
        show_read(read, settings)
    for problem in problems:
        typer.echo(f"{'error' if problem.error else 'warning'}: {problem}")
    count = len(problems) - len(errors)
    said = f"{_counted(len(errors), 'error')}, {_counted(count, 'warning')}"
    typer.echo(said if problems else "Nothing is wrong or odd.")
    raise typer.Exit(1 if errors else 0)


def _counted(count: int, what: str) -> str:
    return f"{count} {what}{'' if count == 1 else 's'}"


@app.command(epilog="Example: vasowave run my-study")
def run(
    study: Annotated[Path, _STUDY] = Path(),
    workers: Annotated[int | None, typer.Option(min=1, help="Processes; by default one for every core.")] = None,
    scheduler: Annotated[str | None, typer.Option(help="Address of a Dask scheduler to run on.")] = None,
    report: Annotated[bool, typer.Option(help="Make the report too.")] = True,
    pdf: Annotated[bool | None, typer.Option(help="Write the report as PDF too.")] = None,
) -> None:
    """Do the study. After an interruption of any kind, run it again: it goes on where it was."""
    _run(study, workers, scheduler, report, pdf)


def _run(
    study: Path,
    workers: int | None = None,
    scheduler: str | None = None,
    report: bool = True,
    pdf: bool | None = None,
) -> None:
    from vasowave.study.plan import read_study
    from vasowave.study.reporting import report_study
    from vasowave.study.running import run_study

    plan = read_study(study)
    typer.echo(f"{_counted(len(plan.animals), 'animal')}. The first compiles the solver, which takes a minute once.")
    begun = time.monotonic()
    try:
        with _shown(len(plan.animals)) as show:
            done = run_study(plan, workers=workers, scheduler=scheduler, progress=show)
    except KeyboardInterrupt:
        typer.echo("What had finished is kept; run it again to go on.", err=True)
        raise typer.Exit(130) from None
    typer.echo(
        f"{_counted(len(done.computed), 'animal')} computed, {len(done.kept)} kept from earlier, "
        f"{len(done.failures)} failed."
    )
    computed = time.monotonic()
    typer.echo(f"Results: {done.results} ({computed - begun:.0f} s)")
    if report:
        page = report_study(plan.path, pdf=pdf)
        typer.echo(f"Report: {page} ({time.monotonic() - computed:.0f} s)")
    for name, why in done.failures.items():
        typer.echo(f"failed: {name}: {why}", err=True)
    raise typer.Exit(FAILED if done.failures else 0)


@app.command("report", epilog="Example: vasowave report my-study")
def make_report(
    folder: Annotated[Path, _RESULTS] = Path(),
    pdf: Annotated[bool | None, typer.Option(help="Write the report as PDF too.")] = None,
) -> None:
    """Make page, tables and figures anew from the stored results alone, without simulating."""
    from vasowave.study.reporting import report_study

    typer.echo(f"Report: {report_study(folder, pdf=pdf)}")


@contextmanager
def _shown(count: int) -> "Iterator[Callable[[Progress], None]]":
    """Show a bar with the time left on a terminal, lines elsewhere."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn
    from rich.progress import Progress as Bars

    console = Console(stderr=True)
    columns = [TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()]
    with Bars(*columns, TextColumn("{task.fields[left]}"), console=console, disable=not console.is_terminal) as bars:
        task = bars.add_task("animals", total=count, left="")

        def show(step: "Progress") -> None:
            left = _left(step)
            bars.update(task, completed=step.done, left=left)
            why = f": {step.message}" if step.message else ""
            words = {"kept": "kept from earlier", "computed": "computed", "failed": "FAILED"}[step.what]
            console.print(
                f"{step.done} of {step.count}: {step.name} {words}{why}" + (f" ({left})" if left else ""),
                markup=False,
                highlight=False,
                soft_wrap=True,
            )

        yield show


def _left(step: "Progress") -> str:
    if step.left is None or step.done == step.count:
        return ""
    return f"about {step.left:.0f} s left" if step.left < 90 else f"about {step.left / 60:.0f} min left"


__all__ = ["check", "demo", "make_report", "new", "run"]
