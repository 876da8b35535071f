"""What a fit says, in sentences and rows of text; every number comes from the fit."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from vasowave.calibration.result import Fit
from vasowave.report.wording import Row, name_and_unit, number
from vasowave.results import indices_table, nominal_table


def is_synthetic(fits: Sequence[Fit]) -> bool:
    """Say whether the recording was made by a model and not measured."""
    return "synthetic" in fits[0].recording.source.lower()


def recording_sentences(fits: Sequence[Fit]) -> list[str]:
    """Return what the recording shows."""
    index = fits[0].recording.indices()
    return [
        f"Mean pressure {number(index['mPAP'])} mmHg (systolic {number(index['sPAP'])}, diastolic "
        f"{number(index['dPAP'])}, pulse {number(index['pPAP'])} mmHg) at a cardiac output of {number(index['CO'])} "
        f"ml/s and {number(index['HR'])} beats/min: a pulmonary vascular resistance of {number(index['PVR'])} "
        "mmHg s/ml."
    ]


def fit_sentences(fit: Fit) -> list[str]:
    """Return what one calibration says: stiffness, outlets, quality, determination, agreement of the starts."""
    return [_stiffness(fit), _beds(fit), _quality(fit), _determination(fit), _agreement(fit)]


def warnings(fits: Sequence[Fit]) -> list[str]:
    """Return everything a reader must know, without repetition: of the recording, then of each fit."""
    notes = fits[0].recording.notes
    found = [f"{fit.wall.capitalize()} wall: {text}" for fit in fits for text in fit.warnings if text not in notes]
    return [*(f"Recording: {note}" for note in notes), *found]


def indices_rows(fits: Sequence[Fit]) -> tuple[Row, list[Row]]:
    """Return header and rows: one row per index, one column measured and one per wall law."""
    table = indices_table(fits).set_index("source")
    header = ("index", "unit", *table.index)
    rows = [(*name_and_unit(label), *(number(value) for value in table[label])) for label in table.columns]
    return header, rows


def nominal_rows(fit: Fit) -> tuple[Row, list[Row]]:
    """Return header and rows of the nominal parameters."""
    table = nominal_table(fit)
    return ("parameter", "unit", "value"), [(*name_and_unit(label), number(table[label].iloc[0])) for label in table]


def parameter_rows(fit: Fit) -> tuple[Row, list[Row]]:
    """Return header and rows of the calibrated parameters."""
    columns = list(fit.parameters.columns)
    header = ("parameter", *(column.replace("_", " ") for column in columns))
    plain_units = fit.parameters.assign(unit=fit.parameters["unit"].replace("1", ""))
    return header, [(str(name), *(number(row[key]) for key in columns)) for name, row in plain_units.iterrows()]


def outcome_rows(fits: Sequence[Fit]) -> tuple[Row, list[Row]]:
    """Return header and rows of what sums up each fit."""
    quantities: dict[str, tuple[str, list[Any]]] = {
        "objective S": ("mmHg²", [fit.S for fit in fits]),
        "samples N": ("", [fit.N for fit in fits]),
        "RMSE": ("mmHg", [fit.rmse for fit in fits]),
        "total resistance R_T": ("mmHg s/ml", [fit.total_resistance for fit in fits]),
        "resistance ratio a = R1/R_T": ("%", [100 * fit.resistance_ratio for fit in fits]),
        "compliance of the vascular beds C_p": ("ml/mmHg", [fit.peripheral_compliance for fit in fits]),
        "pulse wave velocity at mean pressure": ("cm/s", [mean_wave_speed(fit) for fit in fits]),
    }
    rows = [(name, unit, *map(number, values)) for name, (unit, values) in quantities.items()]
    return ("quantity", "unit", *(f"{fit.wall} wall" for fit in fits)), rows


def mean_wave_speed(fit: Fit) -> float:
    """Pulse wave velocity in the root vessel at the cycle's mean pressure, cm/s (eqs. 31 and 32)."""
    from vasowave.walls import wave_speed

    network = fit.model.network
    here = fit.simulation.sel(vessel=network.name[network.root], station="inlet")
    law = type(fit.model.wall)(*(np.asarray(value)[network.root] for value in fit.model.wall))
    return float(wave_speed(law, float(here["pressure"].mean()), fit.model.blood.inertia))


def _stiffness(fit: Fit) -> str:
    symbols = {"beta": "stiffness β", "p1": "half-width pressure p1", "gamma": "scale γ"}
    parts = [
        f"{symbols[name]} = {_with_error(fit.parameters.loc[name])}" for name in fit.parameters.index if name in symbols
    ]
    return (
        f"Walls: {' and '.join(parts)}; waves run at {number(mean_wave_speed(fit))} cm/s in the root vessel at mean "
        "pressure."
    )


def _with_error(row: pd.Series) -> str:
    unit = "" if row["unit"] in ("1", "") else f" {row['unit']}"
    error = row.get("standard_error_correlated", row["standard_error"])
    known = isinstance(error, float | np.floating) and math.isfinite(error)
    return f"{number(row['value'])}{f' ± {number(error, 2)}' if known else ''}{unit}"


def _beds(fit: Fit) -> str:
    ratio = f"{number(100 * fit.resistance_ratio)} %"
    return (
        f"Vascular beds: total resistance R_T = {number(fit.total_resistance)} mmHg s/ml, of which {ratio} proximal "
        f"(ratio a), compliance {number(fit.peripheral_compliance)} ml/mmHg."
    )


def _quality(fit: Fit) -> str:
    share = 100 * fit.rmse / fit.recording.pulse_pressure
    return (
        f"Fit: the pressure differs from the measured one by {number(fit.rmse)} mmHg (root mean square), "
        f"{number(share, 2)} % of the pulse pressure; S = {number(fit.S)} mmHg² over {fit.N} samples."
    )


def _determination(fit: Fit) -> str:
    free = fit.parameters[fit.parameters["free"].astype(bool)]
    open_ones = [str(name) for name in free.index[~free["determined"].astype(bool)]]
    if not open_ones:
        return "The data determine every free parameter."
    return f"The data do not determine {', '.join(open_ones)}; other values fit about as well."


def _agreement(fit: Fit) -> str:
    agree, count = int(fit.starts["agrees"].sum()), len(fit.starts)
    if agree == count:
        return f"All {count} starts of the optimization found this optimum." if count > 1 else "One start was made."
    return f"Only {agree} of {count} starts of the optimization found this optimum; the others are listed below."
