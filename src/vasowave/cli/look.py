"""The command for the first look at an image."""

from pathlib import Path
from typing import Annotated, Any, cast

import typer

from vasowave.cli.app import app


@app.command(
    epilog="Example: vasowave look scan-folder -o look.html. Then type the command that it ends with.",
)
def look(
    volume: Annotated[Path, typer.Argument(help="DICOM folder, NRRD, NIfTI, MetaImage, RAW with header, TIFF stack.")],
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Page (.html) or .json.")] = None,
    threshold: Annotated[float | None, typer.Option(help="Grey level of the vessel wall; else proposed.")] = None,
    cannula: Annotated[
        float, typer.Option(help="Known inner diameter of the cannula, cm; 0 where there is none.")
    ] = 0.086,
    species: Annotated[str, typer.Option(help="Passed on to `extract`: mouse, rat, human, other …")] = "mouse",
    voxel: Annotated[float | None, typer.Option(help="Voxel size, cm, in place of the file's.")] = None,
) -> None:
    """Look at a volume before anything is measured: grey levels, ends, loops, and the command to type next."""
    from vasowave.imaging.overview import look as looked
    from vasowave.report.look import check_look_file, look_text, write_look

    if output is not None:
        check_look_file(output)
    seen = looked(volume, threshold, cannula=cannula, species=cast(Any, species), voxel=voxel)
    typer.echo(look_text(seen))
    if output is not None:
        typer.echo(f"Look at it: {write_look(seen, output)}")
