"""Commands from images to networks: extract, match."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, cast

import typer

from vasowave.cli.app import app

if TYPE_CHECKING:
    import numpy as np

    from vasowave.network import Network

_PLACE = "x,y,z in the image's coordinates, cm (or with a unit: '9.1 12 4.5 mm')"


@app.command(
    epilog="Example: vasowave extract scan-folder -o mouse-6 --root 0.91,1.2,0.05 --outlets outlets.csv. "
    "Then open mouse-6/review.html, correct with --outlets, --edits or --mask, and run again."
)
def extract(
    volume: Annotated[Path, typer.Argument(help="DICOM folder, NRRD, NIfTI, MetaImage, RAW with header, TIFF stack.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the results.")],
    root: Annotated[str | None, typer.Option(help=f"Where the blood enters: {_PLACE}.")] = None,
    seed: Annotated[str | None, typer.Option(help="A point inside the tree, if the root is not.")] = None,
    outlet: Annotated[list[str] | None, typer.Option(help="Guided mode: an outlet, x,y,z; repeat it.")] = None,
    outlets: Annotated[Path | None, typer.Option(help="Guided mode: CSV with x \\[cm], y \\[cm], z \\[cm].")] = None,
    threshold: Annotated[float, typer.Option(help="Grey level of the vessel wall.")] = 45.0,
    method: Annotated[str, typer.Option(help="threshold, or level-set (active contour).")] = "threshold",
    mask: Annotated[Path | None, typer.Option(help="Edited mask; labels: 1 lumen, 2 root, 3… outlets.")] = None,
    region: Annotated[str | None, typer.Option(help="Mask file, or box x,y,z:x,y,z; outside is no lumen.")] = None,
    edits: Annotated[Path | None, typer.Option(help="Corrections: remove, cut, merge, root, one a line.")] = None,
    voxel: Annotated[float | None, typer.Option(help="Voxel size in cm, in place of the file's.")] = None,
    cannula: Annotated[float, typer.Option(help="Inner diameter of the cannula, cm (PE-90: 0.086); 0: none.")] = 0.086,
    scale: Annotated[str, typer.Option(help="Lengths follow the 'file' or the 'cannula'.")] = "file",
    loops: Annotated[str, typer.Option(help="'open' loops of the lumen with a warning, or 'refuse' them.")] = "open",
    generations: Annotated[int | None, typer.Option(help="Keep the first so many generations.")] = None,
    vessels: Annotated[int | None, typer.Option(help="Keep the largest so many vessels.")] = None,
    min_radius: Annotated[float | None, typer.Option(help="Keep the vessels above this radius, cm.")] = None,
) -> None:
    """Turn a volume into a checked vessel network, with everything needed to review and correct it."""
    from vasowave.imaging.places import parse_place
    from vasowave.imaging.request import Request, answer
    from vasowave.report.extraction import check_extraction_folder, write_answer

    check_extraction_folder(output)
    request = Request(
        image=volume,
        root=None if root is None else parse_place(root).tolist(),
        seed=None if seed is None else parse_place(seed).tolist(),
        outlets=_outlets(outlet or [], outlets),
        threshold=threshold,
        method=cast(Literal["threshold", "level-set"], method),
        mask=mask,
        edits=edits,
        region=_region(region),
        voxel=voxel,
        cannula_radius=cannula / 2 if cannula else None,
        scale=cast(Literal["file", "cannula"], scale),
        loops=cast(Literal["open", "refuse"], loops),
        generations=generations,
        vessels=vessels,
        min_radius=min_radius,
    )
    with _stages() as say:
        found = answer(request, say)
        say("results")
        page = write_answer(found, output)
    typer.echo(repr(found.extraction.network))
    typer.echo(f"Look at it: {page}; then: vasowave fit {output / 'network.csv'} RECORDING")


@app.command(
    epilog="Example: vasowave centerlines lung.vtp -o lung --unit mm --vessels 21. "
    "Then: vasowave fit lung/network.csv recording.csv"
)
def centerlines(
    lines: Annotated[Path, typer.Argument(help="Centerlines of VMTK or Slicer (.vtp, .vtk, .dat, .csv), or .swc.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the network.")],
    unit: Annotated[str, typer.Option(help="Unit of length in the file: mm, cm, um, or its size in cm: 0.00427.")],
    cut: Annotated[str, typer.Option(help="Lines part at a 'tube' of half the radius or where 'identical'.")] = "tube",
    collapse: Annotated[float, typer.Option(help="Inner vessels shorter than this, in radii, become junctions.")] = 0.0,
    generations: Annotated[int | None, typer.Option(help="Keep the first so many generations.")] = None,
    vessels: Annotated[int | None, typer.Option(help="Keep the largest so many vessels.")] = None,
    min_radius: Annotated[float | None, typer.Option(help="Keep the vessels above this radius, cm.")] = None,
) -> None:
    """Turn the centerlines of another program into a vessel network, for ParaView and the authors' tables too."""
    from vasowave.errors import InputError
    from vasowave.imaging.exchange import as_extraction, read_centerlines
    from vasowave.imaging.subtrees import check_wishes, wanted_part
    from vasowave.report.centerlines import check_centerlines_folder, write_centerline_network

    check_wishes(generations, vessels, min_radius)
    if cut not in ("tube", "identical"):
        raise InputError(f"cut '{cut}'; lines part where they enter a 'tube' or where they are 'identical'")
    check_centerlines_folder(output)
    size = _length_unit(unit)
    tree = read_centerlines(lines, size, cast(Literal["tube", "identical"], cut), collapse)
    found = wanted_part(as_extraction(tree), generations, vessels, min_radius)
    settings: dict[str, str | float] = {
        "unit [cm]": size,
        "cut": cut,
        "collapse": collapse,
        "vessels in the file": len(tree.lines),
    }
    write_centerline_network(found, lines, settings, output)
    typer.echo(repr(found.network))
    typer.echo(
        f"Look at it: {output / 'figures' / 'network.png'}; then: vasowave fit {output / 'network.csv'} RECORDING"
    )


@app.command(epilog="Example: vasowave match control/network.csv hypertensive/network.csv -o matched.csv")
def match(
    first: Annotated[Path, typer.Argument(help="Vessel table, CSV.")],
    second: Annotated[Path, typer.Argument(help="Vessel table, CSV.")],
    output: Annotated[Path | None, typer.Option("--output", "-o", help="CSV of the pairs.")] = None,
) -> None:
    """Pair the vessels of two networks one to one, by topology and size, and list those left over."""
    from vasowave.files import check_file, write_file
    from vasowave.imaging import matching
    from vasowave.network import read_network

    if output is not None:
        check_file(output)
    one, other = read_network(first), read_network(second)
    pairs = matching.match(one, other)
    lines = _pair_lines(one, other, pairs)
    if output is None:
        typer.echo("\n".join(lines))
    else:
        write_file(output, "\n".join(lines) + "\n")
    for path, left in zip((first, second), matching.unmatched(one, other, pairs), strict=True):
        typer.echo(f"{path}: {len(left)} vessels without counterpart{': ' if left else ''}{', '.join(left)}", err=True)


def _pair_lines(one: "Network", other: "Network", pairs: dict[int, int]) -> list[str]:
    lines = ["first,second,length_first [cm],length_second [cm],radius_first [cm],radius_second [cm]"]
    for row, same in sorted(pairs.items()):
        sizes = (one.length[row], other.length[same], one.radius[row], other.radius[same])
        lines.append(",".join([one.name[row], other.name[same], *(repr(float(size)) for size in sizes)]))
    return lines


def _outlets(places: list[str], file: Path | None) -> "np.ndarray | None":
    import numpy as np

    from vasowave.errors import InputError
    from vasowave.imaging.places import parse_place, read_places

    if places and file is not None:
        raise InputError("give the outlets either one by one or as a file")
    if file is not None:
        return read_places(file)
    return np.array([parse_place(text) for text in places]) if places else None


def _length_unit(text: str) -> float:
    """Return a unit of length, or a number of cm, in cm."""
    from vasowave.units import factor

    try:
        return float(text)
    except ValueError:
        return factor(text, "length")


def _region(text: str | None) -> "Path | tuple[np.ndarray, np.ndarray] | None":
    from vasowave.errors import InputError
    from vasowave.imaging.places import parse_place

    if text is None or Path(text).exists():
        return None if text is None else Path(text)
    corners = text.split(":")
    if len(corners) != 2:
        raise InputError(f"region '{text}': no such file, and no box x,y,z:x,y,z")
    return parse_place(corners[0]), parse_place(corners[1])


@contextmanager
def _stages() -> Iterator[Callable[[str], None]]:
    """Give a function that names the stage that begins; a terminal shows how long each has taken."""
    from rich.console import Console
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda stage: typer.echo(f"{stage} …", err=True)
        return
    with Progress(SpinnerColumn(finished_text="✓"), TextColumn("{task.description}"), TimeElapsedColumn(),
                  console=console) as progress:  # fmt: skip

        def say(stage: str) -> None:
            for task in progress.tasks:
                progress.update(task.id, total=1, completed=1)
            progress.add_task(stage, total=None)

        yield say
        for task in progress.tasks:
            progress.update(task.id, total=1, completed=1)
