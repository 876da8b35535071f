"""Commands on one model: simulate, sweep, export."""

import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import vasowave as vw
from vasowave.base import io
from vasowave.base.errors import InputError
from vasowave.cli import models
from vasowave.cli.app import app
from vasowave.cli.progress import alive, time_left, waiting
from vasowave.cli.signatures import with_option_groups
from vasowave.pulse import model as laws
from vasowave.pulse import solver
from vasowave.study import animal as animals
from vasowave.study import figures

if TYPE_CHECKING:
    import xarray as xr


_NAMES = (
    "Names: the wall law's (beta; p1, gamma; beta, m), in mmHg and plain numbers; of the vascular beds R_T "
    "\\[mmHg s/ml], a = R1/R_T, tau \\[s]; radius and length: factors of all vessels; "
    "wall_viscosity \\[mmHg s]."
)


@app.command(
    epilog=f"{_NAMES} Example: vasowave simulate network.csv cycle.csv --wall power --set beta=60 --set m=2; "
    "vasowave simulate my-mouse --set R_T=120"
)
@with_option_groups
def simulate(
    subject: models.Subject,
    output: Annotated[Path, typer.Option("--output", "-o", help="netCDF file to write.")] = Path("waveforms.nc"),
    *,
    choice: models.ModelChoice,
    values: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="NAME=VALUE",
            help="Another value of the wall or the beds; tau is R_T times "
            "their compliances alone, without that of the vessels.",
        ),
    ] = None,
    refinement: models.Refinement,
) -> None:
    """Simulate a network with nominal, given or fitted parameters and write the waveforms of every vessel."""
    io.check_file(output, models.DATA)
    models.trust_programs(subject.network, refinement.trust)
    model, cycle = models.model_from(subject, choice, refinement.friction)
    model = models.narrowed_model(laws.changed_model(model, pairs_of(values or [])), refinement.narrow or [])
    with waiting("simulating"):
        result = solver.simulate(model, cycle, models.numerics_from(refinement))
    _write(result, output)
    pressure = result["pressure"].values[:, model.network.root, 0]
    typer.echo(repr(model))
    if not (values or models.brings_its_model(subject.network)):
        typer.echo("Its parameters are nominal, straight from the recording; `vasowave fit` fits them to it.")
    typer.echo(
        f"Periodic after {result.attrs['cycles']} cycles (change {result.attrs['change']:.1g} mmHg, "
        f"Courant number {result.attrs['courant']:.2f}); pressure at the root {pressure.min():.1f} to "
        f"{pressure.max():.1f} mmHg, mean {pressure.mean():.1f}{_accuracy(result)}. Waveforms: {output}"
    )


def _accuracy(result: "xr.Dataset") -> str:
    """Say how large the numerical error is, by finer cells where an accuracy was asked for, else by the waves."""
    estimate = float(result.attrs["error_estimate"])
    if estimate > 0:  # NaN where none was asked for
        return f"; numerical error at most {estimate:.2g} mmHg, by comparing cells"
    return f"; numerical error about {float(result.attrs['grid_error']):.1g} mmHg, by its waves"


@app.command(
    epilog=f"{_NAMES} Example: vasowave sweep network.csv cycle.csv --vary beta=30:90:7 --vary R_T=60,80; "
    "vasowave sweep my-mouse --vary tau=0.05:0.3:20 -o sweep.csv --plot sweep.png"
)
@with_option_groups
def sweep(
    subject: models.Subject,
    vary: Annotated[
        list[str] | None, typer.Option(metavar="NAME=VALUES", help="from:to:count, or one,other; may be repeated.")
    ] = None,
    output: Annotated[
        Path, typer.Option("--output", "-o", help="File to write: .csv (a row for every combination) or netCDF.")
    ] = Path("sweep.nc"),
    plot: Annotated[Path | None, typer.Option(help="Picture to draw: .png, .pdf or .svg.")] = None,
    *,
    choice: models.ModelChoice,
    refinement: models.Refinement,
) -> None:
    """Simulate every combination of parameter values; keeps the root's pressure and what each vessel has of it."""
    models.check_files((output, ".csv", models.DATA), (plot, *models.PICTURES))
    if not vary:
        raise InputError("nothing to vary; give --vary NAME=VALUES, for example --vary beta=40,60,80")
    models.trust_programs(subject.network, refinement.trust)
    model, cycle = models.model_from(subject, choice, refinement.friction)
    grid = {name: _numbers(name, text) for name, text in _split(vary)}
    numerics, made, begun = models.numerics_from(refinement), [0, 0], time.monotonic()

    def so_far() -> str:
        done, count = made
        remaining_time = f", {time_left((time.monotonic() - begun) * (count / done - 1))}" if done else ""
        return f"{done} of {count} simulations{remaining_time}"

    with alive(so_far), _bar() as show:

        def progress(done: int, count: int) -> None:
            made[:] = done, count
            show(done, count)

        def narrowed(variant: "vw.Model") -> "vw.Model":
            return models.narrowed_model(variant, refinement.narrow or [])

        result = solver.sweep(model, cycle, grid, numerics, progress=progress, after=narrowed)
    _write_sweep(result, output)
    if plot is not None:
        models.draw(lambda: figures.sweep_figure(result), plot)
    failed, noted = (int((result[name] != "").sum()) for name in ("failure", "notes"))
    typer.echo(f"{result['failure'].size} simulations, {failed} failed ('failure' says why), {noted} with a warning "
               f"('notes' says which). Sweep: {output}"
               + (f", {plot}" if plot else ""))  # fmt: skip


@contextmanager
def _bar() -> "Iterator[Callable[[int, int], None]]":
    """Show a bar on a terminal; gives what takes the simulations that are done and all."""
    from rich.console import Console
    from rich.progress import Progress

    with Progress(transient=True, console=Console(stderr=True)) as bars:
        task = bars.add_task("simulations", total=None)
        yield lambda done, count: bars.update(task, completed=done, total=count)


def _write_sweep(result: "xr.Dataset", output: Path) -> None:
    from vasowave.base.io.columns import spreadsheet_cell

    if output.suffix.lower() != ".csv":
        _write(result, output)
        return
    table = solver.sweep_table(result)
    for name in ("failure", "notes"):
        table[name] = [spreadsheet_cell(" ".join(text.split())) for text in table[name]]
    io.write_file(output, table.to_csv(index=False, lineterminator="\n", float_format="%.6g"))


def _split(texts: Sequence[str]) -> list[tuple[str, str]]:
    wrong = next((text for text in texts if "=" not in text), None)
    if wrong is not None:
        raise InputError(f"'{wrong}': write NAME=VALUE, for example beta=60")
    pairs = [(name.strip(), value.strip()) for name, _, value in (text.partition("=") for text in texts)]
    twice = next((name for name, count in Counter(name for name, _ in pairs).items() if count > 1), None)
    if twice is not None:
        raise InputError(
            f"'{twice}' is given twice; name it once (`vasowave sweep --vary {twice}=5,6,10` takes several values)"
        )
    return pairs


def pairs_of(texts: Sequence[str]) -> dict[str, float]:
    """Return numbers by name from texts such as ``beta=60``; raises `InputError` for another."""
    numbers = {}
    for name, text in _split(texts):
        try:
            numbers[name] = float(text)
        except ValueError:
            raise InputError(
                f"{name}={text}: write one number with a decimal point, as 0.7; `vasowave sweep --vary` takes several"
            ) from None
    return numbers


def _numbers(name: str, text: str) -> list[float]:
    """Return the numbers in ``from:to:count`` or ``one,other``."""
    import numpy as np

    try:
        if ":" in text:
            low, high, count = text.split(":")
            return np.linspace(float(low), float(high), int(count)).tolist()
        return [float(number) for number in text.split(",")]
    except ValueError:
        raise InputError(f"{name}={text}: write one number, one,other or from:to:count") from None


def _write(result: "xr.Dataset", output: Path) -> None:
    import xarray as xr

    io.write_file(output, animals.to_bytes(xr.DataTree(result)))


@app.command(
    epilog="Example: vasowave export my-mouse --to paraview -o my-mouse-waves; "
    "vasowave export network.csv cycle.csv --to openbf; vasowave export openbf.yaml --to tables"
)
@with_option_groups
def export(
    subject: models.Subject,
    program: Annotated[
        str, typer.Option("--to", help="paraview, matlab, openbf, svzerod, or tables (CSV).")
    ] = "paraview",
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder to write into.")] = Path("vasowave-export"),
    centerlines: Annotated[
        Path | None, typer.Option(help="centerlines.csv of the extraction, for ParaView; without it, a flat tree.")
    ] = None,
    *,
    choice: models.ModelChoice,
    refinement: models.Refinement,
) -> None:
    """Write a model and its waves for ParaView, MATLAB, openBF or svZeroDSolver."""
    models.trust_programs(subject.network, refinement.trust)
    model, flow = models.model_from(subject, choice, refinement.friction)
    model, numerics = models.narrowed_model(model, refinement.narrow or []), models.numerics_from(refinement)
    sentences = vw.export_model(model, flow, program, output, centerlines=centerlines, numerics=numerics)
    typer.echo(repr(model))
    for sentence in sentences:
        typer.echo(f"  {sentence}")
    typer.echo(f"Written: {output}")
