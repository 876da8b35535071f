"""Commands on one animal: fit, simulate."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vasowave.cli.app import app

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
    from vasowave.cli.options import read_settings
    from vasowave.study.alone import animal_alone

    settings = read_settings(given or {}, group)
    study = animal_alone(output, settings, network, recording, animal or recording[0].stem, period)
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
    (tree,) = read_results(study.folder).trees()
    for sentence in fit_sentences(tree):
        typer.echo(f"  {sentence}")
    typer.echo(f"Report: {report_study(study.folder)}")


@app.command(epilog="Example: vasowave simulate network.csv cycle.csv --beta 60 --output waveforms.nc")
def simulate(
    network: Annotated[Path, typer.Argument(help="Vessel table, CSV.")],
    recording: Annotated[list[Path], typer.Argument(help="One averaged cycle; its flow is the inflow.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="netCDF file to write.")] = Path("waveforms.nc"),
    period: Annotated[float | None, _PERIOD] = None,
    beta: Annotated[float | None, typer.Option(help="Stiffness of the linear wall, mmHg; default: nominal.")] = None,
    ratio: Annotated[float, typer.Option(help="a = R1/R_T of the vascular beds.")] = 0.2,
) -> None:
    """Simulate the network with nominal parameters (or a given stiffness) and write the waveforms of every vessel."""
    import xarray as xr

    from vasowave import solver
    from vasowave.animal.files import to_bytes
    from vasowave.errors import InputError
    from vasowave.files import check_file, write_file
    from vasowave.model import Model
    from vasowave.network import read_network
    from vasowave.nominal import estimate_nominal, windkessels
    from vasowave.recording import read_recording
    from vasowave.walls import LinearWall

    if not 0 < ratio < 1:
        raise InputError(f"--ratio {ratio:g} must lie between 0 and 1")
    check_file(output)
    vessels = read_network(network)
    cycle = read_recording(*recording, period=period)
    nominal = estimate_nominal(vessels, cycle)
    typer.echo(repr(nominal))
    outlets = windkessels(vessels, nominal.total_resistance, nominal.time_constant, ratio)
    result = solver.simulate(Model(vessels, LinearWall(nominal.beta if beta is None else beta), outlets), cycle)
    write_file(output, to_bytes(xr.DataTree(result)))
    pressure = result["pressure"].values[:, vessels.root, 0]
    typer.echo(
        f"Periodic after {result.attrs['cycles']} cycles (change {result.attrs['change']:.1g} mmHg, "
        f"Courant number {result.attrs['courant']:.2f}); pressure at the root {pressure.min():.1f} to "
        f"{pressure.max():.1f} mmHg, mean {pressure.mean():.1f}. Waveforms: {output}"
    )
