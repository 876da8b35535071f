"""Commands on a study: demo, new, check, run, status, stop, report."""

import os
import platform
import shlex
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import Annotated, Any

import typer

import vasowave as vw
from vasowave.base.errors import InputError
from vasowave.base.runtime.interrupts import interruptible
from vasowave.base.runtime.thread_limits import cores
from vasowave.cli import models
from vasowave.cli.answer import Answer
from vasowave.cli.app import FAILED, WRONG_INPUT, app
from vasowave.cli.cures import VALUE, problem_lines, shell_of
from vasowave.cli.progress import alive, print_text, show_animals, waiting, work_of
from vasowave.cli.signatures import VERBOSE
from vasowave.study import animal as animals
from vasowave.study import datasets, entering, running
from vasowave.study import folder as folders
from vasowave.study import report as reports

_STUDY = typer.Argument(help="The study: its folder or its study.yaml.")
_STATUS = typer.Argument(help="The folder of a study or of a fit, or a study.yaml.")
_MAX_WARNINGS = 3  # of animals, told at the end of a run
_RESULTS = typer.Argument(help="The folder of a study or of a fit.")


@app.command(epilog="Example: vasowave demo --output vasowave-demo")
def demo(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder of the study.")] = Path("vasowave-demo"),
    starts: Annotated[int, typer.Option(min=1, help="Starts of each fit.")] = 4,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the virtual animals.")] = 1,
) -> None:
    """Do a whole study of 7 + 5 virtual mice, from raw recordings to the report. No animal was measured."""
    typer.echo("SYNTHETIC: vasowave makes the twelve mice itself, from published parameters and group statistics.")
    begun = time.monotonic()
    running.compile_beside("tangent")  # the mice are made with the linear wall
    entering.write_virtual_study(output, starts=starts, seed=seed)
    typer.echo(f"Study: {output} ({time.monotonic() - begun:.0f} s)")
    _run(output)


@app.command(epilog="Example: vasowave samples lab")
def samples(
    folder: Annotated[Path, typer.Argument(help="Folder to make.")],
    seed: Annotated[int, typer.Option(min=0, help="Seed of the virtual animals.")] = 10,
) -> None:
    """Write six synthetic recordings and two vessel tables to practise on, untidy as a lab's files are."""
    for path in datasets.write_lab_files(folder, seed):
        typer.echo(f"  {path}")
    typer.echo("SYNTHETIC: vasowave made these files from published parameters; no animal was measured.")
    typer.echo(f"Next: vasowave new my-study --groups control,hypoxia; vasowave add my-study {_typed(folder)}")


@app.command(epilog="Example: vasowave new my-study")
def new(
    folder: Annotated[Path, typer.Argument(help="Folder to make.")],
    groups: Annotated[str, typer.Option(help="Group labels, the reference first.")] = "CTL,HPH",
    species: Annotated[str, typer.Option(help=f"{models.SPECIES_NAMES}.")] = "mouse",
) -> None:
    """Make a study: a commented study.yaml, an empty animals.csv, and folders for the files."""
    labels = [(label.partition("=")[0] or label).strip() for label in groups.split(",")]
    if labels != [label.strip() for label in groups.split(",")]:
        print_text("note: groups are called by what stands before '='; say the whole to `vasowave add --groups`, too")
    for path in entering.new_study(folder, labels, species):
        typer.echo(f"  {path}")
    if len(labels) == 1:
        print_text(
            f"note: '{labels[0]}' is one group, and nothing is compared with it; commas separate groups: CTL,HPH"
        )
    typer.echo(
        f"Next: vasowave add {_typed(folder)} FILES… (or put the files into {folder / 'networks'} and "
        f"{folder / 'recordings'} and one row per animal into {folder / 'animals.csv'}; then vasowave check "
        f"{_typed(folder)})"
    )


@app.command(
    epilog="Example: vasowave add my-study lab/control lab/hypoxia --network lung.csv. Groups and names are told by "
    "names of files and folders; fields that cannot be determined are left empty and listed. In the study's folder its "
    "name may be left out: vasowave add ../raw. Adding a file again fills what its row lacks."
)
def add(
    study: Annotated[Path, _STUDY],
    paths: Annotated[list[Path] | None, typer.Argument(help="Recordings and networks: files, or folders.")] = None,
    group: Annotated[str, typer.Option(help="The group of those that have none in the table.")] = "",
    groups: Annotated[str, typer.Option(help="Groups of the study: WT,HOX, or control=WT,hypoxic=HOX.")] = "",
    network: Annotated[Path | None, typer.Option(help="The vessel table of all of them.")] = None,
    setting_values: Annotated[Any, typer.Option(hidden=True, parser=str)] = None,
) -> None:
    """Put files into a study: a row in its table for every recording, and what was read of it.

    Exit status 3 if a file could not be read, else that of `check`: 1 if the study cannot run like this.
    """
    from vasowave.cli.options import CELLS_OF_ADD, row_cells

    place, files = _study_here(study, paths or [])
    cells = row_cells(dict(setting_values or {}), CELLS_OF_ADD)
    if group == VALUE:
        raise InputError(f"{VALUE} stands for what you know: type the group itself; nothing was added")
    added = entering.add_files(place, files, group=group, groups=groups, network=network, cells=cells,
                      ask=_ask if sys.stdin.isatty() and sys.stdout.isatty() else None)  # fmt: skip
    names = {row["animal"] for row in added.rows}
    suffix = f", {_counted(len(added.updated), 'row')} updated" if added.updated else ""
    print_text(f"{added.table}: {_counted(len(names), 'new row')}{suffix}")
    problems, read, settings, *_ = entering.check_study(place)
    new = [animal for animal in read if animal.animal in names | set(added.updated)]
    if settings is not None and new:
        show_animals([animal.row() for animal in new])
        print_text(work_of(new, settings))
    for remark in added.said:
        print_text(f"note: {remark}")
    if commands := shell_of(place).below(added.cures):
        print_text(f"To say it otherwise:{commands}")
    touched = names | set(added.updated)
    added_problems = [problem for problem in problems if not problem.animals or touched & set(problem.animals)]
    _tell_problems(added_problems, place)
    for reason in added.refused:
        print_text(f"error: not added: {reason}")
    errors = sum(problem.error for problem in problems)
    if len(added_problems) < len(problems):
        count = _counted(len(problems) - len(added_problems), "finding")
        print_text(f"{count} of animals that were there: see vasowave check {_typed(place)}")
    if errors:
        print_text(f"{_counted(errors, 'error')} to mend in the study: see vasowave check {_typed(place)}")
    else:
        print_text(f"The study can run: vasowave run {_typed(place)}")
    if added.refused:
        print_text(
            f"{_counted(len(added.refused), 'file')} of these could not be read: no row of the table holds such a file"
        )
    if added.refused or any(problem.finding.code == folders.UNREADABLE.code for problem in added_problems):
        raise typer.Exit(FAILED)
    raise typer.Exit(WRONG_INPUT if errors else 0)


@app.command(
    "set",
    epilog="Example: vasowave set my-study averaging.reject_ventilation=false; vasowave set my-study 'wedge [mmHg]=8' "
    "--animal 'rat 1' --animal 'rat 2'. Keys: docs/study-file.md. Comments and order of the files stay.",
)
def set_values(
    study: Annotated[Path, _STUDY],
    values: Annotated[
        list[str] | None, typer.Argument(metavar="KEY=VALUE…", help="Settings, or cells by column.")
    ] = None,
    animal: Annotated[list[str] | None, typer.Option(help="Whose cells are meant; may be repeated.")] = None,
    remove: Annotated[bool, typer.Option("--remove", help="Take the rows of these animals out.")] = False,
) -> None:
    """Write settings of a study, or with --animal cells of its table of animals."""
    if remove and animal and not values:
        print_text(f"{entering.remove_animals(study, animal)}: {', '.join(animal)} taken out")
        return
    if remove or not values:
        raise InputError("write KEY=VALUE, as in averaging.reject_ventilation=false; or --animal NAME --remove alone")
    pairs = [(key.strip(), equals, text.strip()) for key, equals, text in (value.partition("=") for value in values)]
    for (key, equals, text), value in zip(pairs, values, strict=True):
        if not (key and equals) or (not text and not animal):
            raise InputError(f"'{value}': write KEY=VALUE, as in averaging.reject_ventilation=false")
        if VALUE in text.strip("[]").split(","):
            raise InputError(f"{VALUE} stands for what you know: type the value itself; nothing was written")
    written = {key: text for key, _, text in pairs}
    if len(written) < len(pairs):
        raise InputError("a key is given twice; give each once")
    file = entering.set_values(study, written, animal or ())
    whose = f" of {', '.join(animal)}" if animal else ""
    now = [f"{key}: {text}" if text else f"{key} emptied" for key, text in written.items()]
    print_text(f"{file}: {', '.join(now)}{whose}")


def _tell_problems(problems: "Sequence[folders.StudyProblem]", study: Path) -> None:
    shell = shell_of(study)
    for line in problem_lines(problems, shell):
        print_text(line)


def _study_here(study: Path, paths: list[Path]) -> tuple[Path, list[Path]]:
    """Return the study and the files; where the first name is not a study but the current folder is, all are files."""
    is_study = folders.study_path(study).is_file() and (study.is_dir() or study.suffix.lower() in folders.YAML)
    if not is_study and Path(folders.STUDY_FILE).is_file():
        return Path(), [study, *paths]
    if study.is_file() and not is_study:
        raise InputError(f"{study} is not a study; name the study's folder before the files (`vasowave new` makes one)")
    if not paths:
        raise InputError(f"{study}: which files? Name recordings and networks, or their folders: vasowave add "
                         f"{_typed(study)} FILES")  # fmt: skip
    return study, paths


def _typed(path: Path) -> str:
    """Return a name as a shell takes it."""
    return shlex.quote(str(path))


def _ask(question: str, proposal: str) -> str:
    return str(typer.prompt(question, default=proposal))


@app.command(epilog="Example: vasowave check my-study")
def check(study: Annotated[Path, _STUDY] = Path(), trust: Annotated[bool, models.TRUST] = False) -> None:
    """Say everything that is wrong or odd about a study. Exit status 1 if it cannot run like this.

    When nothing is wrong, what the study will compare is written with the time into declared.json.
    """
    answer = Answer("check", study)
    if not trust and answer.repeated():
        raise typer.Exit(0)
    models.trust_programs(study, trust)
    with answer.recorded(study):
        errors = _check(study, answer)
        if errors:
            raise typer.Exit(1)
    raise typer.Exit(0)


def _check(study: Path, answer: Answer) -> int:
    """Check a study, say what is wrong or odd, and return how many errors there are."""
    problems, read, settings, design, notes = entering.check_study(study)
    errors = sum(problem.error for problem in problems)
    if settings is not None and read:
        answer.announce("animals", [animal.row() for animal in read])
        answer.announce("text", work_of(read, settings))
    shell = shell_of(study)
    lines = problem_lines(problems, shell)
    for line in [*lines, *(() if errors else problem_lines(notes, shell))]:
        answer.announce("text", line)
    if settings is not None and not errors:
        running.declare(vw.read_study(study))
    if design:
        answer.announce("line", f"Design: {design}")
    counts = f"{_counted(errors, 'error')}, {_counted(len(problems) - errors, 'warning')}"
    details = f"; each by itself: vasowave -v check {_typed(study)}" if len(lines) < len(problems) else ""
    answer.announce("line", f"{counts}{details}" if problems else "Nothing is wrong or odd.")
    return errors


def _counted(count: int, noun: str) -> str:
    return f"{count} {noun}{'' if count == 1 else 's'}"


@app.command(epilog="Example: vasowave run my-study")
def run(
    study: Annotated[Path, _STUDY] = Path(),
    workers: Annotated[int | None, typer.Option(min=1, help="Processes; by default one for every core.")] = None,
    scheduler: Annotated[str | None, typer.Option(help="Address of a Dask scheduler to run on.")] = None,
    report: Annotated[bool, typer.Option(help="Make the report too.")] = True,
    pdf: Annotated[bool | None, typer.Option(help="Write the report as PDF too.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Tell every step as a line of JSON, for programs.")] = False,
    trust: Annotated[bool, models.TRUST] = False,
) -> None:
    """Do the study. After an interruption of any kind, run it again: it goes on where it was."""
    if not (trust or scheduler or as_json) and _run_again(study, report, Answer("run", study, str(report), str(pdf))):
        return
    models.trust_programs(study, trust)
    _run(study, workers, scheduler, report, pdf, as_json)


def _run_again(study: Path, report: bool, answer: Answer) -> bool:
    """Do a run that has nothing to do, and return whether that is so: no file has changed since the last."""
    count = dict(answer.recalled() or ()).get("count")
    if count is None:
        return False
    with interruptible(), running.running(folders.study_path(study).parent, count) as run:
        stage = {"stage": "writing the report"} if report else {}
        run.write(**stage, done=count, message=f"0 computed, {count} kept from earlier, 0 failed")
        return answer.repeated()


@app.command(epilog="Example: vasowave status my-study")
def status(study: Annotated[Path, _STATUS] = Path()) -> None:
    """Say how far a study, or the fit of one animal, is: run here, elsewhere, or interrupted.

    Exit status 1 if the study holds errors; animals whose rows do are not among those listed.
    """
    alone = running.fit_status(study) if study.is_dir() and not folders.study_path(study).exists() else None
    plan, problems = (None, []) if alone else running.inspect_study(study)
    errors = [problem for problem in problems if problem.error]
    if plan is None:
        folders.refuse(errors)
    animals, runner, run = vw.study_status(plan) if plan is not None else alone or ((), None, None)
    for animal in animals:
        print_text(f"{animal.animal}: {animal}")
    done, lost = (sum(animal.state == state for animal in animals) for state in ("done", "failed"))
    print_text(
        f"{done} of {_counted(len(animals), _row_of(plan))} done; "
        + (f"{lost} failed; " if lost else "")
        + (f"being run by {runner}" if runner else "not being run")
        + (f": {run.stage}" if run is not None and run.ended is None else "")
    )
    if run is not None and (run.ended or run.stopped_by):
        print_text(str(run))
    if plan is not None and not errors and (earlier := _earlier(plan)):
        print_text(
            f"The results are of an earlier {earlier}; vasowave run {_typed(study)} writes them anew, with the report"
        )
    _tell_problems(errors + [problem for problem in problems if problem.finding.code == running.NOT_RUN.code], study)
    raise typer.Exit(1 if errors else 0)


@app.command(epilog="Example: vasowave stop my-study")
def stop(study: Annotated[Path, _STATUS] = Path()) -> None:
    """Ask the run of a study to stop, wherever it runs; once more, some seconds later, end it at once."""
    folder = study if study.is_dir() else folders.study_path(study).parent
    by = f"vasowave stop (process {os.getpid()} on {platform.node()})"
    answer = running.ask_to_stop(folder / folders.RESULTS, by)
    typer.echo(f"{answer[0].upper()}{answer[1:]}.")


def _row_of(plan: "folders.Study | None") -> str:
    """Return what a row of the table of animals is."""
    return "recording" if plan is not None and plan.settings.design.subject else "animal"


def _earlier(plan: "folders.Study") -> str:
    """Return what the study says otherwise than when its results were made, of what no animal is computed anew for."""
    try:
        settings, columns = running.outdated(plan, vw.read_results(plan.results))
    except InputError:  # there are none yet
        return ""
    return reports.listed([*settings, *(f"column '{label}'" for label in columns)])


def _run(
    study: Path,
    workers: int | None = None,
    scheduler: str | None = None,
    report: bool = True,
    pdf: bool | None = None,
    as_json: bool = False,
) -> None:
    from vasowave.cli.watching import event
    from vasowave.study.entering.checking import doubled_animals

    answer = Answer("run", study, str(report), str(pdf))
    with answer.recorded(study, ran=True) if not as_json else nullcontext():
        plan = vw.read_study(study)
        folders.refuse(doubled_animals(plan))
        announce = (lambda *text: None) if as_json else answer.announce
        announce("count", len(plan.animals))
        announce("line", f"{_counted(len(plan.animals), _row_of(plan))}.")
        try:
            with interruptible(), running.running(plan.folder, len(plan.animals)) as run:
                done, page = _run_and_report(run, plan, workers, scheduler, report, pdf, None if as_json else announce)
        except KeyboardInterrupt:
            typer.echo("What had finished is kept, every search of a fit too; run it again to go on.", err=True)
            raise typer.Exit(130) from None
        if as_json:
            missing = [row.as_plain() for row in running.missing_of(plan.path)] if done.failures else []
            warned = [{"animal": name, "code": finding.code, "text": str(finding)}
                      for name, findings in done.warnings.items() for finding in findings]  # fmt: skip
            event("done", results=str(done.results), report=None if page is None else str(page),
                  failures=animals.as_plain(done.failures), missing=missing, warnings=warned)  # fmt: skip
        else:
            problems = [folders.StudyProblem(finding.at("", line=0, part="", animal=name))
                        for name, findings in done.warnings.items() for finding in findings]  # fmt: skip
            lines = problem_lines(problems, shell_of(plan.path))
            shown = lines if VERBOSE.get() else lines[:_MAX_WARNINGS]
            for line in shown:
                answer.announce("text", line)
            if len(shown) < len(lines):
                surplus = _counted(len(lines) - len(shown), "further warning")
                answer.announce("text", f"{surplus}; all, each by itself: vasowave -v run {_typed(study)}")
        for failure in done.failures:
            typer.echo(f"failed: {failure.animal}: {failure}", err=True)
        if done.failures:
            raise typer.Exit(FAILED)


def _run_and_report(
    run: "running.RunRecord", plan: "folders.Study", workers: int | None, scheduler: str | None, report: bool,
    pdf: bool | None, announce: "Callable[..., None] | None",
) -> "tuple[running.Done, Path | None]":  # fmt: skip
    """Do a study within a run that has begun, and write its report; say both, as JSON where nothing else says it."""
    from vasowave.cli.watching import watched

    as_json, begun, rows = announce is None, time.monotonic(), _row_of(plan)
    announce = announce or (lambda *text: None)
    with watched(plan, as_json) as show:
        done = running.analyze_study(run, plan, workers=workers, scheduler=scheduler, progress=show.step)
    resumed = f" ({len(done.resumed)} from searches that were kept)" if done.resumed else ""
    announce("line",
        f"{_counted(len(done.computed), rows)} computed{resumed}, {len(done.kept)} kept from earlier, "
        f"{len(done.lost)} failed.",
        f"{_counted(0, rows)} computed, {len(plan.animals)} kept from earlier, 0 failed.")  # fmt: skip
    computed = time.monotonic()
    announce("line", f"Results: {done.results} ({computed - begun:.0f} s)", f"Results: {done.results} (0 s)")
    answers: list[tuple[str, str]] = []
    run.write(stage="writing the report" if report else run.status.stage)
    with nullcontext() if as_json else alive("writing the report"):
        page = running.report_study(plan.path, pdf, workers or cores(), announce=answers.extend) if report else None
    for question, answer in answers[:1]:
        announce("line", f"{question}: {answer}")
    if page is not None:
        announce("line", f"Report: {page} ({time.monotonic() - computed:.0f} s)", f"Report: {page} (0 s)")
    return done, page


@app.command("report", epilog="Example: vasowave report my-study")
def make_report(
    folder: Annotated[Path, _RESULTS] = Path(),
    pdf: Annotated[bool | None, typer.Option(help="Write the report as PDF too.")] = None,
    animal: Annotated[str, typer.Option(help="Of this animal alone, in a folder of its own.")] = "",
) -> None:
    """Make page, tables and figures anew from the stored results alone, without simulating."""
    typer.echo(f"Report: {running.report_study(folder, pdf, cores(), animal)}")


@app.command(epilog="Example: vasowave plan --effect 1.5; vasowave plan my-pilot --effect 0.7 --power 0.9 -o plan.html")
def plan(
    study: Annotated[Path | None, typer.Argument(help="A study that was run; without it, the published mice.")] = None,
    effect: Annotated[float, typer.Option(help="Ratio of the groups that shall be shown.")] = 1.5,
    power: Annotated[float, typer.Option(help="How often it shall be.")] = 0.8,
    occasions: Annotated[int, typer.Option(min=1, help="Recordings of each animal, averaged.")] = 1,
    pairs: Annotated[
        float | None,
        typer.Option(help="Compare pairs, an animal before and after, whose true values are correlated by so much."),
    ] = None,
    littermates: Annotated[
        bool, typer.Option("--littermates", help="A pair is two littermates, of which each group has one.")
    ] = False,
    output: Annotated[Path, typer.Option("--output", "-o", help="Page to write.")] = Path("plan.html"),
) -> None:
    """Say how many animals a study of two groups, or of pairs, needs to show an effect, and what would save some."""
    print_text("Studies of every size are drawn and tested; this takes about a minute.", err=True)
    with waiting("planning"):
        study_plan = vw.plan(
            study, effect=effect, power=power, occasions=occasions, pairs=pairs, littermates=littermates
        )
    for text in reports.plan_texts(study_plan):
        typer.echo(text)
    typer.echo(f"Page: {reports.write_plan(study_plan, output)}")
