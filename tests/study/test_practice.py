"""The paper's practice by one word, in a study and on the command line."""

from dataclasses import replace

import numpy as np
import pytest

import vasowave as vw
from vasowave.base import InputError
from vasowave.catheter import average_beats, synthetic_raw_recording
from vasowave.pulse.cycle import Recording, resample
from vasowave.pulse.network_formats import read_network
from vasowave.pulse.solver import PAPER
from vasowave.study.animal import recording_with_scatter
from vasowave.study.folder import animal_settings
from vasowave.study.results import load_animal
from vasowave.study.running import read_study


def test_the_papers_practice_is_one_word(make_study):
    folder = make_study(settings="groups: [CTL, HPH]\npractice: paper\n")
    study = read_study(folder)
    settings = animal_settings(study.settings)
    assert (settings.numerics, settings.blood) == (PAPER.numerics, PAPER.blood)
    assert settings.pressure_harmonics == "all"
    assert settings.paper_bounds
    animal = load_animal(study.animals[0], study.settings, folder)
    cells = animal.network.length / 0.025
    np.testing.assert_allclose(cells, np.rint(cells), atol=1e-9)
    assert np.all(animal.network.length <= read_network(folder / "n.csv").length + 1e-9)


@pytest.mark.parametrize(
    ("own", "named"),
    [("blood: {density: 1.06}", "blood"), ("calibration: {pressure_harmonics: 9}", r"calibration\.pressure_harmonics")],
)
def test_a_practice_and_what_it_sets_itself_are_refused_together(make_study, own, named):
    folder = make_study(settings=f"practice: paper\n{own}\n")
    with pytest.raises(InputError, match=f"practice 'paper' sets {named} itself"):
        read_study(folder)


def test_the_papers_practice_lets_no_pressure_enter(make_study):
    folder = make_study(settings="practice: paper\ncalibration: {enters: pressure}\n")
    with pytest.raises(InputError, match=r"practice 'paper' lets the flow enter; leave calibration\.enters out"):
        read_study(folder)


def test_an_averaged_recording_in_the_papers_practice_has_the_scatter_of_its_beats():
    """That program has a sample more than the cycle, and the scatter stands beside every one of them."""
    made = synthetic_raw_recording(vw.virtual_mouse(), np.random.default_rng(1), duration=6.0)
    average = average_beats(made.raw)
    data = recording_with_scatter(PAPER.recording(average.recording), average)
    assert data.sizes["time"] == len(average.recording.pressure) + 1
    assert float(data["pressure_sd"].mean()) == pytest.approx(float(average.pressure_sd.mean()), rel=0.02)


def test_the_papers_practice_by_command_compares_what_its_program_compares(shared, make_study):
    """All digits of what Python users do by hand (`test_measured_mouse`), so that fits of the two are the same."""
    mouse = shared / "mouse-c6"
    folder = make_study(settings="groups: [CTL, HPH]\npractice: paper\n")
    row = replace(
        read_study(folder).animals[0], recordings=(mouse / "pC6_1024.dat", mouse / "qC6_8192.dat"), period=0.11
    )
    recording = load_animal(row, read_study(folder).settings, folder).recording
    pressure, flow = np.loadtxt(mouse / "pC6_1024.dat"), np.loadtxt(mouse / "qC6_8192.dat")[:-1]
    np.testing.assert_array_equal(recording.pressure, np.roll(pressure, 1))
    np.testing.assert_array_equal(recording.flow, resample(flow, 1024))


def test_a_longer_recording_keeps_the_programs_number_of_lines():
    cycle = 15 + np.cos(2 * np.pi * np.arange(4000) / 4000)
    placed = PAPER.recording(Recording(cycle, 0.2 * cycle, 0.11))
    time = np.arange(1024) / 1023  # of its lines, in periods; sample k + 1 is line k
    np.testing.assert_allclose(placed.pressure[1:], 15 + np.cos(2 * np.pi * time[:-1]), atol=1e-12)
    assert len(placed.flow) == 1024
