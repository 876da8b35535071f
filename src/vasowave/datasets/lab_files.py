"""Six synthetic recordings as a lab hands them over, to practise on: LabChart exports in two folders, and two lungs."""

from pathlib import Path

import numpy as np

from vasowave.datasets.raw import Disturbances, synthetic_raw_recording
from vasowave.datasets.virtual_cohort import virtual_cohort
from vasowave.datasets.virtual_files import labchart_text, network_text
from vasowave.errors import InputError
from vasowave.io.files import made_inside, write_file

_FOLDERS = {"CTL": "control", "HPH": "hypoxia"}
_EACH = 3  # animals of a group
_GAP = ("control", 2, slice(7000, 7400))  # samples whose pressure is missing
_DRIFT = ("hypoxia", 2, 9.0)  # mmHg/min


def write_lab_files(folder: Path, seed: int = 10) -> list[Path]:
    """Write six LabChart exports in the folders ``control`` and ``hypoxia`` and one vessel table for each of them.

    The pressure of ``control/mouse 2`` has a gap, the transducer of ``hypoxia/mouse 2`` drifts by 9 mmHg/min.

    Returns
    -------
    list of Path
        The files. The same seed writes the same bytes.

    Raises
    ------
    InputError
        The folder is not empty, or cannot be written.
    """
    folder, files = Path(folder), []
    if folder.exists() and (folder.is_file() or any(folder.iterdir())):
        raise InputError(f"{folder} is not an empty folder; give another name")
    cohort = virtual_cohort(seed)
    for group, name in _FOLDERS.items():
        made_inside(folder, name)
        animals = [animal for animal in cohort if animal.group == group][:_EACH]
        files.append(write_file(folder / f"lung {name}.csv", network_text(animals[0].network)))
        for number, animal in enumerate(animals, 1):
            raw = animal.raw
            if (name, number) == _DRIFT[:2]:
                drifting = Disturbances(pressure_drift=_DRIFT[2])
                raw = synthetic_raw_recording(animal.cycle, np.random.default_rng(seed), disturbances=drifting).raw
            text = labchart_text(raw)
            if (name, number) == _GAP[:2]:
                text = _without_pressure(text, _GAP[2])
            files.append(write_file(folder / name / f"mouse {number}.txt", text))
    return files


def _without_pressure(text: str, samples: slice) -> str:
    """Return a LabChart text whose first channel holds no number in a stretch of samples."""
    lines = text.split("\n")
    header = next(row for row, line in enumerate(lines) if line.startswith("UnitName")) + 1
    for row in range(header + samples.start, header + samples.stop):
        time, _, rest = lines[row].split("\t", 2)
        lines[row] = f"{time}\tNaN\t{rest}"
    return "\n".join(lines)
