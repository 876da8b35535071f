"""The command on loops of pressure and volume of a ventricle."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vasowave.cli.app import app
from vasowave.cli.cures import Shell, code_of

if TYPE_CHECKING:
    from vasowave.pulse.analysis.ventricular_function import VentricularFunction

_NAMED = dict.fromkeys(("channel", "unit"), ("pressure", "volume"))
_FIGURES = (".svg", ".pdf", ".png")


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
    from vasowave.base.findings import sentence
    from vasowave.base.io.files import check_file
    from vasowave.catheter.read.loops import read_loops
    from vasowave.cli.options import row_cells
    from vasowave.cli.progress import print_text
    from vasowave.pulse.analysis.ventricular_function import pressure_volume

    for path, kinds in ((output, (".csv",)), (beats, (".csv",)), (plot, _FIGURES)):
        if path is not None:
            check_file(path, *kinds)
    stretches = (_stretch("steady", steady), _stretch("family", family))
    options = dict(setting_values or {})
    cells = row_cells(options, (), _NAMED)
    titled = {title.removesuffix(" channel").replace(" ", "_"): cell for title, cell in cells.items()}
    function = pressure_volume(read_loops(recording, volume, **options, **titled), *stretches)
    print_text(_text(function))
    for finding in function.findings:
        print_text(f"note: {sentence(finding)}{code_of(finding)}{Shell().below(finding.cures)}", err=True)
    _write(function, output, beats, plot)


def _text(function: "VentricularFunction") -> str:
    """Return the table of the numbers as lines of text."""
    from vasowave.study.results.overview import aligned

    rows = [("", "value", "95 % interval", "unit", "beats", "")]
    rows += [
        (str(name), f"{row['value']:.4g}", f"[{row['low']:.4g}, {row['high']:.4g}]", str(row["unit"]),
         str(row["beats"]), str(row["meaning"]))
        for name, row in function.table.iterrows()
    ]  # fmt: skip
    head = f"{function.source}: {len(function.steady)} steady beats, {len(function.family)} of a family"
    return "\n".join([head, *aligned(rows, (0, 3, 5))])


def _write(function: "VentricularFunction", output: Path | None, beats: Path | None, plot: Path | None) -> None:
    """Write what was asked for, and say where it is."""
    from vasowave.base.io.files import write_file
    from vasowave.pulse.analysis.ventricular_function import VENTRICULAR
    from vasowave.study.figures.loops import loops_figure
    from vasowave.study.figures.matplotlib_style import style
    from vasowave.study.figures.rendering import as_file

    titled = {name: f"{name} [{quantity.unit}]" for name, quantity in VENTRICULAR.items()}
    tables = (
        ("Numbers", output, lambda: function.table),
        ("Beats", beats, lambda: function.beats.rename(columns=titled)),
    )
    for words, path, table in tables:
        if path is not None:
            content = table().to_csv(float_format="%.8g", lineterminator="\n")
            typer.echo(f"{words}: {write_file(path, content)}")
    if plot is not None:
        with style():
            typer.echo(f"Figure: {write_file(plot, as_file(loops_figure(function), plot.suffix[1:].lower()))}")


def _stretch(option: str, text: str) -> tuple[float, float] | None:
    """Return two times, s."""
    from vasowave.base.errors import InputError

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
