"""The command that writes a model for another program: export."""

from pathlib import Path
from typing import Annotated

import typer

from vasowave.cli import models
from vasowave.cli.app import app

_TO = typer.Option("--to", help="paraview, matlab, openbf, svzerod, or tables (CSV).")
_OUTPUT = typer.Option("--output", "-o", help="Folder to write into.")


@app.command(
    epilog="Example: vasowave export my-mouse --to paraview -o my-mouse-waves; "
    "vasowave export network.csv cycle.csv --to openbf; vasowave export openbf.yaml --to tables"
)
def export(
    network: Annotated[Path, models.NETWORK],
    recording: Annotated[list[Path] | None, models.RECORDING] = None,
    program: Annotated[str, _TO] = "paraview",
    output: Annotated[Path, _OUTPUT] = Path("vasowave-export"),
    centerlines: Annotated[
        Path | None, typer.Option(help="centerlines.csv of the extraction, for ParaView; without it, a flat tree.")
    ] = None,
    period: Annotated[float | None, models.PERIOD] = None,
    animal: Annotated[str, models.ANIMAL] = "",
    wall: Annotated[str, models.WALL] = "",
    bed: Annotated[str, models.BED] = "",
    narrow: Annotated[list[str] | None, models.NARROW] = None,
    friction: Annotated[str, models.FRICTION] = "",
    cell_size: Annotated[float | None, models.CELL] = None,
    accuracy: Annotated[float | None, models.ACCURACY] = None,
) -> None:
    """Write a model and its waves for ParaView, MATLAB, openBF or svZeroDSolver."""
    from vasowave.exchange import export_model

    model, flow = models.model_from(network, recording or [], period, animal, (wall, bed), friction)
    model, numerics = models.narrowed_model(model, narrow or []), models.numerics_from(cell_size, accuracy)
    said = export_model(model, flow, program, output, centerlines=centerlines, numerics=numerics)
    typer.echo(repr(model))
    for sentence in said:
        typer.echo(f"  {sentence}")
    typer.echo(f"Written: {output}")
