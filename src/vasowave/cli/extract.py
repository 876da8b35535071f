"""Commands from images and other files to networks: look, extract, centerlines, match, tidy."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from shlex import quote
from typing import Annotated, Any, cast

import typer

import vasowave as vw
from vasowave.base import io
from vasowave.base.errors import InputError
from vasowave.base.species import SPECIES, known_species
from vasowave.base.units import factor
from vasowave.cli.app import app
from vasowave.cli.signatures import with_option_groups
from vasowave.study import folder as folders
from vasowave.study import report as reports

_VOLUME = "Folder (DICOM, slices as pictures), or a file: NRRD, NIfTI, MetaImage, TIFF, isq, vff, am, vol …"


@app.command(epilog="Example: vasowave look scan-folder -o look.html. Then type the command that it ends with.")
def look(
    volume: Annotated[Path, typer.Argument(help=_VOLUME)],
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Page (.html) or .json.")] = None,
    threshold: Annotated[float | None, typer.Option(help="Grey level of the vessel wall; else proposed.")] = None,
    cannula: Annotated[
        float, typer.Option(help="Known inner diameter of the cannula, cm; 0 where there is none.")
    ] = 0.086,
    species: Annotated[str, typer.Option(help="Passed on to `extract`: mouse, rat, human, other …")] = "mouse",
    voxel: Annotated[
        str | None, typer.Option(help="Voxel size, cm, in place of the file's: one number, or x,y,z.")
    ] = None,
) -> None:
    """Look at a volume before anything is measured: grey levels, ends, loops, and the command to type next."""
    from vasowave.lung.places import parse_voxel

    if output is not None:
        reports.check_look_file(output)
    size = None if voxel is None else parse_voxel(voxel)
    overview = vw.look(volume, threshold, cannula=cannula, species=cast(Any, species), voxel=size)
    typer.echo(reports.look_text(overview))
    if output is not None:
        typer.echo(f"Look at it: {reports.write_look(overview, output)}")


@app.command(
    epilog="Example: vasowave extract scan-folder -o mouse-6 --root 0.91,1.2,0.05 --outlets outlets.csv. "
    "Then open mouse-6/review.html, keep corrections in mouse-6/edits.txt (or --outlets, --mask), and run again."
)
def extract(
    volume: Annotated[Path, typer.Argument(help=_VOLUME)],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the results.")],
    keep: Annotated[bool, typer.Option(help="Keep stages in OUTPUT/stages: repeating after an edit is quick.")] = True,
    setting_values: Annotated[Any, typer.Option(hidden=True, parser=str)] = None,
) -> None:
    """Turn a volume into a checked vessel network, with everything needed to review and correct it."""
    from vasowave.lung.kept.stages import Stages, forget_stages
    from vasowave.lung.options import Options
    from vasowave.lung.revise.edits import with_edits_in

    reports.check_extraction_folder(output)
    options = with_edits_in(output, Options(**setting_values or {}))
    stages = Stages(output if keep else None)
    with _stages() as report:
        extraction = vw.extract(volume, options, report, stages)
        report("results")
        with io.alone_in(folders.home_of(output)):
            page = reports.write_extraction(extraction, output)
            stages.save()
    if not keep:
        forget_stages(output)
    typer.echo(repr(extraction.network))
    typer.echo(f"Look at it: {page}; then: vasowave fit {quote(str(output / 'network.csv'))} RECORDING")


@dataclass(frozen=True)
class LineReading:
    """How centerlines of another program are read."""

    unit: Annotated[str, typer.Option(help="Unit of length in the file: mm, cm, um, or its size in cm: 0.00427.")]
    surface: Annotated[Path | None, typer.Option(help="The surface the lines were drawn in: .stl, .vtp, .vtk.")] = None
    cut: Annotated[
        str, typer.Option(help="Vessels meet where 'axes' do, as in extract, or part at a 'tube' or where 'identical'.")
    ] = "axes"
    ends: Annotated[
        str,
        typer.Option(help="Lines end a 'ball' before the wall (VMTK, Slicer) or at the 'wall'; auto: by their look."),
    ] = "auto"
    collapse: Annotated[float, typer.Option(help="Inner vessels shorter than this, in radii, become junctions.")] = 0.6

    def check(self) -> None:
        """Refuse a cut or an end that there is not."""
        cut, ends = self.cut, self.ends
        if cut not in ("axes", "tube", "identical"):
            raise InputError(f"cut '{cut}'; vessels meet where 'axes' do, or part at a 'tube' or where 'identical'")
        if ends not in ("auto", "ball", "wall"):
            raise InputError(f"ends '{ends}'; lines end a 'ball' before the wall or at the 'wall', or 'auto'")


@dataclass(frozen=True)
class PartLimits:
    """Which part of a network is wanted; everything by default."""

    generations: Annotated[int | None, typer.Option(help="Keep the first so many generations.")] = None
    vessels: Annotated[int | None, typer.Option(help="Keep the largest so many vessels.")] = None
    min_radius: Annotated[float | None, typer.Option(help="Keep the vessels above this radius, cm.")] = None


@app.command(
    epilog="Example: vasowave centerlines lung.vtp -o lung --unit mm --surface lung.stl --vessels 21. "
    "Then: vasowave fit lung/network.csv recording.csv"
)
@with_option_groups
def centerlines(
    lines: Annotated[Path, typer.Argument(help="Centerlines: .vtp, .vtk, .dat, .csv, .swc, .tre or .mrk.json.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the network.")],
    reading: LineReading,
    limits: PartLimits,
    pressure: Annotated[float, typer.Option(help="Pressure at which the vessels were imaged, mmHg; 0: unknown.")] = 0.0,
    species: Annotated[
        str, typer.Option(help=f"Whose root the unit is checked by: {', '.join(SPECIES)}, other.")
    ] = "mouse",
) -> None:
    """Turn the centerlines of another program into a vessel network, for ParaView and the authors' tables too."""
    from vasowave.lung.exchange.centerlines import measured_lines
    from vasowave.lung.measure.measurement import filled_at
    from vasowave.lung.options import check_wishes
    from vasowave.lung.revise.parts import wanted_part
    from vasowave.pulse.network.remarks import unlike_the_species

    wanted = (limits.generations, limits.vessels, limits.min_radius)
    check_wishes(*wanted)
    reading.check()
    known_species(species)
    surface, cut, ends = reading.surface, reading.cut, reading.ends
    if surface is not None and cut != "axes":
        raise InputError(f"a surface says where axes meet; leave it out with --cut {cut}")
    reports.check_centerlines_folder(output)
    size = _length_unit(reading.unit)
    complete = measured_lines(lines, size, cast(Any, cut), reading.collapse, surface, cast(Any, ends))
    if wrong := unlike_the_species(complete.network, species, size):
        raise InputError(f"{lines}: {wrong}")
    measured = filled_at(wanted_part(complete, *wanted), pressure)
    settings: dict[str, str | float] = {
        "pressure [mmHg]": pressure,
        "unit [cm]": size,
        "species": species,
        "cut": cut,
        "ends": ends,
        "surface": "none" if surface is None else surface.name,
        "collapse": reading.collapse,
        "vessels in the file": len(complete.network),
    }
    reports.write_centerline_network(measured, [lines, *([] if surface is None else [surface])], settings, output)
    typer.echo(repr(measured.network))
    table = quote(str(output / "network.csv"))
    typer.echo(f"Look at it: {output / 'figures' / 'network.png'}; then: vasowave fit {table} RECORDING")


@app.command(epilog="Example: vasowave match control/network.csv hypertensive/network.csv -o matched.csv")
def match(
    first: Annotated[Path, typer.Argument(help="Vessel table, CSV.")],
    second: Annotated[Path, typer.Argument(help="Vessel table, CSV.")],
    output: Annotated[Path | None, typer.Option("--output", "-o", help="CSV of the pairs.")] = None,
) -> None:
    """Pair the vessels of two networks one to one, by topology and size, and list those left over."""
    from vasowave.lung import matching

    if output is not None:
        io.check_file(output)
    first_network, second_network = vw.read_network(first), vw.read_network(second)
    pairs = matching.match(first_network, second_network)
    lines = _pair_lines(first_network, second_network, pairs)
    if output is None:
        typer.echo("\n".join(lines))
    else:
        io.write_file(output, "\n".join(lines) + "\n")
    for path, unmatched in zip((first, second), matching.unmatched(first_network, second_network, pairs), strict=True):
        typer.echo(
            f"{path}: {len(unmatched)} vessels without counterpart{': ' if unmatched else ''}{', '.join(unmatched)}",
            err=True,
        )


def _pair_lines(first: "vw.Network", second: "vw.Network", pairs: dict[int, int]) -> list[str]:
    lines = ["first,second,length_first [cm],length_second [cm],radius_first [cm],radius_second [cm]"]
    for row, same in sorted(pairs.items()):
        sizes = (first.length[row], second.length[same], first.radius[row], second.radius[same])
        lines.append(",".join([first.name[row], second.name[same], *(f"{size:.10g}" for size in sizes)]))
    return lines


def _length_unit(text: str) -> float:
    """Return a unit of length, or a number of cm, in cm."""
    try:
        return float(text)
    except ValueError:
        return factor(text, "length")


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

        def begin_stage(stage: str) -> None:
            for task in progress.tasks:
                progress.update(task.id, total=1, completed=1)
            progress.add_task(stage, total=None)

        yield begin_stage
        for task in progress.tasks:
            progress.update(task.id, total=1, completed=1)


@app.command(
    epilog="Example: vasowave tidy tree.mat --unit '0.0036 cm' -o network.csv; vasowave tidy network.csv -o tidied.csv"
)
def tidy(
    network: Annotated[
        Path,
        typer.Argument(
            help="Vessel or edge table, GraphML, spatial graph of Amira (.am), MATLAB file (dim_mat, ves_conn), "
            "Dimensions.txt with connectivity.txt beside it, input of svOneDSolver or svZeroDSolver, FirstBlood table."
        ),
    ],
    output: Annotated[Path, typer.Option("--output", "-o", help="Vessel table to write.")] = Path("tidied.csv"),
    unit: Annotated[
        str | None, typer.Option(help="Unit of the lengths where the file does not say it: mm, or '0.0036 cm' a voxel.")
    ] = None,
    shortest: Annotated[
        float | None, typer.Option(help="Shortest vessel that is kept, in its own radii.", show_default="0.25", min=0.0)
    ] = None,
    change: Annotated[
        float | None,
        typer.Option(help="Change of the input impedance that repairs may make, %.", show_default="1", min=0.0),
    ] = None,
    species: Annotated[
        str, typer.Option(help="Whose heart rate and pressures it is computed for; by default by the root's size.")
    ] = "",
) -> None:
    """Repair a network: join what does not divide, merge what is too short for a wave; every repair is listed."""
    from vasowave.pulse.model.repairs import PROOF
    from vasowave.pulse.network.tidying import SHORTEST

    io.check_file(output)
    if output.exists() and output.samefile(network):
        raise InputError(f"{output}: would overwrite the network that is read; name another file with --output")
    allowed = PROOF.change if change is None else change / 100.0
    shortest_radii = SHORTEST if shortest is None else shortest
    tidied = vw.tidy(vw.read_network(network, unit), shortest_radii, change=allowed, species=species)
    vw.write_network(tidied.network, output)
    for repair in tidied.repairs:
        typer.echo(f"{repair.code}: {repair}")
    if isfinite(tidied.alike):
        typer.echo(f"Vessels in line whose radii differ by more than {100 * tidied.alike:g} % stay apart.")
    typer.echo(f"{tidied.summary() or 'Nothing was repaired'}. {tidied.network!r}: {output}")
