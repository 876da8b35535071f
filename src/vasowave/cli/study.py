"""Commands on a study: demo, new, check, run, report."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vasowave.cli.app import FAILED, app

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
def new(folder: Annotated[Path, typer.Argument(help="Folder to make.")]) -> None:
    """Make a study: a commented study.yaml, an empty animals.csv, and folders for the files."""
    from vasowave.study.template import new_study

    for path in new_study(folder):
        typer.echo(f"  {path}")
    typer.echo(
        f"Next: put vessel tables into {folder / 'networks'}, recordings into {folder / 'recordings'} and one row per "
        f"animal into {folder / 'animals.csv'}; then vasowave check {folder}"
    )


@app.command(epilog="Example: vasowave check my-study")
def check(study: Annotated[Path, _STUDY] = Path()) -> None:
    """Say everything that is wrong or odd about a study. Exit status 1 if it cannot run like this."""
    from vasowave.study.checking import check_study

    problems = check_study(study)
    errors = [problem for problem in problems if problem.error]
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
