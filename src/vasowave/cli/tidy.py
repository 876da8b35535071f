"""The command that reads a network of any known format, repairs it, and writes the table of vessels."""

from pathlib import Path
from typing import Annotated

import typer

from vasowave.cli.app import app


@app.command(
    epilog="Example: vasowave tidy tree.mat --unit '0.0036 cm' -o network.csv; vasowave tidy network.csv -o tidied.csv"
)
def tidy(
    network: Annotated[
        Path,
        typer.Argument(
            help="Vessel table, MATLAB file (dim_mat, ves_conn), Dimensions.txt with connectivity.txt beside it, input "
            "of svOneDSolver, or FirstBlood's table of edges."
        ),
    ],
    output: Annotated[Path, typer.Option("--output", "-o", help="Vessel table to write.")] = Path("tidied.csv"),
    unit: Annotated[
        str | None, typer.Option(help="Unit of the lengths where the file does not say it: mm, or '0.0036 cm' a voxel.")
    ] = None,
    shortest: Annotated[
        float | None, typer.Option(help="Shortest vessel that is kept, in its own radii.", show_default="0.25", min=0.0)
    ] = None,
) -> None:
    """Repair a network: join what does not divide, merge what is too short for a wave; every repair is listed."""
    from vasowave.errors import InputError
    from vasowave.io.files import check_file
    from vasowave.network.tidying import SHORTEST, tidy
    from vasowave.network.vessel_table import write_network
    from vasowave.network_formats import read_network

    check_file(output)
    if output.exists() and output.samefile(network):
        raise InputError(f"{output}: would overwrite the network that is read; name another file with --output")
    found = tidy(read_network(network, unit), SHORTEST if shortest is None else shortest)
    write_network(found.network, output)
    for repair in found.repairs:
        typer.echo(f"{repair.code}: {repair}")
    typer.echo(f"{found.summary() or 'Nothing had to be repaired'}. {found.network!r}: {output}")
