"""A recording alone as a table: each number with its unit, and its spread over the beats."""

from pathlib import Path

import numpy as np
import pandas as pd

from vasowave.base.cures import UNKNOWN, SetCells
from vasowave.base.findings import look_kind
from vasowave.base.io.files import write_file
from vasowave.pulse.analysis.ejection import beat_indices, cycle_indices
from vasowave.pulse.cycle.averaged import EnsembleAverage
from vasowave.pulse.cycle.cycle import Recording
from vasowave.pulse.quantities import QUANTITIES

NO_WEDGE = look_kind(
    "recording.no-wedge",
    "no wedge pressure is given: PVR and RC count from 0 mmHg, and are too large",
    "Give the pressure behind the vascular beds.",
    SetCells("Give the wedge pressure", (("wedge [mmHg]", UNKNOWN),)),
)


def indices_table(recording: Recording, average: EnsembleAverage | None = None) -> pd.DataFrame:
    """Return the numbers of a recording alone, in the order of `QUANTITIES`.

    Parameters
    ----------
    recording : Recording
    average : EnsembleAverage, optional
        The beats of which it is the average.

    Returns
    -------
    DataFrame
        Index: name; columns ``symbol``, ``value``, ``unit``, ``meaning``; with beats ``beat SD`` and ``beats``.
    """
    values = recording.indices() | cycle_indices(recording).values
    names = [name for name in QUANTITIES if name in values]
    table = pd.DataFrame({
        "symbol": [QUANTITIES[name].symbol for name in names],
        "value": [values[name] for name in names],
        "unit": [QUANTITIES[name].unit for name in names],
        "meaning": [QUANTITIES[name].meaning for name in names],
    }, index=pd.Index(names, name="quantity"))  # fmt: skip
    if average is not None:
        beats = beat_indices(average, recording).reindex(columns=names)
        table.insert(2, "beat SD", beats.std(ddof=1).to_numpy())
        table["beats"] = beats.count().to_numpy()
    return table


def indices_text(recording: Recording, average: EnsembleAverage | None = None) -> str:
    """Return the table as lines of text, and below it why numbers are absent."""
    table = indices_table(recording, average)
    lines = []
    for name, row in table.iterrows():
        spread = f" ± {row['beat SD']:.2g}" if np.isfinite(row.get("beat SD", np.nan)) else ""
        unit = "" if row["unit"] == "1" else f" {row['unit']}"
        lines.append(f"  {name:20} {row['value']:.4g}{spread}{unit}".ljust(56) + str(row["meaning"]))
    head = (
        recording.source
        if average is None
        else f"{recording.source}: averaged cycle of {table['beats'].max()} beats ± SD of single beats"
    )
    return "\n".join([head, *lines, *(f"  {finding}" for finding in cycle_indices(recording).absent)])


def write_beats(recording: Recording, average: EnsembleAverage, path: Path) -> Path:
    """Write a row for each beat that was averaged, titles with units; return `path`."""
    beats = beat_indices(average, recording)
    titled = beats.rename(columns=lambda name: f"{name} [{QUANTITIES[name].unit}]")
    return write_file(path, titled.to_csv(float_format="%.8g", lineterminator="\n"))
