"""The command on one animal: fit."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vasowave.cli.app import FAILED, app

if TYPE_CHECKING:
    from vasowave.study.plan import Study

_PERIOD = typer.Option(help="Period of the cycle in seconds, for recordings without a time column.")
_OUTPUT = typer.Option("--output", "-o", help="Folder for results and report.")


@app.command(
    epilog="Example: vasowave fit network.csv recording.txt --output my-mouse. "
    "The network has the columns name, parent, length \\[cm], radius \\[cm]. The recording is one averaged cycle "
    "(time \\[s], pressure \\[mmHg], flow \\[ml/s], or two files of one column each) or a continuous one (LabChart, "
    "EDF, CSV); which, is told from what is in it."
)
def fit(
    network: Annotated[Path, typer.Argument(help="Vessel table, CSV.")],
    recording: Annotated[list[Path], typer.Argument(help="One file, or pressure and flow of one averaged cycle.")],
    output: Annotated[Path, _OUTPUT] = Path("vasowave-fit"),
    period: Annotated[float | None, _PERIOD] = None,
    animal: Annotated[str, typer.Option(help="Name of the animal; by default that of the recording.")] = "",
    group: Annotated[str, typer.Option(help="Its group, as the report writes it.")] = "animal",
    given: Annotated[Any, typer.Option(hidden=True, parser=str)] = None,
) -> None:
    """Calibrate the model to one animal and write results, figures and report: a study of one."""
    from vasowave.cli.study_options import read_settings
    from vasowave.study.alone import animal_alone

    name = animal or recording[0].stem
    settings = read_settings(given or {}, name, group)
    study = animal_alone(output, settings, network, recording, name, period)
    _fit(study)


def _fit(study: "Study") -> None:
    from vasowave.cli.progress import counting
    from vasowave.study.alone import fit_sentences
    from vasowave.study.reporting import report_study
    from vasowave.study.results import read_results
    from vasowave.study.running import run_alone

    typer.echo("The first fit with a wall law compiles the solver, which takes half a minute once.")
    with counting() as show:
        done = run_alone(study, show)
    typer.echo(f"Results: {done.results}{'' if done.computed else ' (kept from earlier)'}")
    (result,) = read_results(study.folder).in_order()
    for sentence in fit_sentences(result):
        typer.echo(f"  {sentence}")
    typer.echo(f"Report: {report_study(study.folder)}")
    for one in done.failures:
        typer.echo(f"failed: {one}", err=True)
    raise typer.Exit(FAILED if done.failures else 0)
