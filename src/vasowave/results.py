"""The result folder of one animal: a netCDF-4 file with everything, and tidy tables with units in their headers."""

import os
import shutil
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pandas as pd

from vasowave.animal.datasets import OUTLET_UNITS, plain, scalars, write_archive
from vasowave.calibration.result import Fit
from vasowave.errors import InputError
from vasowave.provenance import provenance
from vasowave.recording.cycle import INDEX_UNITS, resample

ARCHIVE = "results.nc"
REPORT = "report.html"
FIGURES = "figures"
_MARKS = {ARCHIVE: b"vasowave", REPORT: b'name="generator" content="vasowave'}


def write_results(fits: Sequence[Fit], folder: Path, inputs: Sequence[Path] = ()) -> list[Path]:
    """Write the calibrations of one recording to `folder`, whole or not at all.

    Parameters
    ----------
    fits : sequence of Fit
        One fit per wall law, all of the same recording.
    folder : Path
        Made if missing. An earlier result in it is replaced, its report and figures are removed;
        files of other origin stay.
    inputs : sequence of Path, optional
        Files that were read; their SHA-256 stands in the result.

    Returns
    -------
    list of Path
        ``results.nc`` and the tables ``indices, nominal, parameters, outlets, fits, starts, correlation,
        waveforms`` (CSV).

    Raises
    ------
    InputError
        The folder holds something else than a vasowave result or cannot be written; the fits do not belong together.
    """
    folder = prepared_folder(fits, folder)
    produced = tables(fits)
    with replacing(folder) as fresh:
        write_archive(fits, fresh / ARCHIVE, provenance(inputs))
        for name, table in produced.items():
            table.to_csv(fresh / f"{name}.csv", index=False, lineterminator="\n")
    return [folder / ARCHIVE, *(folder / f"{name}.csv" for name in produced)]


def prepared_folder(fits: Sequence[Fit], folder: Path) -> Path:
    """Return the full path of `folder` after `check_fits` and `check_folder`."""
    check_fits(fits)
    folder = Path(folder).resolve()
    check_folder(folder)
    return folder


def check_fits(fits: Sequence[Fit]) -> None:
    """Raise `InputError` unless `fits` are of one recording and of different wall laws."""
    if not fits:
        raise InputError("no fit was given; calibrate at least one wall law")
    walls = [fit.wall for fit in fits]
    if len(set(walls)) < len(walls):
        raise InputError(f"two fits of the same wall law ({', '.join(walls)}); one result holds one fit per law")
    first = fits[0].recording
    for fit in fits[1:]:
        same = fit.recording.period == first.period and np.array_equal(fit.recording.pressure, first.pressure)
        if not same:
            raise InputError(
                f"the fits are of different recordings ({first.source}; {fit.recording.source}); give one folder each"
            )


def check_folder(folder: Path, marks: Mapping[str, bytes] = _MARKS) -> None:
    """Raise `InputError` unless `folder` is missing, empty, or an earlier result of vasowave, and can be written.

    `marks` names files by which such a result is known, and what they contain.
    """
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder} is a file; give the name of a folder")
    _check_writable(folder)
    if not folder.exists():
        return
    if any(folder.iterdir()) and not any(_has_mark(folder / name, mark) for name, mark in marks.items()):
        raise InputError(f"{folder} is not empty and not a vasowave result; give another folder or empty it first")


def _check_writable(folder: Path) -> None:
    """Raise `InputError` now, not after hours, if a folder cannot be put into the place of `folder`."""
    place = next(parent for parent in folder.absolute().parents if parent.exists())
    try:
        with tempfile.TemporaryDirectory(prefix=".vasowave-", dir=place):
            pass
    except OSError as error:
        raise InputError(f"{folder}: cannot be made ({error.strerror}); choose another place") from None


def tables(fits: Sequence[Fit]) -> dict[str, pd.DataFrame]:
    """Return the tidy tables of the calibrations, by name, with units in the column names."""
    return {
        "indices": indices_table(fits),
        "nominal": nominal_table(fits[0]),
        "parameters": _stacked(fits, lambda fit: fit.parameters.rename_axis("parameter").reset_index()),
        "outlets": outlets_table(fits),
        "fits": _stacked(fits, _summary),
        "starts": _stacked(fits, starts_table),
        "correlation": _stacked(fits, _correlation),
        "waveforms": waveforms_table(fits),
    }


def indices_table(fits: Sequence[Fit]) -> pd.DataFrame:
    """Return the indices of Table 1, one row measured and one per wall law."""
    measured = fits[0].recording.indices()
    rows = [{"source": "measured", **measured}]
    for fit in fits:
        _, p, q = inlet(fit)
        extremes = {"mPAP": p.mean(), "sPAP": p.max(), "dPAP": p.min(), "pPAP": np.ptp(p), "PVR": p.mean() / q.mean()}
        rows.append({"source": fit.wall, "HR": measured["HR"], "CO": q.mean(), **extremes})
    return pd.DataFrame(rows).rename(columns={name: f"{name} [{unit}]" for name, unit in INDEX_UNITS.items()})


def inlet(fit: Fit) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return time (s), simulated pressure (mmHg) and flow (ml/s) at the inlet of the root, where the catheter was."""
    network = fit.model.network
    here = fit.simulation.sel(vessel=network.name[network.root], station="inlet")
    return here["time"].to_numpy(), here["pressure"].to_numpy(), here["flow"].to_numpy()


def nominal_table(fit: Fit) -> pd.DataFrame:
    """Return the nominal parameters of the recording, one row."""
    nominal = fit.nominal
    values = {
        "Z_c [mmHg s/ml]": nominal.characteristic_impedance,
        "beta0 [mmHg]": nominal.beta,
        "R_T0 [mmHg s/ml]": nominal.total_resistance,
        "tau0 [s]": nominal.time_constant,
    }
    return pd.DataFrame([values])


def outlets_table(fits: Sequence[Fit]) -> pd.DataFrame:
    """Return R1, R2 and C of every vascular bed: nominal, and calibrated with each wall law."""
    network = fits[0].model.network
    sets = {"nominal": fits[0].nominal.outlets, **{fit.wall: fit.model.outlets for fit in fits}}
    parts = []
    for stage, outlets in sets.items():
        values = {f"{name} [{unit}]": getattr(outlets, name) for name, unit in OUTLET_UNITS.items()}
        terminal = {
            "stage": stage,
            "vessel": [network.name[row] for row in network.terminals],
            "flow_fraction [1]": network.flow_fraction[network.terminals],
        }
        parts.append(pd.DataFrame(terminal | values))
    return pd.concat(parts, ignore_index=True)


def starts_table(fit: Fit) -> pd.DataFrame:
    """Return where every start of one fit ended, with units in the column names."""
    units = {name: f"{name} [{unit}]" for name, unit in fit.parameters["unit"].items()}
    return fit.starts.rename(columns=units)


def waveforms_table(fits: Sequence[Fit]) -> pd.DataFrame:
    """Return pressure and flow at the inlet of the root vessel over one cycle: measured, and simulated by each law."""
    recording = fits[0].recording
    flow = resample(recording.flow, len(recording.pressure))
    parts = [_waveform("measured", recording.time, recording.pressure, flow)]
    parts += [_waveform(fit.wall, *inlet(fit)) for fit in fits]
    return pd.concat(parts, ignore_index=True)


def _waveform(source: str, time: np.ndarray, pressure: np.ndarray, flow: np.ndarray) -> pd.DataFrame:
    return pd.DataFrame({"source": source, "time [s]": time, "pressure [mmHg]": pressure, "flow [ml/s]": flow})


def _summary(fit: Fit) -> pd.DataFrame:
    return pd.DataFrame(
        [{f"{name} [{value.attrs['units']}]": value.values.item() for name, value in scalars(fit).items()}]
    )


def _correlation(fit: Fit) -> pd.DataFrame:
    names = fit.correlation.index
    pairs = [(one, other, fit.correlation.loc[one, other]) for one in names for other in names]
    return pd.DataFrame(pairs, columns=["parameter", "other", "correlation [1]"])


def _stacked(fits: Sequence[Fit], table_of) -> pd.DataFrame:  # type: ignore[no-untyped-def]
    parts = []
    for fit in fits:
        table = table_of(fit)
        cells = {label: plain(table[label]) for label in table.columns}
        parts.append(pd.DataFrame({"wall": [fit.wall] * len(table), **cells}))
    return pd.concat(parts, ignore_index=True)


def _has_mark(path: Path, mark: bytes) -> bool:
    return path.is_file() and mark in path.read_bytes()


@contextmanager
def replacing(folder: Path, marks: Mapping[str, bytes] = _MARKS) -> Iterator[Path]:
    """Give an empty sibling of `folder` to fill; put it in the folder's place only if nothing went wrong.

    Files of other origin stay; an earlier result, known by `marks`, goes.
    """
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        fresh = Path(tempfile.mkdtemp(prefix=f".{folder.name}-", dir=folder.parent))
    except OSError as error:
        raise InputError(f"{folder}: cannot be made ({error.strerror}); choose another place") from None
    try:
        yield fresh
        fresh.chmod(0o755)
        _put_in_place(fresh, folder, marks)
    except OSError as error:
        raise InputError(f"{folder}: cannot be written ({error.strerror or error}); choose another place") from error
    finally:
        shutil.rmtree(fresh, ignore_errors=True)


def _put_in_place(fresh: Path, folder: Path, marks: Mapping[str, bytes]) -> None:
    if not folder.exists():
        os.replace(fresh, folder)
        return
    old = Path(tempfile.mkdtemp(prefix=f".{folder.name}-old-", dir=folder.parent))
    os.replace(folder, old / folder.name)
    os.replace(fresh, folder)
    for stray in (old / folder.name).iterdir():
        ours = stray.name in marks or stray.name == FIGURES or (folder / stray.name).exists()
        if not ours:
            os.replace(stray, folder / stray.name)
    shutil.rmtree(old)
