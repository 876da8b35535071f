"""Read what was observed at further sites: a table with a row for each."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from vasowave.base import units
from vasowave.base.errors import InputError, did_you_mean
from vasowave.base.io.columns import Columns, number, read_columns
from vasowave.catheter.read.single_wave import single_wave
from vasowave.catheter.signals.signal import ALIASES
from vasowave.pulse.cycle.observation import NUMBERS, QUANTITIES, ZERO_SD, Observation

COLUMNS = {
    "quantity": "What was observed: pressure, flow, velocity (mean over the cross-section), area or diameter.",
    "vessel": "Name of the vessel.",
    "place": "Share of its length from its inlet, 0 to 1; or, as `place [cm]`, the distance. Empty: 0.5.",
    "file": "Waveform over the cycle of the recording: a column with or without a column of time.",
    "mean": "Mean of the cycle, in place of a file.",
    "systolic": "Largest value, likewise.",
    "diastolic": "Smallest value, likewise.",
    "unit": "Unit of the numbers, of the error, and of a file that names none.",
    "error": "SD of the error of each value.",
    "zero sd": "SD of the zero of a pressure, in the same unit; empty: 0.5 mmHg.",
    "gain sd": "SD of a factor of all values, as a share; empty: 0 of a pressure, else 0.05.",
}
"""Columns of a table of sites, and what they hold."""

_ALIASES = {"what": "quantity", "observed": "quantity", "error sd": "error", "sd": "error", "waveform": "file"}
_MIDDLE_PLACE = "0.5"  # of the vessel, where no place is given
_REQUIRED_COLUMNS = ("quantity", "vessel", "unit", "error")


def read_sites(path: str | Path) -> tuple[Observation, ...]:
    """Read a table of sites, a row for each.

    Parameters
    ----------
    path : path
        CSV, TSV or workbook with the columns ``quantity, vessel, unit, error`` and, where they are needed, ``place``
        (or ``place [cm]``), ``file`` or ``mean, systolic, diastolic``, ``zero sd``, ``gain sd``. The names of files are
        seen from the folder of the table.

    Raises
    ------
    InputError
        File and line of: a column that is missing or unknown, a cell that is not a number, a unit that is not of the
        quantity, a file that is missing, uneven or names another unit than the table, a row that stands twice.

    Examples
    --------
    >>> import vasowave as vw
    >>> from pathlib import Path
    >>> _ = Path("sites.csv").write_text("quantity,vessel,place,mean,unit,error\\nflow,LPA,0.3,80,ul/s,10\\n")
    >>> vw.read_sites("sites.csv")
    (Observation(flow in 'LPA', 0.3 of its length: mean 0.08 ± 0.01 ml/s),)
    """
    table = read_columns(path, _ALIASES)
    for name in table.names:
        if name not in COLUMNS:
            raise InputError(f"{path}: unknown column '{name}'{did_you_mean(name, COLUMNS)}; known: "
                             f"{', '.join(COLUMNS)}")  # fmt: skip
    for name in _REQUIRED_COLUMNS:
        table.require(name)
    for name, unit in zip(table.names, table.units, strict=True):
        if unit and name != "place" and (name, unit) not in (("gain sd", "%"), ("gain sd", "1")):
            raise InputError(f"{path}, header, column '{name} [{unit}]': the column 'unit' says the unit of every row; "
                             f"call this one '{name}'")  # fmt: skip
    table.warn()
    _check_repeats(table)
    return tuple(_site(table, row) for row in range(len(table.cells)))


def _check_repeats(table: Columns) -> None:
    """Refuse a row that stands twice: it would count as one more measurement, with an error of its own."""
    lines: dict[tuple[str, ...], int] = {}
    for line, cells in zip(table.lines, table.cells, strict=True):
        cell = {name: text.strip() for name, text in zip(table.names, cells, strict=True)}
        values = (cell.get(name, "") for name in ("file", *NUMBERS, "unit"))
        site = (cell["quantity"].lower(), cell["vessel"], cell.get("place") or _MIDDLE_PLACE, *values)
        if (first := lines.setdefault(site, line)) != line:
            raise InputError(
                f"{table.source}, line {line}: the same values of the same place stand in line {first} already; remove "
                "one of the rows (a second measurement has values of its own)"
            )


def site_files(path: Path) -> tuple[Path, ...]:
    """Return the waveforms that a table of sites names, those that are there; none of a table that cannot be read."""
    try:
        table = read_columns(path, _ALIASES)
        column = table.find("file")
    except InputError:
        return ()
    names = [] if column is None else [cells[column].strip() for cells in table.cells]
    return tuple(file for name in dict.fromkeys(filter(None, names)) if (file := path.parent / name).is_file())


def _site(table: Columns, row: int) -> Observation:
    where = f"{table.source}, line {table.lines[row]}"
    cell = {name: table.cells[row][i].strip() for i, name in enumerate(table.names)}
    quantity = cell["quantity"].lower()
    if quantity not in QUANTITIES:
        hint = did_you_mean(quantity, QUANTITIES)
        raise InputError(f"{where}: '{cell['quantity']}' cannot be observed{hint}; known are: {', '.join(QUANTITIES)}")
    try:
        if not cell["unit"]:
            raise InputError("the cell 'unit' is empty; the error has one, also where a file names that of its values")
        scale = units.factor(cell["unit"], kind_of(quantity))
        waveform, period = _waveform(Path(table.source).parent / cell["file"], quantity, cell["unit"]) if cell.get(
            "file") else (None, None)  # fmt: skip
        values = {name: value * scale for name in NUMBERS if (value := _number(cell, name)) is not None}
        place, (error, zero) = _number(cell, "place"), (_number(cell, name) for name in ("error", "zero sd"))
        if error is None:
            raise InputError("the cell 'error' is empty; give the SD of the error of each value")
        unit = table.unit_of("place")
        cm = place * units.factor(unit, "length") if place is not None and unit not in ("", "1") else None
        zero_sd = ZERO_SD if zero is None else zero * scale
        share = place if cm is None else None
        mean, largest, smallest = (values.get(name) for name in NUMBERS)
        gain = _number(cell, "gain sd")
        if gain is not None and table.unit_of("gain sd") == "%":
            gain /= 100
        return Observation(
            quantity, cell["vessel"], error * scale, share, cm, waveform, mean, largest, smallest, zero_sd, gain, period
        )
    except InputError as problem:
        raise InputError(f"{where}: {problem}") from None


def kind_of(quantity: str) -> str:
    """Return the kind of units that a quantity has."""
    return "length" if quantity == "diameter" else quantity


def _number(cell: Mapping[str, str], name: str) -> float | None:
    text = cell.get(name, "")
    if not text:
        return None
    try:
        return number(text)
    except ValueError:
        raise InputError(f"column '{name}': '{text}' is not a number") from None


def _waveform(path: Path, quantity: str, unit: str) -> tuple[np.ndarray, float | None]:
    """Return the waveform of a file in the canonical unit, and its period if the file has times."""
    if not path.is_file():
        raise InputError(f"there is no file {path}")
    wave = single_wave(read_columns(path, ALIASES), quantity, kind_of(quantity), unit)
    if wave.stated and units.factor(wave.stated, kind_of(quantity)) != units.factor(unit, kind_of(quantity)):
        raise InputError(
            f"{path}: its header says {wave.stated}, the table of sites says {unit}; correct one of the two"
        )
    return wave.cycle()
