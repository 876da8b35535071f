from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from vasowave.datasets.virtual import virtual_mouse
from vasowave.network import Network, write_network
from vasowave.recording import Recording

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


@pytest.fixture(scope="session")
def mice() -> list[Recording]:
    return [virtual_mouse(seed=seed) for seed in range(3)]


@pytest.fixture
def make_study(tmp_path: Path, mice: list[Recording]) -> Callable[..., Path]:
    """Return what writes a small study: three animals that share a network of three vessels."""

    def make(name: str = "study", animals: int = 3, settings: str = SETTINGS) -> Path:
        folder = tmp_path / name
        (folder / "recordings").mkdir(parents=True)
        write_network(Network(("1", "2", "3"), [-1, 0, 0], [0.41, 0.45, 0.37], [0.047, 0.026, 0.037]), folder / "n.csv")
        rows = ["animal,group,network,recording,synthetic"]
        for number, mouse in enumerate(mice[:animals]):
            write_cycle(folder / f"recordings/{number}.csv", mouse)
            rows.append(f"mouse {number},{'CTL' if number < 2 else 'HPH'},n.csv,recordings/{number}.csv,yes")
        (folder / "animals.csv").write_text("\n".join(rows) + "\n")
        (folder / "study.yaml").write_text(settings)
        return folder

    return make
