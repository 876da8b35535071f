"""The recordings to practise on hold what the tutorial says of them."""

import numpy as np
import pytest

from vasowave import average_beats, read_raw_recording
from vasowave.base import InputError
from vasowave.study.datasets import write_lab_files


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    folder = tmp_path_factory.mktemp("practice") / "lab"
    return folder, write_lab_files(folder)


def test_there_are_three_animals_in_each_of_two_groups_and_a_lung_for_each_group(lab):
    folder, files = lab
    names = sorted(str(file.relative_to(folder)) for file in files)
    mice = [f"{group}/mouse {number}.txt" for group in ("control", "hypoxia") for number in (1, 2, 3)]
    assert names == sorted([*mice, "lung control.csv", "lung hypoxia.csv"])


def test_one_recording_has_a_gap_that_reading_names(lab):
    folder, _ = lab
    with pytest.raises(InputError, match=r"no samples from 3\.5 to 3\.7 s.*\nstart=3\.7, end=10"):
        read_raw_recording(folder / "control" / "mouse 2.txt")


def test_one_transducer_drifts_by_what_is_said(lab):
    folder, _ = lab
    names = [f"{group}/mouse {number}" for group in ("control", "hypoxia") for number in (1, 2, 3)]
    drifts = {}
    for name in names:
        raw = read_raw_recording(folder / f"{name}.txt", start=3.7 if name == "control/mouse 2" else 0.0)
        drifts[name] = np.polyfit(raw.time, raw.pressure, 1)[0] * 60  # mmHg/min
    assert drifts.pop("hypoxia/mouse 2") == pytest.approx(9.0, abs=1.5)
    assert max(map(abs, drifts.values())) < 3.0


@pytest.mark.filterwarnings("ignore:.*drifts", "ignore:.*rejected")
def test_the_hypoxic_group_has_the_higher_mean_pressure(lab):
    folder, _ = lab

    def mean(group, number):
        raw = read_raw_recording(folder / group / f"mouse {number}.txt", start=3.7)
        return average_beats(raw).recording.pressure.mean()

    control, hypoxia = ([mean(group, number) for number in (1, 2, 3)] for group in ("control", "hypoxia"))
    assert np.mean(hypoxia) > 1.3 * np.mean(control)


def test_the_same_seed_writes_the_same_bytes(lab, tmp_path):
    _, files = lab
    again = write_lab_files(tmp_path / "lab")
    assert [file.read_bytes() for file in again] == [file.read_bytes() for file in files]


def test_a_folder_that_holds_something_is_refused(tmp_path):
    (tmp_path / "mine.txt").write_text("notes", encoding="utf-8")
    with pytest.raises(InputError, match="not an empty folder"):
        write_lab_files(tmp_path)
    assert [one.name for one in tmp_path.iterdir()] == ["mine.txt"]
