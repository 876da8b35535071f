"""Commands on one model: simulate, sweep."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vasowave.cli.app import app

if TYPE_CHECKING:
    import xarray as xr

    from vasowave.model import Model
    from vasowave.recording import Recording
    from vasowave.solver import Numerics

_NETWORK = typer.Argument(help="Vessel table, CSV; or, alone, the folder of a fit or a study: its fitted model.")
_RECORDING = typer.Argument(help="One averaged cycle; its flow is the inflow. Not with the folder of a fit.")
_PERIOD = typer.Option(help="Period of the cycle in seconds, for recordings without a time column.")
_ANIMAL = typer.Option(help="Animal of a study.")
_WALL = typer.Option(help="Wall law: linear, tangent, power, or module:Class; of a fit, the first that was fitted.")
_FRICTION = typer.Option(help="boundary-layer (the paper's eq. 2), poiseuille, or power-law; of a fit, its own.")
_CELL = typer.Option(help="Longest cell, cm.")
_ACCURACY = typer.Option(help="Largest numerical error of the pressure, mmHg: cells and steps are chosen from it.")
_NAMES = (
    "Names: the wall law's (beta; p1, gamma; beta, m), in mmHg and plain numbers; of the vascular beds R_T "
    "\\[mmHg s/ml], a = R1/R_T, tau \\[s]; radius and length: factors of all vessels."
)


@app.command(
    epilog=f"{_NAMES} Example: vasowave simulate network.csv cycle.csv --wall power --set beta=60 --set m=2; "
    "vasowave simulate my-mouse --set R_T=120"
)
def simulate(
    network: Annotated[Path, _NETWORK],
    recording: Annotated[list[Path] | None, _RECORDING] = None,
    output: Annotated[Path, typer.Option("--output", "-o", help="netCDF file to write.")] = Path("waveforms.nc"),
    period: Annotated[float | None, _PERIOD] = None,
    animal: Annotated[str, _ANIMAL] = "",
    wall: Annotated[str, _WALL] = "",
    values: Annotated[list[str] | None, typer.Option("--set", metavar="NAME=VALUE", help="Another value.")] = None,
    friction: Annotated[str, _FRICTION] = "",
    cell_size: Annotated[float | None, _CELL] = None,
    accuracy: Annotated[float | None, _ACCURACY] = None,
) -> None:
    """Simulate a network with nominal, given or fitted parameters and write the waveforms of every vessel."""
    from vasowave import solver
    from vasowave.files import check_file

    check_file(output)
    model, cycle = _model(network, recording or [], period, animal, wall, friction)
    model = solver.changed_model(model, _pairs(values or []))
    result = solver.simulate(model, cycle, _numerics(cell_size, accuracy))
    _write(result, output)
    pressure = result["pressure"].values[:, model.network.root, 0]
    typer.echo(repr(model))
    typer.echo(
        f"Periodic after {result.attrs['cycles']} cycles (change {result.attrs['change']:.1g} mmHg, "
        f"Courant number {result.attrs['courant']:.2f}); pressure at the root {pressure.min():.1f} to "
        f"{pressure.max():.1f} mmHg, mean {pressure.mean():.1f}. Waveforms: {output}"
    )


@app.command(
    epilog=f"{_NAMES} Example: vasowave sweep network.csv cycle.csv --vary beta=30:90:7 --vary R_T=60,80; "
    "vasowave sweep my-mouse --vary tau=0.05:0.3:20"
)
def sweep(
    network: Annotated[Path, _NETWORK],
    recording: Annotated[list[Path] | None, _RECORDING] = None,
    vary: Annotated[
        list[str] | None, typer.Option(metavar="NAME=VALUES", help="from:to:count, or one,other; may be repeated.")
    ] = None,
    output: Annotated[Path, typer.Option("--output", "-o", help="netCDF file to write.")] = Path("sweep.nc"),
    period: Annotated[float | None, _PERIOD] = None,
    animal: Annotated[str, _ANIMAL] = "",
    wall: Annotated[str, _WALL] = "",
    friction: Annotated[str, _FRICTION] = "",
    cell_size: Annotated[float | None, _CELL] = None,
    accuracy: Annotated[float | None, _ACCURACY] = None,
) -> None:
    """Simulate every combination of parameter values; keeps the root's pressure and what each vessel has of it."""
    from rich.progress import Progress

    from vasowave import solver
    from vasowave.files import check_file

    check_file(output)
    model, cycle = _model(network, recording or [], period, animal, wall, friction)
    grid = {name: _numbers(name, text) for name, text in _split(vary or [])}
    with Progress(transient=True) as bars:
        task = bars.add_task("simulations", total=None)
        numerics = _numerics(cell_size, accuracy)
        result = solver.sweep(model, cycle, grid, numerics, progress=lambda done, count: bars.update(
            task, completed=done, total=count))  # fmt: skip
    _write(result, output)
    failed = int((result["failure"] != "").sum())
    typer.echo(f"{result['failure'].size} simulations, {failed} failed (variable 'failure' says why). Sweep: {output}")


def _model(
    network: Path, recording: Sequence[Path], period: float | None, animal: str, wall: str, friction: str
) -> "tuple[Model, Recording]":
    """Return the nominal model of a network and a cycle, or the fitted one of a folder, and the cycle."""
    from vasowave.blood import FRICTIONS, Blood
    from vasowave.errors import InputError, did_you_mean

    if friction and friction not in FRICTIONS:
        hint = did_you_mean(friction, FRICTIONS)
        raise InputError(f"unknown friction '{friction}'{hint}; there are: {', '.join(FRICTIONS)}")
    blood = Blood(friction=FRICTIONS[friction]()) if friction else None
    if network.is_dir():
        if recording:
            raise InputError(f"{network} is the folder of a fit, which has its own recording; leave the others out")
        model, cycle = _fitted(network, animal, wall)
        return (model.changed(blood=blood) if blood else model), cycle
    return _nominal(network, recording, period, wall, blood or Blood())


def _fitted(folder: Path, animal: str, wall: str) -> "tuple[Model, Recording]":
    from vasowave.animal.stored import stored_model, stored_recording
    from vasowave.errors import InputError
    from vasowave.study.results import read_results

    results = read_results(folder)
    if not animal and len(results) > 1:
        raise InputError(f"{folder}: name one of its animals with --animal: {', '.join(results)}")
    name = animal or next(iter(results))
    if name not in list(results):
        raise InputError(f"{folder}: no animal '{name}'; there are: {', '.join(results)}")
    result = results[name]
    return stored_model(result, wall), stored_recording(result)


def _nominal(network: Path, recording: Sequence[Path], period: float | None, wall: str, blood: object
             ) -> "tuple[Model, Recording]":  # fmt: skip
    from vasowave.errors import InputError
    from vasowave.laws import find_law
    from vasowave.model import Model
    from vasowave.nominal import estimate_nominal
    from vasowave.recording import read_recording
    from vasowave.vessel_table import read_network

    if not recording:
        raise InputError(f"{network}: a network needs the recording of a cycle too, whose flow enters it")
    vessels, cycle = read_network(network), read_recording(*recording, period=period)
    nominal = estimate_nominal(vessels, cycle, blood)  # type: ignore[arg-type]
    return Model(vessels, nominal.wall(find_law(wall or "linear")), nominal.outlets, blood), cycle  # type: ignore[arg-type]


def _numerics(cell_size: float | None, accuracy: float | None) -> "Numerics":
    from vasowave.solver import Numerics

    given = {"cell_size": cell_size, "accuracy": accuracy}
    return Numerics(**{name: value for name, value in given.items() if value is not None})  # type: ignore[arg-type]


def _split(texts: Sequence[str]) -> list[tuple[str, str]]:
    from vasowave.errors import InputError

    wrong = next((text for text in texts if "=" not in text), None)
    if wrong is not None:
        raise InputError(f"'{wrong}': write NAME=VALUE, for example beta=60")
    return [(name.strip(), value.strip()) for name, _, value in (text.partition("=") for text in texts)]


def _pairs(texts: Sequence[str]) -> dict[str, float]:
    return {name: _numbers(name, text)[0] for name, text in _split(texts)}


def _numbers(name: str, text: str) -> list[float]:
    """Return the numbers in ``from:to:count`` or ``one,other``."""
    import numpy as np

    from vasowave.errors import InputError

    try:
        if ":" in text:
            low, high, count = text.split(":")
            return np.linspace(float(low), float(high), int(count)).tolist()
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise InputError(f"{name}={text}: write one number, one,other or from:to:count") from None


def _write(result: "xr.Dataset", output: Path) -> None:
    import xarray as xr

    from vasowave.animal.files import to_bytes
    from vasowave.files import write_file

    write_file(output, to_bytes(xr.DataTree(result)))
