"""A small study as files: three animals that share a network of three vessels."""

from pathlib import Path

import numpy as np

from vasowave.pulse.cycle import Recording
from vasowave.pulse.network import Network, write_network

SETTINGS = """\
calibration:
  walls: [linear]
  starts: 2
model_selection: false
numerics:
  cell_size: 0.3
report:
  pdf: false
"""


def write_cycle(path: Path, recording: Recording) -> None:
    columns = np.column_stack([recording.time, recording.pressure, recording.flow])
    header = "time [s],pressure [mmHg],flow [ml/s]"
    np.savetxt(path, columns, fmt="%.17g", delimiter=",", header=header, comments="")


def make_study_in(folder: Path, mice: list[Recording], settings: str = SETTINGS) -> Path:
    """Write a small study: up to three animals that share a network of three vessels."""
    (folder / "recordings").mkdir(parents=True)
    write_network(Network(("1", "2", "3"), [-1, 0, 0], [0.41, 0.45, 0.37], [0.047, 0.026, 0.037]), folder / "n.csv")
    rows = ["animal,group,network,recording,synthetic"]
    for number, mouse in enumerate(mice):
        write_cycle(folder / f"recordings/{number}.csv", mouse)
        rows.append(f"mouse {number},{'CTL' if number < 2 else 'HPH'},n.csv,recordings/{number}.csv,yes")
    (folder / "animals.csv").write_text("\n".join(rows) + "\n")
    (folder / "study.yaml").write_text(settings)
    return folder
