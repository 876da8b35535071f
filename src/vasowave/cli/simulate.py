"""Commands on one model: simulate, sweep."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vasowave.cli import models
from vasowave.cli.app import app

if TYPE_CHECKING:
    import xarray as xr


_NAMES = (
    "Names: the wall law's (beta; p1, gamma; beta, m), in mmHg and plain numbers; of the vascular beds R_T "
    "\\[mmHg s/ml], a = R1/R_T, tau \\[s]; radius and length: factors of all vessels."
)


@app.command(
    epilog=f"{_NAMES} Example: vasowave simulate network.csv cycle.csv --wall power --set beta=60 --set m=2; "
    "vasowave simulate my-mouse --set R_T=120"
)
def simulate(
    network: Annotated[Path, models.NETWORK],
    recording: Annotated[list[Path] | None, models.RECORDING] = None,
    output: Annotated[Path, typer.Option("--output", "-o", help="netCDF file to write.")] = Path("waveforms.nc"),
    period: Annotated[float | None, models.PERIOD] = None,
    animal: Annotated[str, models.ANIMAL] = "",
    wall: Annotated[str, models.WALL] = "",
    values: Annotated[list[str] | None, typer.Option("--set", metavar="NAME=VALUE", help="Another value.")] = None,
    friction: Annotated[str, models.FRICTION] = "",
    cell_size: Annotated[float | None, models.CELL] = None,
    accuracy: Annotated[float | None, models.ACCURACY] = None,
) -> None:
    """Simulate a network with nominal, given or fitted parameters and write the waveforms of every vessel."""
    from vasowave import solver
    from vasowave.files import check_file

    check_file(output)
    model, cycle = models.model_from(network, recording or [], period, animal, wall, friction)
    model = solver.changed_model(model, _pairs(values or []))
    result = solver.simulate(model, cycle, models.numerics_from(cell_size, accuracy))
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
    network: Annotated[Path, models.NETWORK],
    recording: Annotated[list[Path] | None, models.RECORDING] = None,
    vary: Annotated[
        list[str] | None, typer.Option(metavar="NAME=VALUES", help="from:to:count, or one,other; may be repeated.")
    ] = None,
    output: Annotated[Path, typer.Option("--output", "-o", help="netCDF file to write.")] = Path("sweep.nc"),
    period: Annotated[float | None, models.PERIOD] = None,
    animal: Annotated[str, models.ANIMAL] = "",
    wall: Annotated[str, models.WALL] = "",
    friction: Annotated[str, models.FRICTION] = "",
    cell_size: Annotated[float | None, models.CELL] = None,
    accuracy: Annotated[float | None, models.ACCURACY] = None,
) -> None:
    """Simulate every combination of parameter values; keeps the root's pressure and what each vessel has of it."""
    from rich.progress import Progress

    from vasowave import solver
    from vasowave.files import check_file

    check_file(output)
    model, cycle = models.model_from(network, recording or [], period, animal, wall, friction)
    grid = {name: _numbers(name, text) for name, text in _split(vary or [])}
    with Progress(transient=True) as bars:
        task = bars.add_task("simulations", total=None)
        numerics = models.numerics_from(cell_size, accuracy)
        result = solver.sweep(model, cycle, grid, numerics, progress=lambda done, count: bars.update(
            task, completed=done, total=count))  # fmt: skip
    _write(result, output)
    failed = int((result["failure"] != "").sum())
    typer.echo(f"{result['failure'].size} simulations, {failed} failed (variable 'failure' says why). Sweep: {output}")


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
