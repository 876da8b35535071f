"""The catheter of a study: a known one is undone before anything is computed, a suspected one is said."""

from dataclasses import replace

import numpy as np
import pytest

from vasowave.errors import InputError
from vasowave.recording import Catheter, correct_catheter, suspect_catheter
from vasowave.study import loading
from vasowave.study.loading import animal_key, load_animal
from vasowave.study.plan import read_study


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
    assert any("corrected for a catheter of 60 Hz" in str(note) for note in corrected.recording.notes)


def test_a_corrected_animal_is_another_one_for_the_results(make_study):
    folder = make_study()
    study = read_study(folder)
    variants = [replace(study.settings, catheter=one) for one in (None, (60, 0.3), (60, 0.4))]
    assert len({animal_key(study.animals[0], settings, folder) for settings in variants}) == 3


def test_a_suspected_catheter_is_said_with_what_it_means_for_the_pulse_and_what_to_do(make_study, monkeypatch):
    monkeypatch.setattr(loading, "suspect_catheter", lambda recording: Catheter(60.0, 0.3))
    animal = loaded(make_study())
    note = next(note for note in animal.recording.notes if "rang at about 60 Hz (damping 0.3)" in str(note))
    true = np.ptp(correct_catheter(animal.recording, Catheter(60.0, 0.3)).pressure)
    assert f"the pulse pressure is {true:.3g} mmHg, not {np.ptp(animal.recording.pressure):.3g}" in str(note)
    assert "`catheter: [natural frequency, damping]`" in str(note)
    assert suspect_catheter(animal.recording) is None  # none is suspected by itself


def test_a_suspicion_that_cannot_be_corrected_is_said_and_stops_nobody(make_study, monkeypatch):
    monkeypatch.setattr(loading, "suspect_catheter", lambda recording: Catheter(3.0, 0.1))
    animal = loaded(make_study())
    assert any(
        "3 Hz" in str(note) and "what it lost cannot be recovered" in str(note) for note in animal.recording.notes
    )


def test_a_catheter_without_damping_is_refused(make_study):
    with pytest.raises(InputError, match="catheter"):
        read_study(make_study(settings="groups: [CTL, HPH]\ncatheter: [60, 0]\n"))
