"""From a row of the table to an animal."""

from dataclasses import replace

import numpy as np
import pytest
from small_study import make_study_in

from vasowave.base import NumericalError, heart_rates_of
from vasowave.catheter import labchart_text, synthetic_raw_recording
from vasowave.catheter.beats import find_beats
from vasowave.pulse.cycle import Recording
from vasowave.pulse.examples import virtual_mouse
from vasowave.study.results import load_animal
from vasowave.study.running import read_study


def test_a_recording_that_says_it_is_synthetic_is_synthetic_whatever_the_table_says(tmp_path):
    folder = make_study_in(tmp_path / "study", [virtual_mouse()])
    table = folder / "animals.csv"
    table.write_text(table.read_text().replace(",yes", ","))
    study = read_study(folder)
    row = study.animals[0]
    assert not row.synthetic
    assert not load_animal(row, study.settings, folder).synthetic
    recording = row.recordings[0]
    recording.write_text("# SYNTHETIC: made, not measured\n" + recording.read_text())
    assert load_animal(row, study.settings, folder).synthetic


@pytest.mark.parametrize("ecg", [True, False])
@pytest.mark.parametrize("rate", [210.0, *(pytest.param(one, marks=pytest.mark.validation) for one in (245.0, 400.0))])
def test_the_heart_rates_looked_for_are_those_of_the_species_unless_they_are_given(tmp_path, rate, ecg):
    mouse = virtual_mouse()
    cycle = Recording(mouse.pressure, 5 * mouse.flow, 60.0 / rate)
    made = synthetic_raw_recording(cycle, np.random.default_rng(1), duration=24.0, sampling_rate=1000.0, ecg=ecg)
    folder = make_study_in(tmp_path / "study", [mouse])
    (folder / "recordings/0.csv").unlink()
    (folder / "recordings/0.txt").write_text(labchart_text(made.raw), "utf-8")
    table = (folder / "animals.csv").read_text("utf-8")
    (folder / "animals.csv").write_text(table.replace("0.csv", "0.txt"), "utf-8")

    def heart_rate(settings):
        (folder / "study.yaml").write_text(f"groups: [CTL]\n{settings}\n", "utf-8")
        study = read_study(folder)
        return 60.0 / load_animal(study.animals[0], study.settings, folder).recording.period

    for found in (
        "species: rat",
        "averaging: {heart_rates: [200, 600]}",
        "species: mouse\naveraging: {heart_rates: [200, 600]}",
    ):
        assert heart_rate(found) == pytest.approx(rate, rel=0.02)
    if rate < 250:
        for refused in ("", "species: rat\naveraging: {heart_rates: [260, 900]}"):
            with pytest.raises(NumericalError, match="name the species or the range"):
                heart_rate(refused)


@pytest.mark.parametrize("ecg", [True, False])
@pytest.mark.parametrize(
    ("species", "rate"),
    [
        ("human", 48.0),
        ("human", 110.0),
        ("pig", 95.0),
        ("dog", 150.0),
        ("rabbit", 240.0),
        ("other", 70.0),
        ("other", 530.0),
    ],
)
def test_beats_of_larger_animals_are_found_with_their_slower_waves(species, rate, ecg):
    """A mouse's recording played slower: waves, breaths and the complexes of the ECG all take as much longer."""
    mouse = virtual_mouse()
    slower = 60.0 / rate / mouse.period
    # 500 samples/s once it is slow
    fast = synthetic_raw_recording(
        mouse, np.random.default_rng(2), duration=12.0, sampling_rate=500.0 * slower, ecg=ecg
    ).raw
    slow = replace(fast, sampling_rate=fast.sampling_rate / slower)
    beats = find_beats(slow, heart_rates=heart_rates_of(species))
    expected = find_beats(fast)
    assert beats.heart_rate == pytest.approx(rate, rel=0.03)
    assert beats.fiducial == ("ecg" if ecg else "pressure")
    assert abs(len(beats.times) - len(expected.times)) <= 2
