"""The commands on one animal: fit, indices, right-heart, posterior, loops."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import typer

import vasowave as vw
from vasowave.base import io
from vasowave.base.errors import InputError
from vasowave.base.findings import Finding, sentence
from vasowave.base.runtime.interrupts import interruptible
from vasowave.cli import models
from vasowave.cli.app import FAILED, app
from vasowave.cli.cures import Shell, code_of
from vasowave.cli.progress import alive, print_table, print_text
from vasowave.cli.signatures import with_option_groups
from vasowave.pulse import model as laws
from vasowave.study import animal as animals
from vasowave.study import figures, results, running
from vasowave.study import folder as folders

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

    name, options = animal or folders.plain_name(recording[0].stem), dict(setting_values or {})
    cells = row_cells(options)
    settings = read_settings(options, name, group)
    _fit(running.animal_alone(output, settings, network, recording, name, cells))


@app.command(epilog="Example: vasowave indices recording.txt -o beats.csv. No vessels are needed.")
def indices(
    recording: Annotated[list[Path], typer.Argument(help="One file, or pressure and flow.")],
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Table of all beats, .csv.")] = None,
    setting_values: Annotated[Any, typer.Option(hidden=True, parser=str)] = None,
) -> None:
    """Say what a recording alone tells: pressures, ejection, slopes, notch, load, power; and how its beats scatter."""
    from vasowave.cli.options import read_settings, row_cells

    name, options = folders.plain_name(recording[0].stem), dict(setting_values or {})
    models.check_files((output, ".csv"))
    row = running.one_row(None, recording, name, name, row_cells(options))
    cycle, average = results.load_recording(row, read_settings(options, name, name))
    print_text(animals.indices_text(cycle, average))
    behind = [] if row.wedge is not None or row.wedge_wave else [animals.NO_WEDGE()]
    for note in (*cycle.notes, *behind):
        print_text(f"note: {sentence(note)}{_below(note)}", err=True)
    if output is not None and average is not None:
        typer.echo(f"Beats: {animals.write_beats(cycle, average, output)}")
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
    for animal in vw.read_right_heart(numbers):
        print_text(str(animal))


def _fit(study: "folders.Study") -> None:
    from vasowave.cli.watching import watched

    with interruptible(), running.nothing_left(study.folder), running.running(study.folder, 1) as run:
        with watched(study, as_json=False):
            done = running.run_alone(run, study)
        _say_fit(done, study)
        run.write(stage="writing the report")
        with alive("writing the report"):
            page = running.report_study(study.folder)
    typer.echo(f"Report: {page}")
    for failure in done.failures:
        print_text(f"failed: {failure}", err=True)
    raise typer.Exit(FAILED if done.failures else 0)


def _say_fit(done: "running.Done", study: "folders.Study") -> None:
    typer.echo(f"Results: {done.results}{'' if done.computed else ' (kept from earlier)'}")
    (result,) = vw.read_results(study.folder).in_order()
    for text in running.fit_sentences(result, done.warnings.get(result.name, ()), _below):
        typer.echo(f"  {text}")


def _below(finding: Finding) -> str:
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
    io.check_file(output, models.DATA)
    models.trust_programs(network, trust)
    inputs = _fit_inputs(network, recording or [], choice, dict(setting_values or {}))
    (name, law), vessels, cycle, sites, settings = inputs
    made = [0]
    typer.echo(f"Posterior under the {name} wall. The first simulation compiles the solver.")

    def count(simulations: int) -> None:
        made[0] = simulations

    with alive(lambda: f"posterior, {name} wall: {made[0]} simulations"):
        result = vw.posterior(
            vessels, cycle, law, sites=sites, bed=settings.beds, priors=settings.priors, blood=settings.blood,
            search=settings.search(law), numerics=settings.numerics, draws=draws, seed=settings.seed, progress=count,
        )  # fmt: skip
    result.to_netcdf(output)
    _print_posterior(result)
    typer.echo(f"Draws: {output}")
    raise typer.Exit(0 if result.diagnostics.trusted else FAILED)


def _fit_inputs(
    network: Path, recording: list[Path], choice: LawChoice, options: dict[str, Any]
) -> "tuple[tuple[str, Any], vw.Network, vw.Recording, tuple[vw.Observation, ...], vw.Settings]":
    """Return the law (name, class), vessels, cycle, sites, settings: of files and options, or all of a fit's folder."""
    from vasowave.cli.options import flag, read_settings, row_cells
    from vasowave.study.animal import stored

    if network.is_dir():
        if recording or options or choice.bed:
            surplus = ", ".join([*map(str, recording), *map(flag, options), *(["--bed"] if choice.bed else [])])
            raise InputError(f"{network} brings recording and settings along; leave out {surplus}")
        result = models.stored_animal(network, choice.animal)
        sites, measured = stored.stored_sites(result), (result.network, stored.stored_recording(result))
        return stored.stored_law(result, choice.wall), *measured, sites, stored.stored_settings(result)
    cells = row_cells(options)
    settings = read_settings(options, "posterior", "animal")
    loaded, chosen = models.animal_from(network, recording, cells, settings)
    chosen = replace(chosen, beds=choice.bed or chosen.beds)
    law = laws.find_law(choice.wall or chosen.walls[0])
    return (law.law().name, law), loaded.network, loaded.recording, loaded.sites, chosen


def _print_posterior(result: "vw.Posterior") -> None:
    """Print the table of a posterior, its diagnostics, and what a reader must know."""
    rows = [("", "median", "95 % interval", "prior 95 %", "unit")]
    rows += [
        (str(name), f"{row['median']:.4g}", f"[{row['interval_low']:.3g}, {row['interval_high']:.3g}]",
         f"[{row['prior_low']:.3g}, {row['prior_high']:.3g}]", str(row["unit"]).replace("1", "", row["unit"] == "1"))
        for name, row in result.summary.iterrows()
    ]  # fmt: skip
    print_table(rows, (0, 4))
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


_OF_LOOPS = dict.fromkeys(("channel", "unit"), ("pressure", "volume"))


@app.command(
    epilog="Example: vasowave loops occlusion.txt --unit volume=ul --alpha 0.8 -o loops.csv --plot loops.svg. Any "
    "recording is read: a table (time \\[s], LVP \\[mmHg], LVV \\[µl]), LabChart, MATLAB, EDF."
)
def loops(
    recording: Annotated[Path, typer.Argument(help="Pressure and volume of a ventricle, recorded together.")],
    volume: Annotated[Path | None, typer.Argument(help="The volume, if it is in another file.")] = None,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Table of the numbers, .csv.")] = None,
    beats: Annotated[Path | None, typer.Option(help="Table of all beats, .csv.")] = None,
    plot: Annotated[Path | None, typer.Option(help="Picture of the loops: .svg, .pdf or .png.")] = None,
    steady: Annotated[str, typer.Option(metavar="START:END", help="The steady state, s; by default found.")] = "",
    family: Annotated[str, typer.Option(metavar="START:END", help="The falling preload, s; by default found.")] = "",
    setting_values: Annotated[Any, typer.Option(hidden=True, parser=str)] = None,
) -> None:
    """Say what loops of pressure and volume tell of a ventricle: E_es, V_0, E_a, work, filling, relaxation."""
    from vasowave.cli.options import row_cells

    models.check_files((output, ".csv"), (beats, ".csv"), (plot, *models.PICTURES))
    stretches = (_stretch("steady", steady), _stretch("family", family))
    options = dict(setting_values or {})
    cells = row_cells(options, (), _OF_LOOPS)
    titled = {title.removesuffix(" channel").replace(" ", "_"): cell for title, cell in cells.items()}
    function = vw.pressure_volume(vw.read_loops(recording, volume, **options, **titled), *stretches)
    print_text(_loops_text(function))
    for finding in function.findings:
        print_text(f"note: {sentence(finding)}{code_of(finding)}{Shell().below(finding.cures)}", err=True)
    _save(function, output, beats, plot)


def _loops_text(function: "vw.VentricularFunction") -> str:
    """Return the table of the numbers as lines of text."""
    rows = [("", "value", "95 % interval", "unit", "beats", "")]
    rows += [
        (str(name), f"{row['value']:.4g}", f"[{row['low']:.4g}, {row['high']:.4g}]", str(row["unit"]),
         str(row["beats"]), str(row["meaning"]))
        for name, row in function.table.iterrows()
    ]  # fmt: skip
    head = f"{function.source}: {len(function.steady)} steady beats, {len(function.family)} of a family"
    return "\n".join([head, *results.aligned(rows, (0, 3, 5))])


def _save(function: "vw.VentricularFunction", output: Path | None, beats: Path | None, plot: Path | None) -> None:
    """Write what was asked for, and say where it is."""
    from vasowave.pulse.analysis.ventricular_function import VENTRICULAR

    titled = {name: f"{name} [{quantity.unit}]" for name, quantity in VENTRICULAR.items()}
    tables = (
        ("Numbers", output, lambda: function.table),
        ("Beats", beats, lambda: function.beats.rename(columns=titled)),
    )
    for words, path, table in tables:
        if path is not None:
            content = table().to_csv(float_format="%.8g", lineterminator="\n")
            typer.echo(f"{words}: {io.write_file(path, content)}")
    if plot is not None:
        typer.echo(f"Figure: {models.draw(lambda: figures.loops_figure(animals.loops_dataset(function)), plot)}")


def _stretch(option: str, text: str) -> tuple[float, float] | None:
    """Return two times, s."""
    if not text:
        return None
    start, _, end = text.partition(":")
    try:
        stretch = float(start), float(end)
    except ValueError:
        stretch = 0.0, 0.0
    if not stretch[0] < stretch[1]:
        raise InputError(f"--{option} {text}: write two times in s, the earlier first: --{option} 2:8.5")
    return stretch
