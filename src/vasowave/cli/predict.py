"""The command that says what a change, or a further measurement, would do."""

from pathlib import Path
from typing import Annotated

import typer

import vasowave as vw
from vasowave.base import io
from vasowave.base.errors import InputError
from vasowave.cli import models
from vasowave.cli.app import app
from vasowave.cli.progress import print_table, waiting
from vasowave.cli.simulate import pairs_of
from vasowave.study import animal as animals

_FIT = typer.Argument(help="Folder of a fit or a study.")
_CHANGE = typer.Option(
    metavar="NAME=FACTOR",
    help="A parameter of wall or beds, R_T, radius, length, HR or CO, times a factor. May be repeated.",
)
_MEASUREMENTS = typer.Option(
    "--measurements",
    help="Instead: how much narrower intervals would be with a second pressure, a wedge pressure, a better image, more "
    "beats.",
)
_SITE = typer.Option(help="Vessel of that second pressure; else the daughters of the root. May be repeated.")
_PLOT = typer.Option(help="Picture of the waves before and after: .png, .pdf or .svg.")


@app.command(
    epilog="Example: vasowave predict my-mouse --change R_T=0.7 --change beta=1.5 -o change.csv --plot change.svg. "
    "Without a change it says what can be changed. Intervals are those of the posterior, where the fit has one. "
    "vasowave predict my-mouse --measurements says what to measure next; vw.rank_stenoses, in Python, what the removal "
    "of each stenosis gives back."
)
def predict(
    fit: Annotated[Path, _FIT],
    change: Annotated[list[str] | None, _CHANGE] = None,
    narrow: Annotated[list[str] | None, models.NARROW] = None,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Table of the numbers, .csv.")] = None,
    plot: Annotated[Path | None, _PLOT] = None,
    animal: Annotated[str, models.ANIMAL] = "",
    wall: Annotated[str, models.WALL] = "",
    draws: Annotated[int, typer.Option(help="Sets of parameters that make the intervals; 0 for none.")] = 40,
    measurements: Annotated[bool, _MEASUREMENTS] = False,
    site: Annotated[list[str] | None, _SITE] = None,
    trust: Annotated[bool, models.TRUST] = False,
) -> None:
    """Say what a change does to pressure, power and shear of a fitted animal, before and after, with intervals."""
    models.check_files((output, ".csv"), (plot, *models.PICTURES))
    models.trust_programs(fit, trust)
    result = models.stored_animal(fit, animal)
    if measurements:
        if change or narrow or plot:
            raise InputError(
                "--measurements changes nothing and draws nothing; leave --change, --narrow and --plot out"
            )
        with waiting("simulating"):
            expected = animals.stored_precision(result, wall, site)
        _tell_measurements(expected, output)
        return
    if site:
        raise InputError("--site names where a second pressure could be recorded; give --measurements beside it")
    stored, factors = vw.stored_fit(result, wall), pairs_of(change or [])
    with waiting("simulating"):
        foretold = vw.predict(
            stored,
            factors,
            remodel=(lambda model: models.narrowed_model(model, narrow)) if narrow else None,
            draws=draws,
        )
    _print(foretold)
    if output is not None:
        io.write_file(output, foretold.table.to_csv(index_label="quantity", float_format="%.6g", lineterminator="\n"))
    if plot is not None:
        models.draw(foretold.figure, plot)
    if written := [str(path) for path in (output, plot) if path is not None]:
        typer.echo(f"Written: {', '.join(written)}")


def _tell_measurements(expected: "vw.ExpectedPrecision", output: Path | None) -> None:
    """Print by which factor each interval would shrink, and write the table if it is asked for."""
    rows = [("", "value", "95 % interval", "unit", *expected.measurements)]
    rows += [
        (str(name), f"{row['value']:.4g}", f"[{row['low']:.3g}, {row['high']:.3g}]", row["unit"].removeprefix("1"),
         *(f"{row[measurement]:.2f}" for measurement in expected.measurements))
        for name, row in expected.table.iterrows()
    ]  # fmt: skip
    print_table(rows, (0, 3), expected.assumptions)
    if output is not None:
        io.write_file(output, expected.table.to_csv(float_format="%.6g", lineterminator="\n"))
        typer.echo(f"Written: {output}")


def _print(foretold: "vw.Prediction") -> None:
    """Print the numbers as a table, and below it what a reader must know."""
    import numpy as np

    rows = [("", "before", "after", "change", "95 % interval", "unit")]
    rows += [
        (str(name), f"{row['before']:.4g}", f"{row['after']:.4g}", f"{row['change']:+.3g}",
         "" if np.isnan(row["change_low"]) else f"[{row['change_low']:+.3g}, {row['change_high']:+.3g}]",
         row["unit"].removeprefix("1"))
        for name, row in foretold.table.iterrows()
    ]  # fmt: skip
    print_table(rows, (0, 5), foretold.remarks)
