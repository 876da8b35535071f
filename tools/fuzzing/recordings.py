"""Recordings: continuous ones and single cycles, as text and as binary files."""

import json
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import savemat

from fuzzing.forms import Form
from fuzzing.mutations import inside_zip, mutate_binary, mutate_ends, mutate_markup, mutate_mat, mutate_text
from vasowave.catheter.read import read_loops, read_raw_recording, read_recording
from vasowave.catheter.right_heart import RightHeart, read_right_heart

RATE, COUNT = 1000.0, 1500
TIME = np.arange(COUNT) / RATE
WAVE = np.sin(2 * np.pi * 9 * TIME)
SIGNALS = {"pressure": 14 + 5 * WAVE, "flow": 0.2 + 0.2 * WAVE, "ecg": np.cos(2 * np.pi * 9 * TIME) ** 31}
PHASE = np.arange(128) / 128
CYCLE = (0.11 * PHASE, 14 + 4 * np.sin(2 * np.pi * PHASE), 0.18 + 0.2 * np.sin(2 * np.pi * PHASE))


def rows(separator: str, decimal: str, *columns: np.ndarray) -> str:
    text = "\n".join(separator.join(f"{value:.6f}" for value in row) for row in zip(*columns, strict=True)) + "\n"
    return text.replace(".", decimal)


def table(separator: str, decimal: str) -> Callable[[Path], object]:
    head = separator.join(["time [s]", "pressure [mmHg]", "flow [ml/s]", "ecg [mV]"]) + "\n"
    return lambda path: path.write_text(head + rows(separator, decimal, TIME, *SIGNALS.values()))


def labchart_text(path: Path) -> None:
    head = (
        "Interval=\t0.001 s\nTimeFormat=\tStartOfBlock\nChannelTitle=\tPAP\tFlow\tECG\n"
        "Range=\t50 mmHg\t10 ml/s\t2 mV\nUnitName=\tmmHg\tml/s\tmV\n"
    )
    path.write_text(head + rows("\t", ".", TIME, *SIGNALS.values()).replace("\n", "\t#* start\n", 1))


def clock_table(path: Path) -> None:
    """Write a recorder's table: prose, titles, units, times of day, decimal commas."""
    head = "Recorder 4.3\nSampling;1000 Hz\n\nTime;PAP;Flow;Event\nhh:mm:ss,ms;mmHg;ml/s;\n"
    cells = (f"10:42:{7 + t:06.3f};{p:.4f};{q:.5f};{'wash' * bool(t == 0.5)}\n"
             for t, p, q in zip(TIME, SIGNALS["pressure"], SIGNALS["flow"], strict=True))  # fmt: skip
    path.write_text(head + "".join(cells).replace(".", ","))


def two_clocks(path: Path) -> None:
    """Write signals with times of their own, the second of half the rate."""
    slow = [f"{t:.3f},{q:.5f}" for t, q in zip(TIME[::2], SIGNALS["flow"][::2], strict=True)] + [","] * (COUNT // 2)
    quick = [f"{t:.3f},{p:.4f}" for t, p in zip(TIME, SIGNALS["pressure"], strict=True)]
    rows_of = "".join(f"{first},,{second}\n" for first, second in zip(quick, slow, strict=True))
    path.write_text(f"Time (s),PAP..mmHg.,,Time (s),Flow_mls\n{rows_of}")


def long_table(path: Path) -> None:
    """Write a row a sample of one signal, with marks between thousands."""
    units = (("pressure", "Pa", 133.322), ("flow", "ul/min", 6e4))
    cells = (f"{t:.3f};{name};{scale * value:,.2f};{unit}\n" for name, unit, scale in units
             for t, value in zip(TIME, SIGNALS[name], strict=True))  # fmt: skip
    path.write_text("time_s;signal;value;unit\n" + "".join(cells))


def spike2_text(path: Path) -> None:
    head = '"INFORMATION"\n"mouse.smr"\n\n"SUMMARY"\n'
    units = {"pressure": "mmHg", "flow": "ml/s", "ecg": "mV"}
    summary = "".join(f'"{i}"\t"Waveform"\t"{name}"\t"{units[name]}"\t"1000"\n' for i, name in enumerate(SIGNALS, 1))
    sections = (f'\n"CHANNEL"\t"{i}"\n"Waveform"\n"none"\n"{name}"\n"{units[name]}"\n"START"\t0.0\t0.001\n'
                + rows("", ".", values) for i, (name, values) in enumerate(SIGNALS.items(), 1))  # fmt: skip
    path.write_text(head + summary + "".join(sections))


def labchart_mat(path: Path) -> None:
    ends = COUNT * np.arange(1.0, 4.0)[:, None]
    variables = {
        "data": np.concatenate(list(SIGNALS.values()))[None, :], "datastart": ends - COUNT + 1, "dataend": ends,
        "titles": np.array(["PAP ", "Flow", "ECG "]), "samplerate": np.full((3, 1), RATE),
        "unittext": np.array(["mmHg", "ml/s", "mV  "]), "unittextmap": np.array([[1.0], [2.0], [3.0]]),
        "tickrate": np.array([[RATE]]), "com": np.array([[-1.0, 1, 20, 1, 1]]), "comtext": np.array(["start"]),
    }  # fmt: skip
    savemat(path, variables)


def labchart_matrices(path: Path) -> None:
    variables = {
        "data_block1": np.array(list(SIGNALS.values())), "ticktimes_block1": np.arange(COUNT) / RATE,
        "titles_block1": np.array(["PAP ", "Flow", "ECG "]), "units_block1": np.array(["mmHg", "ml/s", "mV  "]),
        "comtext_block1": np.array(["start"]), "comtick_block1": np.array([20.0]), "comchan_block1": np.array([-1.0]),
    }  # fmt: skip
    savemat(path, variables)


def edf(path: Path) -> None:
    count, records = len(SIGNALS), COUNT // 500
    ranges = {"pressure": ("mmHg", -10, 60), "flow": ("ml/s", -1, 2), "ecg": ("mV", -2, 2)}

    def field(values: list, width: int) -> bytes:
        return b"".join(str(value).encode().ljust(width)[:width] for value in values)

    header = b"0".ljust(8) + b"X".ljust(80) * 2 + b"01.01.2001.01.01" + str(256 * (count + 1)).encode().ljust(8)
    header += b" " * 44 + str(records).encode().ljust(8) + b"0.5".ljust(8) + str(count).encode().ljust(4)
    low, high = [r[1] for r in ranges.values()], [r[2] for r in ranges.values()]
    header += field(list(ranges), 16) + b" " * 80 * count + field([r[0] for r in ranges.values()], 8)
    header += field(low, 8) + field(high, 8) + field([-32768] * count, 8) + field([32767] * count, 8)
    header += b" " * 80 * count + field([500] * count, 8) + b" " * 32 * count
    digital = [np.rint((v - a) / (b - a) * 65535 - 32768) for v, a, b in zip(SIGNALS.values(), low, high, strict=True)]
    samples = np.stack([one.reshape(records, 500) for one in digital], axis=1)
    path.write_bytes(header + samples.astype("<i2").tobytes())


def bdf(path: Path) -> None:
    import edfio

    ranges = {"pressure": ("mmHg", (-10, 60)), "flow": ("ml/s", (-1, 2)), "ecg": ("mV", (-2, 2))}
    edfio.Bdf([
        edfio.BdfSignal(values, RATE, label=name, physical_dimension=ranges[name][0], physical_range=ranges[name][1])
        for name, values in SIGNALS.items()
    ], data_record_duration=0.5).write(path)  # fmt: skip


def wfdb(folder: Path) -> None:
    numbers = np.column_stack([np.rint(SIGNALS[name] * 100) for name in ("pressure", "flow")])
    (folder / "r.dat").write_bytes(numbers.astype("<i2").tobytes())
    lines = "r.dat 16 100(0)/mmHg 16 0 0 0 0 PAP\nr.dat 16 100/ml/s 16 0 0 0 0 Flow\n"
    (folder / "r.hea").write_text(f"r 2 1000 {COUNT} 10:00:00 01/02/2020\n{lines}# mouse 4\n")


def json_columns(path: Path) -> None:
    columns = {"time [s]": TIME, "PAP [mmHg]": SIGNALS["pressure"], "PA flow [ml/s]": SIGNALS["flow"]}
    path.write_text(json.dumps({title: column.round(6).tolist() for title, column in columns.items()}, indent=0))


def json_channels(path: Path) -> None:
    channels = [{"name": name, "unit": unit, "fs": RATE, "data": SIGNALS[name].round(6).tolist()}
                for name, unit in (("pressure", "mmHg"), ("flow", "ml/s"))]  # fmt: skip
    path.write_text(json.dumps({"channels": channels}))


def igor_text(path: Path) -> None:
    """Write waves, which have no times: a row less is a shorter recording."""
    scales = "".join(f'X SetScale/P x 0,0.001,"s", {name}; SetScale y 0,0,"{unit}", {name}\n'
                     for name, unit in (("PAP", "mmHg"), ("Flow", "ml/s")))  # fmt: skip
    body = rows("\t", ".", SIGNALS["pressure"], SIGNALS["flow"])
    path.write_text(f"IGOR\nWAVES/D\tPAP, Flow\nBEGIN\n{body}END\n{scales}")


def yokogawa(path: Path) -> None:
    """Write titles, units and rates behind words, and rows whose first cell is empty."""
    head = '"Model Name","DL850E"\n"TraceName","PA press","PA flow"\n"VUnit","mmHg","ml/s"\n'
    head += f'"BlockSize",{COUNT},{COUNT}\n"SampleRate",{RATE},{RATE}\n"Time","10:12:11.000","10:12:11.000"\n\n'
    body = rows(",", ".", SIGNALS["pressure"], SIGNALS["flow"])
    path.write_text(head + "".join(f",{row}\n" for row in body.splitlines()))


def labelled_matrix(path: Path) -> None:
    matrix = np.column_stack([TIME, SIGNALS["pressure"], SIGNALS["flow"]])
    titles, stated = np.array(["time", "pressure", "flow"]), np.array(["s", "mmHg", "ml/s"])
    np.savez(path, data=matrix, labels=titles, units=stated)


def acqknowledge_mat(path: Path) -> None:
    savemat(path, {"data": np.column_stack(list(SIGNALS.values())), "labels": np.array(["PAP ", "Flow", "ECG "]),
                   "units": np.array(["mmHg", "ml/s", "mV  "]), "isi": 1.0, "isi_units": "ms"})  # fmt: skip


def acq2mat(path: Path) -> None:
    channels = np.empty(2, object)
    for i, (name, unit) in enumerate((("pressure", "mmHg"), ("flow", "ml/s"))):
        channels[i] = {"name": name, "units": unit, "samples_per_second": RATE, "data": SIGNALS[name]}
    savemat(path, {"channels": channels})


def mat_structures(path: Path) -> None:
    channels = (("pressure", "mmHg"), ("flow", "ml/s"))
    savemat(path, {f"M_Ch{i}": {"title": name, "units": unit, "interval": 1 / RATE, "values": SIGNALS[name]}
                   for i, (name, unit) in enumerate(channels, 1)})  # fmt: skip


def cycle_table(path: Path) -> None:
    path.write_text("time [s],pressure [mmHg],flow [ml/s]\n" + rows(",", ".", *CYCLE))


def subjects(path: Path) -> None:
    """Write two subjects, a row each."""
    titles = [f"{name}_{i} [{unit}]" for name, unit in (("p", "mmHg"), ("q", "ml/s")) for i in range(len(CYCLE[0]))]
    rows_of = [[name, "500", *(f"{value:.6g}" for signal in CYCLE[1:] for value in signal)] for name in ("A", "B")]
    path.write_text("\n".join(",".join(row) for row in (["subject", "heart rate", *titles], *rows_of)) + "\n")


def cycle_mat(path: Path) -> None:
    savemat(path, dict(zip("tpq", CYCLE, strict=True)), do_compression=True)


def cycle_mat73(path: Path) -> None:
    """Write a cycle as `save -v7.3` does: HDF5 behind a header of 512 bytes."""
    import h5py

    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in zip(("time", "pressure", "flow"), CYCLE, strict=True):
            stored = file.create_dataset(name, data=values[None, :], chunks=True, compression="gzip")
            stored.attrs["MATLAB_class"] = np.bytes_("double")
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")


def workbook(path: Path) -> None:
    """Write a workbook of two sheets: groups, and signals."""
    import openpyxl

    book = openpyxl.Workbook()
    book.active.append(["animal", "group"])
    sheet = book.create_sheet("Trace")
    sheet.append(["time [s]", "pressure [mmHg]", "flow [ml/s]", "ecg [mV]"])
    for row in zip(TIME, *SIGNALS.values(), strict=True):
        sheet.append([round(float(value), 6) for value in row])
    book.save(path)


def labview(path: Path) -> None:
    """Write LabVIEW's text without a column of times."""
    head = "LabVIEW Measurement\t\nSeparator\tTab\nX_Columns\tNo\n***End_of_Header***\t\n\t\nChannels\t2\n"
    head += f"Samples\t{COUNT}\t{COUNT}\n"
    head += "Y_Unit_Label\tmmHg\tml/s\nDelta_X\t0.001\t0.001\n***End_of_Header***\t\nX_Value\tPressure\tFlow\tComment\n"
    rows_of = zip(SIGNALS["pressure"], SIGNALS["flow"], strict=True)
    path.write_text(head + "".join(f"\t{p:.5f}\t{q:.5f}\t\n" for p, q in rows_of))


def gated(path: Path) -> None:
    """Write a gated flow, with its heart rate above it, and a continuous pressure beside it."""
    table_of = "".join(f"{t:.3f},{p:.4f}\n" for t, p in zip(TIME, SIGNALS["pressure"], strict=True))
    (path.parent / "p.csv").write_text("time [s],pressure [mmHg]\n" + table_of)
    phases = 0.2 + 0.2 * np.sin(2 * np.pi * np.arange(20) / 20)
    path.write_text(
        "Heart rate: 530 bpm\nphase,flow [ml/s]\n" + "".join(f"{i},{q:.4f}\n" for i, q in enumerate(phases))
    )


def loops(path: Path) -> None:
    """Write pressure and volume of a ventricle, beside an artery and raw conductance."""
    head = "time [s],PAP [mmHg],RV Pressure [mmHg],Volume [ul],Phase [V]\n"
    path.write_text(head + rows(",", ".", TIME, *SIGNALS.values(), SIGNALS["ecg"]))


def right_heart(path: Path) -> None:
    """Write the numbers of a catheter."""
    path.write_text("quantity,value,unit\nsystolic,62,mmHg\ndiastolic,24,mmHg\nmean,38,mmHg\nwedge,11,mmHg\n"
                    "CO,4.6,l/min\nheart rate,78,1/min\n")  # fmt: skip


def mutate_edf(content: bytes, rng: np.random.Generator) -> bytes:
    kind = int(rng.integers(4))
    damaged = bytearray(content)
    if kind < 3:
        return mutate_ends(content, rng, kind)
    field = str(rng.choice(["-1", "0", "1", "nan", "1e9", "99999999", "3.5", "-32769", "", "1E308", "2147483648"]))
    starts = [0, 184, 236, 244, 252, *range(256 + 3 * 96, 256 + 3 * 136, 8), *range(256 + 3 * 216, 256 + 3 * 224, 8)]
    at = int(rng.choice(starts))
    damaged[at : at + 8] = field.encode().ljust(8)[:8]
    return bytes(damaged)


def _form(name: str, write: Callable, mutate: Callable, read: Callable, text: bool = False) -> Form:
    return Form(lambda folder: write(folder / name), name, name, mutate, read, structure, values, said, text)


def structure(recording: Any) -> tuple:
    rate = getattr(recording, "sampling_rate", None) or round(recording.period, 6)
    return len(recording.pressure), len(recording.flow), round(rate, 6), getattr(recording, "ecg", None) is None


def values(recording: Any) -> list[np.ndarray]:
    return [recording.pressure, recording.flow]


def structure_of_loops(recording: Any) -> tuple:
    return len(recording.pressure), len(recording.volume), round(recording.sampling_rate, 6)


def loop_values(recording: Any) -> list[np.ndarray]:
    return [recording.pressure, recording.volume]


def names_of(animals: tuple[RightHeart, ...]) -> tuple:
    return tuple(tuple(item.name for item in animal.derived()) for animal in animals)


def missing(animals: tuple[RightHeart, ...]) -> set[str]:
    return {line for animal in animals for line in str(animal).split("\n") if line.startswith("not given")}


def results(animals: tuple[RightHeart, ...]) -> list:
    return [np.array([item.value for item in animal.derived()]) for animal in animals]


def said(recording: Any) -> set[str]:
    return set(map(str, recording.notes))


FORMS = {
    "table, commas": _form("raw.csv", table(",", "."), mutate_text, read_raw_recording, True),
    "table, decimal commas": _form("raw.csv", table(";", ","), mutate_text, read_raw_recording, True),
    "table, clocks": _form("raw.txt", clock_table, mutate_text, read_raw_recording, True),
    "table, two clocks": _form("raw.csv", two_clocks, mutate_text, read_raw_recording, True),
    "table, long": _form("raw.csv", long_table, mutate_text, read_raw_recording, True),
    "spike2 text": _form("raw.txt", spike2_text, mutate_text, read_raw_recording, True),
    "labchart text": _form("raw.txt", labchart_text, mutate_text, read_raw_recording, True),
    "labchart mat": _form("raw.mat", labchart_mat, mutate_mat, read_raw_recording),
    "labchart mat, matrices": _form("raw.mat", labchart_matrices, mutate_mat, read_raw_recording),
    "edf": _form("raw.edf", edf, mutate_edf, read_raw_recording),
    "bdf": _form("raw.bdf", bdf, mutate_edf, read_raw_recording),
    "wfdb header": Form(wfdb, "r.hea", "r.hea", mutate_text, read_raw_recording, structure, values, said, True),
    "wfdb samples": Form(wfdb, "r.hea", "r.dat", mutate_binary, read_raw_recording, structure, values, said),
    "json, columns": _form("raw.json", json_columns, mutate_text, read_raw_recording, True),
    "json, channels": _form("raw.json", json_channels, mutate_text, read_raw_recording, True),
    "igor text": _form("raw.itx", igor_text, mutate_text, read_raw_recording),
    "table, words before titles": _form("raw.csv", yokogawa, mutate_text, read_raw_recording),
    "numpy archive": _form("raw.npz", labelled_matrix, mutate_binary, read_raw_recording),
    "acqknowledge mat": _form("raw.mat", acqknowledge_mat, mutate_mat, read_raw_recording),
    "acq2mat": _form("raw.mat", acq2mat, mutate_mat, read_raw_recording),
    "mat structures": _form("raw.mat", mat_structures, mutate_mat, read_raw_recording),
    "recording workbook": _form("raw.xlsx", workbook, inside_zip(mutate_markup, "sheet2.xml"), read_raw_recording),
    "labview text": _form("raw.lvm", labview, mutate_text, read_raw_recording, True),
    "gated flow": _form(
        "q.csv", gated, mutate_text, lambda path: read_raw_recording(path.parent / "p.csv", path), True
    ),
    "loops": Form(
        lambda folder: loops(folder / "v.csv"),
        "v.csv",
        "v.csv",
        mutate_text,
        read_loops,
        structure_of_loops,
        loop_values,
        said,
        True,
    ),
    "right heart": Form(
        lambda folder: right_heart(folder / "n.csv"),
        "n.csv",
        "n.csv",
        mutate_text,
        read_right_heart,
        names_of,
        results,
        notes=missing,
        text=True,
    ),
    "cycle table": _form("cycle.csv", cycle_table, mutate_text, read_recording, True),
    "cycle of a subject": _form("subjects.csv", subjects, mutate_text, partial(read_recording, subject_row="B"), True),
    "cycle mat": _form("cycle.mat", cycle_mat, mutate_mat, read_recording),
    "cycle mat 7.3": _form("cycle.mat", cycle_mat73, mutate_binary, read_recording),
}
