"""The catheter of a study: a known one is undone before anything is computed, a suspected one is said."""

from dataclasses import replace

import numpy as np
import pytest

from vasowave.base import InputError
from vasowave.catheter.check import Catheter, LowPass, correct_catheter, ringing, suspect_catheter
from vasowave.catheter.read import read_recording
from vasowave.study.results import animal_key, load_animal
from vasowave.study.running import read_study


def loaded(folder, catheter=None):
    study = read_study(folder)
    return load_animal(study.animals[0], replace(study.settings, catheter=catheter), folder)


def test_the_catheter_of_the_study_is_undone_in_every_harmonic_with_signal(make_study):
    folder = make_study(settings="groups: [CTL, HPH]\ncatheter: [60, 0.3]\n")
    assert read_study(folder).settings.catheter == (60, 0.3)
    plain, corrected = loaded(folder), loaded(folder, (60, 0.3))
    before, after = (np.fft.rfft(one.recording.pressure)[:5] for one in (plain, corrected))
    response = Catheter(60.0, 0.3).response(np.arange(5) / plain.recording.period)
    np.testing.assert_allclose(after * response, before, rtol=1e-9)
    assert any("corrected for a response of second order, 60 Hz" in str(note) for note in corrected.recording.notes)


def test_a_corrected_animal_is_another_one_for_the_results(make_study):
    folder = make_study()
    study = read_study(folder)
    variants = [replace(study.settings, catheter=one) for one in (None, (60, 0.3), (60, 0.4))]
    assert len({animal_key(study.animals[0], settings, folder) for settings in variants}) == 3


def test_a_suspected_catheter_is_said_with_what_it_means_for_the_pulse_and_what_to_do(make_study):
    recording = loaded(make_study()).recording
    assert suspect_catheter(recording) is None  # none is suspected by itself
    note = str(ringing(Catheter(60.0, 0.3), recording))
    true = np.ptp(correct_catheter(recording, Catheter(60.0, 0.3)).pressure)
    assert "rang at about 60 Hz (damping 0.3)" in note
    assert f"the pulse pressure is {true:.3g} mmHg, not {np.ptp(recording.pressure):.3g}" in note
    assert "`catheter: [natural frequency, damping]`" in note
    beyond = str(ringing(Catheter(3.0, 0.1), recording))
    assert "3 Hz" in beyond
    assert "what it lost cannot be recovered" in beyond


def test_a_catheter_without_damping_is_refused(make_study):
    with pytest.raises(InputError, match="catheter"):
        read_study(make_study(settings="groups: [CTL, HPH]\ncatheter: [60, 0]\n"))


def with_columns(folder, header, *cells):
    lines = (folder / "animals.csv").read_text("utf-8").splitlines()
    rows = [",".join([lines[0], header]), *(",".join([line, *cells]) for line in lines[1:])]
    (folder / "animals.csv").write_text("\n".join(rows) + "\n", "utf-8")
    return read_study(folder)


def test_filters_of_both_signals_are_columns_and_are_undone_before_anything_is_computed(make_study):
    folder = make_study()
    plain = read_study(folder)
    study = with_columns(folder, "pressure cutoff [Hz],flow cutoff [Hz]", "60", "90")
    before, after = (load_animal(one.animals[0], one.settings, folder).recording for one in (plain, study))
    frequency = np.arange(5) / before.period
    for signal, cutoff in (("pressure", 60.0), ("flow", 90.0)):
        recorded, true = (np.fft.rfft(getattr(one, signal))[:5] for one in (before, after))
        np.testing.assert_allclose(true * LowPass(cutoff).response(frequency), recorded, rtol=1e-9)
        assert any(f"the {signal} was corrected" in str(note) for note in after.notes)
    keys = {animal_key(one.animals[0], one.settings, folder) for one in (plain, study)}
    assert len(keys) == 2


def test_a_response_of_second_order_is_told_for_an_animal_and_takes_the_place_of_the_studys_catheter(make_study):
    folder = make_study()
    (folder / "study.yaml").write_text((folder / "study.yaml").read_text("utf-8") + "catheter: [200, 0.1]\n", "utf-8")
    header = "pressure cutoff [Hz],pressure damping [1],flow cutoff [Hz],flow damping [1]"
    plain = read_study(folder)
    study = with_columns(folder, header, "70", "0.3", "900", "0.71")
    recording = load_animal(study.animals[0], study.settings, folder).recording
    before = load_animal(plain.animals[0], replace(plain.settings, catheter=None), folder).recording
    ratio = np.arange(5) / before.period / np.array([[70.0], [900.0]])
    responses = 1 / (1 - ratio**2 + 2j * np.array([[0.3], [0.71]]) * ratio)
    for signal, response in zip(("pressure", "flow"), responses, strict=True):
        recorded, true = (np.fft.rfft(getattr(one, signal))[:5] for one in (before, recording))
        np.testing.assert_allclose(true * response, recorded, rtol=1e-9)


def test_a_damping_without_its_frequency_is_refused_with_the_column_that_lacks(make_study):
    with pytest.raises(InputError, match=r"flow damping \[1\].*flow cutoff \[Hz\]"):
        with_columns(make_study(), "flow damping [1]", "0.7")


def test_a_cutoff_that_is_not_positive_is_refused_with_its_column(make_study):
    with pytest.raises(InputError, match=r"pressure cutoff \[Hz\]"):
        with_columns(make_study(), "pressure cutoff [Hz]", "0")


def test_delays_and_the_zero_of_the_flow_are_columns_too(make_study):
    folder = make_study()
    plain = read_study(folder)
    study = with_columns(folder, "flow zero [ml/s],pressure delay [s],flow delay [s]", "0.01", "0.004", "-0.002")
    before, after = (load_animal(one.animals[0], one.settings, folder).recording for one in (plain, study))
    turns = 2j * np.pi * np.arange(1, 9) / before.period
    for signal, delay in (("pressure", 0.004), ("flow", -0.002)):
        recorded, true = (np.fft.rfft(getattr(one, signal))[1:9] for one in (before, after))
        np.testing.assert_allclose(true * np.exp(-turns * delay), recorded, rtol=1e-6)
    assert after.cardiac_output == pytest.approx(before.cardiac_output - 0.01)


@pytest.mark.parametrize(("told", "late"), [("0", 6.0), ("0.006", None), ("-0.006", 12.0)])
def test_a_late_flow_is_told_by_what_a_given_delay_leaves_of_it(make_study, told, late):
    folder = make_study()
    file = read_study(folder).animals[0].recordings[0]
    cycle = read_recording(file)
    turns = np.exp(-2j * np.pi * np.arange(len(cycle.flow) // 2 + 1) * 0.006 / cycle.period)
    delayed = np.fft.irfft(np.fft.rfft(cycle.flow) * turns, len(cycle.flow))
    time = np.arange(len(cycle.flow)) * cycle.period / len(cycle.flow)
    signals = np.column_stack([time, cycle.pressure, delayed])
    np.savetxt(file, signals, "%.9f", ",", header="time [s],pressure [mmHg],flow [ml/s]", comments="")
    study = with_columns(folder, "flow delay [s]", told)
    notes = load_animal(study.animals[0], study.settings, folder).recording.notes
    found = [dict(one.values)["delay"] for one in notes if one.code == "recording.late-flow"]
    assert found == ([] if late is None else [pytest.approx(late, abs=1.5)])


def test_a_filter_below_the_heart_rate_is_refused(make_study):
    study = with_columns(make_study(), "pressure cutoff [Hz]", "5")
    with pytest.raises(InputError, match=r"cutoff of 5 Hz is below the heart rate, \d"):
        load_animal(study.animals[0], study.settings, study.folder)
