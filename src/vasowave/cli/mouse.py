"""Commands on one mouse: fit, simulate."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vasowave.cli.app import app

if TYPE_CHECKING:
    from collections.abc import Sequence

    from vasowave.blood import Blood
    from vasowave.calibration import Fit, Search
    from vasowave.network import Network
    from vasowave.recording import Recording

_PERIOD = typer.Option(help="Period of the cycle in seconds, for recordings without a time column.")
_OUTPUT = typer.Option("--output", "-o", help="Folder for the results.")


@app.command(
    epilog="Example: vasowave fit network.csv pressure.dat flow.dat --period 0.11 --output mouse-6. "
    "The network has the columns name, parent, length \\[cm], radius \\[cm]; the recording "
    "time \\[s], pressure \\[mmHg], flow \\[ml/s], or two files of one column each."
)
def fit(
    network: Annotated[Path, typer.Argument(help="Vessel table, CSV.")],
    recording: Annotated[list[Path], typer.Argument(help="One averaged cycle: one table, or pressure and flow.")],
    output: Annotated[Path, _OUTPUT] = Path("vasowave-fit"),
    period: Annotated[float | None, _PERIOD] = None,
    wall: Annotated[str, typer.Option(help="linear, tangent or both.")] = "both",
    starts: Annotated[int, typer.Option(help="Number of starts of each fit.")] = 4,
    method: Annotated[str, typer.Option(help="least-squares, or sqp as in the paper.")] = "least-squares",
    paper_bounds: Annotated[bool, typer.Option(help="Use the paper's bounds.")] = False,
    hold: Annotated[list[str], typer.Option(help="Hold a parameter at a value, for example c1=1; repeatable.")] = [],  # noqa: B006
    bounds: Annotated[list[str], typer.Option(help="Own bounds, for example beta=20:90; repeatable.")] = [],  # noqa: B006
    friction: Annotated[
        str, typer.Option(help="local (eq. 2), fixed:RADIUS in cm as in the paper's fits, poiseuille, power-law:ZETA.")
    ] = "local",
    seed: Annotated[int, typer.Option(help="Seed of the other starts.")] = 0,
) -> None:
    """Calibrate the model to one recording and write results, figures and a report."""
    from vasowave.calibration import Search
    from vasowave.cli.options import read_bounds, read_friction, read_held, walls_named
    from vasowave.network import read_network
    from vasowave.recording import read_recording

    laws = walls_named(wall)
    plan = Search(starts, method, paper_bounds, read_bounds(bounds), read_held(hold), seed)
    blood = read_friction(friction)
    vessels = read_network(network)
    cycle = read_recording(*recording, period=period)
    _fit_and_report(vessels, cycle, output, laws, plan, [network, *recording], blood)


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


def _fit_and_report(
    network: "Network",
    recording: "Recording",
    output: Path,
    laws: "Sequence[str]",
    plan: "Search",
    inputs: "Sequence[Path]" = (),
    blood: "Blood | None" = None,
) -> None:
    from vasowave.calibration import calibrate
    from vasowave.cli.progress import counting
    from vasowave.report import write_report
    from vasowave.results import check_folder, write_results

    check_folder(output)
    typer.echo(repr(recording))
    typer.echo("The first fit with a wall law compiles the solver, which takes half a minute once.")
    fits: list[Fit] = []
    try:
        for law in laws:
            with counting(f"{law} wall, starts", plan.starts) as show:
                fits.append(
                    calibrate(
                        network, recording, law, blood=blood, search=_of_wall(plan, law, laws),
                        progress=lambda done, _, best: show(done, f"best S {best:.4g} mmHg²"),
                    )
                )  # fmt: skip
            typer.echo(f"  {fits[-1]!r}")
    except KeyboardInterrupt:
        if not fits:
            raise
        typer.echo("Interrupted: the report holds what had finished.")
    write_results(fits, output, inputs)
    page = write_report(fits, output, inputs)
    for note in recording.notes:
        typer.echo(f"  note: {note}")
    for one in fits:
        for note in one.warnings:
            if note not in recording.notes:
                typer.echo(f"  note ({one.wall}): {note}")
    typer.echo(f"Report: {page}")


def _of_wall(plan: "Search", law: str, laws: "Sequence[str]") -> "Search":
    from dataclasses import replace

    from vasowave.cli.options import for_wall

    return replace(plan, bounds=for_wall(law, laws, plan.bounds), fixed=for_wall(law, laws, plan.fixed))
