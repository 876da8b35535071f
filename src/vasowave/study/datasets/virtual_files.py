"""The virtual cohort as the files a lab would have, and one file that a lab never has: the truth; and six recordings as
a lab hands them over, to practise on: LabChart exports in two folders, and two lungs.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from vasowave.base.errors import InputError
from vasowave.base.io.files import made_inside, write_file
from vasowave.catheter.synthetic import Disturbances, synthetic_raw_recording
from vasowave.catheter.synthetic_files import SYNTHETIC_NOTICE, labchart_text, table_text
from vasowave.pulse.network.network import Network
from vasowave.pulse.quantities import QUANTITIES
from vasowave.study.datasets.virtual import VirtualAnimal, virtual_cohort

_UNITS = {name: quantity.unit for name, quantity in QUANTITIES.items()} | {
    "p1": "mmHg",
    "gamma": "1",
    "discrepancy": "mmHg",
}
_FOLDERS = {"CTL": "control", "HPH": "hypoxia"}
_EACH = 3  # animals of a group
_GAP = ("control", 2, slice(7000, 7400))  # samples whose pressure is missing
_DRIFT = ("hypoxia", 2, 9.0)  # mmHg/min


def write_virtual_cohort(animals: Sequence[VirtualAnimal], folder: Path) -> Path:
    """Write raw recordings, networks, ``animals.csv`` and ``truth.csv`` to `folder`; returns the table of animals.

    Recordings of control animals are LabChart text exports, the others CSV tables, so that a study reads both.

    Raises
    ------
    InputError
        A file cannot be written.
    """
    folder, rows, truths = Path(folder), [], []
    for name in ("networks", "recordings"):
        made_inside(folder, name)
    for animal in animals:
        network = Path("networks") / f"{animal.group.lower()}.csv"
        labchart = animal.group == "CTL"
        recording = Path("recordings") / f"{animal.name.replace(' ', '-').lower()}{'.txt' if labchart else '.csv'}"
        write_file(folder / network, network_text(animal.network))
        write_file(folder / recording, labchart_text(animal.raw) if labchart else table_text(animal.raw))
        rows.append((animal.name, animal.group, network.as_posix(), recording.as_posix(), "raw", "yes"))
        truth = {f"{name} [{_UNITS[name]}]": value for name, value in animal.truth.items()}
        truths.append({"animal": animal.name, "group": animal.group, **truth})
    write_file(
        folder / "truth.csv", f"# {SYNTHETIC_NOTICE}\n" + pd.DataFrame(truths).to_csv(index=False, lineterminator="\n")
    )
    header = f"# {SYNTHETIC_NOTICE}\nanimal,group,network,recording,kind,synthetic\n"
    return write_file(folder / "animals.csv", header + "".join(",".join(row) + "\n" for row in rows))


def network_text(network: Network) -> str:
    """Return a vessel table, lengths in mm as in the paper."""
    lines = [f"# {SYNTHETIC_NOTICE}; vessels as published", "name,parent,length [mm],radius [mm]"]
    for row, name in enumerate(network.name):
        parent = network.name[network.parent[row]] if network.parent[row] >= 0 else ""
        lines.append(f"{name},{parent},{10 * network.length[row]:.6g},{10 * network.radius[row]:.6g}")
    return "\n".join(lines) + "\n"


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
        time, _, columns = lines[row].split("\t", 2)
        lines[row] = f"{time}\tNaN\t{columns}"
    return "\n".join(lines)
