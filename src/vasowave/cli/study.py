"""Commands on a study: demo, new, check, run, report."""

import time
from pathlib import Path
from typing import Annotated

import typer

from vasowave.cli.app import FAILED, app
from vasowave.cli.progress import show_read
from vasowave.threads import cores

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
    as_json: Annotated[bool, typer.Option("--json", help="Tell every step as a line of JSON, for programs.")] = False,
) -> None:
    """Do the study. After an interruption of any kind, run it again: it goes on where it was."""
    _run(study, workers, scheduler, report, pdf, as_json)


@app.command(epilog="Example: vasowave status my-study")
def status(study: Annotated[Path, _STUDY] = Path()) -> None:
    """Say how far a study is that is being run, here or elsewhere, or that was interrupted."""
    from vasowave.study.plan import read_study
    from vasowave.study.status import study_status

    animals, runner = study_status(read_study(study))
    for one in animals:
        typer.echo(f"{one.animal}: {one}")
    done, lost = (sum(one.state == state for one in animals) for state in ("done", "failed"))
    typer.echo(
        f"{done} of {_counted(len(animals), 'animal')} done; "
        + (f"{lost} failed; " if lost else "")
        + (f"being run by {runner}" if runner else "not being run")
    )


def _run(
    study: Path,
    workers: int | None = None,
    scheduler: str | None = None,
    report: bool = True,
    pdf: bool | None = None,
    as_json: bool = False,
) -> None:
    from vasowave.animal.failure import as_plain
    from vasowave.cli.watching import event, watched
    from vasowave.study.plan import read_study
    from vasowave.study.reporting import report_study
    from vasowave.study.running import run_study

    plan = read_study(study)
    say = (lambda text: None) if as_json else typer.echo
    say(f"{_counted(len(plan.animals), 'animal')}. The first compiles the solver, which takes a minute once.")
    begun = time.monotonic()
    try:
        with watched(plan, as_json) as show:
            done = run_study(plan, workers=workers, scheduler=scheduler, progress=show.step)
    except KeyboardInterrupt:
        typer.echo("What had finished is kept, every search of a fit too; run it again to go on.", err=True)
        raise typer.Exit(130) from None
    say(
        f"{_counted(len(done.computed), 'animal')} computed, {len(done.kept)} kept from earlier, "
        f"{len(done.lost)} failed."
    )
    computed = time.monotonic()
    say(f"Results: {done.results} ({computed - begun:.0f} s)")
    page = report_study(plan.path, pdf, workers or cores()) if report else None
    if page is not None:
        say(f"Report: {page} ({time.monotonic() - computed:.0f} s)")
    if as_json:
        event("done", results=str(done.results), report=None if page is None else str(page),
              failures=as_plain(done.failures))  # fmt: skip
    for one in done.failures:
        typer.echo(f"failed: {one.animal}: {one}", err=True)
    raise typer.Exit(FAILED if done.failures else 0)


@app.command("report", epilog="Example: vasowave report my-study")
def make_report(
    folder: Annotated[Path, _RESULTS] = Path(),
    pdf: Annotated[bool | None, typer.Option(help="Write the report as PDF too.")] = None,
    animal: Annotated[str, typer.Option(help="Of this animal alone, in a folder of its own.")] = "",
) -> None:
    """Make page, tables and figures anew from the stored results alone, without simulating."""
    from vasowave.study.reporting import report_study

    typer.echo(f"Report: {report_study(folder, pdf, cores(), animal)}")


__all__ = ["add", "check", "demo", "make_report", "new", "run", "status"]
