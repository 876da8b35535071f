"""Everyday faults of a recording are mended at the desk, at a click or two, and no raw file is touched."""

import numpy as np
import pytest

import vasowave as vw
from vasowave.catheter import synthetic_raw_recording
from vasowave.catheter.read import read_raw_recording
from vasowave.pulse.network import write_network
from vasowave.study.entering import new_study, read_rows
from vasowave.workbench import Desk, Workplace, act, checked


@pytest.fixture(scope="module")
def true_animal():
    made = synthetic_raw_recording(vw.virtual_mouse(), np.random.default_rng(31), duration=8.0)
    return made.raw, float(vw.average_beats(made.raw).recording.flow.mean())


def study_of(folder, raw, flow, titles=("time [s]", "pressure [mmHg]", "flow [ml/s]")):
    new_study(folder, ["CTL"])
    rows = np.column_stack([raw.time, raw.pressure, flow])
    np.savetxt(folder / "recordings/a.csv", rows, "%.6g", ",", header=",".join(titles), comments="")
    write_network(vw.control_network(), folder / "networks/lung.csv")
    table = "animal,group,network,recording,kind\nrat 1,CTL,networks/lung.csv,recordings/a.csv,raw\n"
    (folder / "animals.csv").write_text(table, "utf-8")
    return Workplace.around(Desk(folder))


def pressed(place, *labels):
    """Press the button whose label begins so, beside whatever stands on the desk; return how often one was pressed."""
    for label in labels:
        problems = checked(place.desk)["problems"]
        remedies = [one for problem in problems for one in problem["remedies"] if one["label"].startswith(label)]
        assert remedies, [(problem["text"], problem["remedies"]) for problem in problems]
        for message in remedies[0]["acts"]:
            act(place, message)


def cardiac_output(place):
    return place.recordings.described(place.desk, "rat 1")["indices"]["CO"]


@pytest.mark.parametrize(
    "offset", [0.06, *(pytest.param(offset, marks=pytest.mark.validation) for offset in (-0.05, 0.15))]
)
def test_a_flow_whose_zero_is_off_is_mended_by_a_button_and_its_mean_is_within_5_percent(tmp_path, true_animal, offset):
    raw, true_mean = true_animal
    place = study_of(tmp_path / "study", raw, raw.flow + offset * np.ptp(raw.flow))
    before = (tmp_path / "study/recordings/a.csv").read_bytes()
    pressed(place, "Flow zero at")
    (row,) = read_rows(tmp_path / "study/animals.csv").rows
    assert float(row["flow zero [ml/s]"]) == pytest.approx(offset * np.ptp(raw.flow), abs=0.05 * true_mean)
    assert cardiac_output(place) == pytest.approx(true_mean, rel=0.05)
    assert (tmp_path / "study/recordings/a.csv").read_bytes() == before


def test_a_probe_on_backward_is_turned_by_a_button_also_one_whose_zero_is_off(tmp_path, true_animal):
    raw, true_mean = true_animal
    place = study_of(tmp_path / "turned", raw, -raw.flow)
    pressed(place, "Turn the flow")
    assert cardiac_output(place) == pytest.approx(true_mean, rel=0.01)
    place = study_of(tmp_path / "both", raw, -(raw.flow + 0.05 * np.ptp(raw.flow)))
    pressed(place, "Turn the flow", "Flow zero at")
    assert cardiac_output(place) == pytest.approx(true_mean, rel=0.05)


def test_channels_that_no_title_names_are_named_by_buttons_and_offered_where_the_recording_is_looked_at(
    tmp_path, true_animal
):
    raw, true_mean = true_animal
    place = study_of(tmp_path / "study", raw, raw.flow, ("time [s]", "Ch 1 [mmHg]", "Ch 2"))
    described = place.recordings.described(place.desk, "rat 1")
    assert "flow" in described["error"]
    assert [title for title, *_ in described["channels"]] == ["Ch 1", "Ch 2"]
    pressed(place, "flow is 'Ch 2'", "The flow is in ml/s")
    assert cardiac_output(place) == pytest.approx(true_mean, rel=0.01)


def test_a_flow_that_is_dead_from_a_time_on_is_averaged_before_it_at_a_click(tmp_path, true_animal):
    raw, true_mean = true_animal
    flow = np.where(raw.time < 4.5, raw.flow, 0.0)
    place = study_of(tmp_path / "study", raw, flow)
    pressed(place, "Average ")
    (row,) = read_rows(tmp_path / "study/animals.csv").rows
    assert float(row["end [s]"]) == pytest.approx(4.5, abs=0.2)
    assert cardiac_output(place) == pytest.approx(true_mean, rel=0.05)


def test_the_argument_that_python_shows_below_an_error_mends_it(tmp_path, true_animal):
    raw, _ = true_animal
    study_of(tmp_path / "study", raw, raw.flow, ("time [s]", "Ch 1 [mmHg]", "Ch 2"))
    with pytest.raises(vw.errors.InputError) as caught:
        read_raw_recording(tmp_path / "study/recordings/a.csv")
    line = next(note for note in caught.value.__notes__ if "Ch 2" in note)
    arguments = eval(f"dict({line})", {}) | {"flow_unit": "ml/s"}
    assert read_raw_recording(tmp_path / "study/recordings/a.csv", **arguments).flow.size == raw.flow.size
