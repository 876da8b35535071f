"""Synthetic recordings as text: the exports of LabChart, and tables."""

import numpy as np

from vasowave.catheter.signals.raw import RawRecording

SYNTHETIC_NOTICE = "SYNTHETIC: made by vasowave from published parameters, no animal was measured"
"""Stands in every file of a synthetic recording."""


def labchart_text(raw: RawRecording) -> str:
    """Return a recording as LabChart's text export: one block, flow in µl/s, a comment at its start."""
    header = [
        f"Interval=\t{1 / raw.sampling_rate:.9g} s",
        "ExcelDateTime=\t4.3466500000000000e+004\t01/01/2019 12:00:00.000000",
        "TimeFormat=\tStartOfBlock",
        "DateFormat=\t",
        "ChannelTitle=\tPAP\tFlow\tECG",
        "Range=\t10 V\t10 V\t10 mV",
        "UnitName=\tmmHg\tul/s\tmV",
    ]
    rows = _formatted("{:.5f}\t{:.4f}\t{:.3f}\t{:.4f}", raw, 1e3).split("\n")
    rows[0] += f"\t#* {SYNTHETIC_NOTICE}"
    return "\n".join([*header, *rows]) + "\n"


def table_text(raw: RawRecording) -> str:
    """Return a recording as a CSV table."""
    header = f"# {SYNTHETIC_NOTICE}\ntime [s],pressure [mmHg],flow [ml/s],ecg [mV]\n"
    return header + _formatted("{:.5f},{:.4f},{:.6f},{:.4f}", raw, 1.0) + "\n"


def _formatted(line: str, raw: RawRecording, flow_scale: float) -> str:
    ecg = raw.ecg if raw.ecg is not None else np.zeros(len(raw.pressure))
    columns = (raw.time, raw.pressure, flow_scale * raw.flow, ecg)
    return "\n".join(map(line.format, *(column.tolist() for column in columns)))
