"""The commands on one animal: fit, right-heart, posterior."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vasowave.cli import models
from vasowave.cli.app import FAILED, app
from vasowave.cli.cures import Shell, code_of
from vasowave.cli.signatures import with_option_groups

if TYPE_CHECKING:
    from vasowave.base.findings import Finding
    from vasowave.pulse.cycle.cycle import Recording
    from vasowave.pulse.cycle.observation import Observation
    from vasowave.pulse.inference.result import Posterior
    from vasowave.pulse.network.network import Network
    from vasowave.study.animal.animal import Settings
    from vasowave.study.folder.study import Study
    from vasowave.study.running.runs import Done

_OUTPUT = typer.Option("--output", "-o", help="Folder for results and report.")


@app.command(
    epilog="Example: vasowave fit network.csv recording.txt --output my-mouse. "
    "The network has the columns name, parent, length \\[cm], radius \\[cm]. The recording is one averaged cycle "
    "(time \\[s], pressure \\[mmHg], flow \\[ml/s], or two files of one column each) or a continuous one (LabChart, "
    "EDF, CSV); its content tells which."
)
def fit(
    network: Annotated[Path, typer.Argument(help="Vessel table, CSV.")],
    recording: Annotated[list[Path], typer.Argument(help="One file, or pressure and flow of one averaged cycle.")],
    output: Annotated[Path, _OUTPUT] = Path("vasowave-fit"),
    animal: Annotated[str, typer.Option(help="Name of the animal; by default that of the recording.")] = "",
    group: Annotated[str, typer.Option(help="Its group, as the report writes it.")] = "animal",
    setting_values: Annotated[Any, typer.Option(hidden=True, parser=str)] = None,
) -> None:
    """Calibrate the model to one animal and write results, figures and report: a study of one."""
    from vasowave.cli.options import read_settings, row_cells
    from vasowave.study.folder.names import plain_name
    from vasowave.study.running.single_animal import animal_alone

    name, options = animal or plain_name(recording[0].stem), dict(setting_values or {})
    cells = row_cells(options)
    settings = read_settings(options, name, group)
    _fit(animal_alone(output, settings, network, recording, name, cells))


@app.command(epilog="Example: vasowave indices recording.txt -o beats.csv. No vessels are needed.")
def indices(
    recording: Annotated[list[Path], typer.Argument(help="One file, or pressure and flow.")],
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Table of all beats, .csv.")] = None,
    setting_values: Annotated[Any, typer.Option(hidden=True, parser=str)] = None,
) -> None:
    """Say what a recording alone tells: pressures, ejection, slopes, notch, load, power; and how its beats scatter."""
    from vasowave.cli.options import read_settings, row_cells
    from vasowave.cli.progress import print_text
    from vasowave.study.animal.indices import check_beats_file, indices_text, write_beats
    from vasowave.study.folder.names import plain_name
    from vasowave.study.results.loading import load_recording
    from vasowave.study.running.single_animal import one_row

    name, options = plain_name(recording[0].stem), dict(setting_values or {})
    check_beats_file(output)
    row = one_row(None, recording, name, name, row_cells(options))
    cycle, average = load_recording(row, read_settings(options, name, name))
    print_text(indices_text(cycle, average))
    for note in cycle.notes:
        typer.echo(f"note: {note}", err=True)
    if output is not None and average is not None:
        typer.echo(f"Beats: {write_beats(cycle, average, output)}")
    elif output is not None:
        typer.echo(f"no beats are written: {recording[0]} holds one averaged cycle; leave '--output' out", err=True)
        raise typer.Exit(FAILED)


@app.command(
    "right-heart",
    epilog="Example: vasowave right-heart numbers.csv, a table of quantity,value,unit (mean, systolic, diastolic, "
    "wedge, cardiac output, heart rate), or one with a row an animal and titles such as mean \\[mmHg].",
)
def right_heart(numbers: Annotated[Path, typer.Argument(help="Table of the numbers: CSV or a workbook.")]) -> None:
    """Say what the numbers of a right-heart catheter determine (PVR, stroke volume, C), and what they do not."""
    from vasowave.catheter.right_heart import read_right_heart
    from vasowave.cli.progress import print_text

    for animal in read_right_heart(numbers):
        print_text(str(animal))


def _fit(study: "Study") -> None:
    from vasowave.base.runtime.interrupts import interruptible
    from vasowave.cli.progress import alive, print_text
    from vasowave.cli.watching import watched
    from vasowave.study.running.reporting import report_study
    from vasowave.study.running.run_state import running
    from vasowave.study.running.runs import run_alone
    from vasowave.study.running.single_animal import nothing_left

    with interruptible(), nothing_left(study.folder), running(study.folder, 1) as run:
        with watched(study, as_json=False):
            done = run_alone(run, study)
        _say_fit(done, study)
        run.write(stage="writing the report")
        with alive("writing the report"):
            page = report_study(study.folder)
    typer.echo(f"Report: {page}")
    for failure in done.failures:
        print_text(f"failed: {failure}", err=True)
    raise typer.Exit(FAILED if done.failures else 0)


def _say_fit(done: "Done", study: "Study") -> None:
    from vasowave.study.results.results import read_results
    from vasowave.study.running.single_animal import fit_sentences

    typer.echo(f"Results: {done.results}{'' if done.computed else ' (kept from earlier)'}")
    (result,) = read_results(study.folder).in_order()
    for sentence in fit_sentences(result, done.warnings.get(result.name, ()), _below):
        typer.echo(f"  {sentence}")


def _below(finding: "Finding") -> str:
    return code_of(finding) + Shell().below(finding.cures).replace("\n", "\n  ")


_DRAWS = typer.Option("--output", "-o", help="netCDF file of the draws, which arviz.from_netcdf reads.")


@dataclass(frozen=True)
class LawChoice:
    """The laws of a posterior, and whose it is; empty where the default holds."""

    wall: Annotated[str, models.WALL] = ""
    bed: Annotated[str, models.BED] = ""
    animal: Annotated[str, models.ANIMAL] = ""


@app.command(
    epilog="Example: vasowave posterior my-mouse --wall linear -o draws.nc; "
    "vasowave posterior network.csv recording.txt. The folder of a fit brings its settings along."
)
@with_option_groups
def posterior(
    network: Annotated[Path, typer.Argument(help="Vessel table; or, alone, the folder of a fit or a study.")],
    recording: Annotated[list[Path] | None, models.RECORDING] = None,
    output: Annotated[Path, _DRAWS] = Path("posterior.nc"),
    *,
    choice: LawChoice,
    draws: Annotated[int, typer.Option(help="Draws that are simulated and weighted.")] = 400,
    trust: Annotated[bool, models.TRUST] = False,
    setting_values: Annotated[Any, typer.Option(hidden=True, parser=str)] = None,
) -> None:
    """Say which parameters are compatible with one animal's recording when image and model are uncertain, too."""
    from vasowave.base.io.files import check_file
    from vasowave.cli.progress import alive
    from vasowave.pulse.inference.sampling import posterior as posterior_of

    check_file(output, models.DATA)
    models.trust_programs(network, trust)
    inputs = _fit_inputs(network, recording or [], choice, dict(setting_values or {}))
    (name, law), vessels, cycle, sites, settings = inputs
    made = [0]
    typer.echo(f"Posterior under the {name} wall. The first simulation compiles the solver.")

    def count(simulations: int) -> None:
        made[0] = simulations

    with alive(lambda: f"posterior, {name} wall: {made[0]} simulations"):
        result = posterior_of(
            vessels, cycle, law, sites=sites, bed=settings.beds, priors=settings.priors, blood=settings.blood,
            search=settings.search(law), numerics=settings.numerics, draws=draws, seed=settings.seed, progress=count,
        )  # fmt: skip
    result.to_netcdf(output)
    _print_posterior(result)
    typer.echo(f"Draws: {output}")
    raise typer.Exit(0 if result.diagnostics.trusted else FAILED)


def _fit_inputs(network: Path, recording: list[Path], choice: LawChoice, options: dict[str, Any]
           ) -> "tuple[tuple[str, Any], Network, Recording, tuple[Observation, ...], Settings]":  # fmt: skip
    """Return the law (name, class), vessels, cycle, sites, settings: of files and options, or all of a fit's folder."""
    from dataclasses import replace

    from vasowave.base.errors import InputError
    from vasowave.cli.options import flag, read_settings, row_cells
    from vasowave.pulse.model.laws import find_law
    from vasowave.study.animal import stored
    from vasowave.study.folder.settings import animal_settings

    if network.is_dir():
        if recording or options or choice.bed:
            surplus = ", ".join([*map(str, recording), *map(flag, options), *(["--bed"] if choice.bed else [])])
            raise InputError(f"{network} brings recording and settings along; leave out {surplus}")
        result = models.stored_animal(network, choice.animal)
        sites, measured = stored.stored_sites(result), (result.network, stored.stored_recording(result))
        return stored.stored_law(result, choice.wall), *measured, sites, stored.stored_settings(result)
    cells = row_cells(options)
    settings = read_settings(options, "posterior", "animal")
    loaded = models.animal_from(network, recording, cells, settings)
    chosen = animal_settings(settings)
    chosen = replace(chosen, beds=choice.bed or chosen.beds)
    law = find_law(choice.wall or chosen.walls[0])
    return (law.law().name, law), loaded.network, loaded.recording, loaded.sites, chosen


def _print_posterior(result: "Posterior") -> None:
    """Print the table of a posterior, its diagnostics, and what a reader must know."""
    from vasowave.base.findings import sentence
    from vasowave.cli.progress import print_text
    from vasowave.study.results.overview import aligned

    rows = [("", "median", "95 % interval", "prior 95 %", "unit")]
    rows += [
        (str(name), f"{row['median']:.4g}", f"[{row['interval_low']:.3g}, {row['interval_high']:.3g}]",
         f"[{row['prior_low']:.3g}, {row['prior_high']:.3g}]", str(row["unit"]).replace("1", "", row["unit"] == "1"))
        for name, row in result.summary.iterrows()
    ]  # fmt: skip
    for line in aligned(rows, (0, 4)):
        typer.echo(line)
    diagnostics = result.diagnostics
    trusted = "The sampling succeeded" if diagnostics.trusted else "Do not believe these numbers"
    print_text(
        f"{trusted}: Pareto k {diagnostics.k_hat:.2f}, "
        f"{diagnostics.effective:.0f} of {diagnostics.draws} draws effective, "
        f"{diagnostics.simulations} simulations, {diagnostics.harmonics} harmonics compared, "
        f"ln evidence {diagnostics.log_evidence:.2f} ± {diagnostics.log_evidence_error:.2f}"
    )
    for note in result.findings:
        print_text(f"note: {sentence(note)}{_below(note)}")
