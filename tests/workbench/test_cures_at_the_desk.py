"""Everyday faults of a recording are mended at the desk, at a click or two, and no raw file is touched."""

import numpy as np
import pytest

import vasowave as vw
from vasowave.catheter import synthetic_raw_recording
from vasowave.catheter.read import read_raw_recording
from vasowave.pulse.network import write_network
from vasowave.study.entering import new_study, read_rows
from vasowave.study.folder import read_settings
from vasowave.workbench import Desk, Workplace, act, checked, shown

UNITS_OF_PRESSURE = [("mmHg", 1.0), ("kPa", 760.0 / 101.325)]


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
    "offset", [0.06, *(pytest.param(offset, marks=pytest.mark.validation) for offset in (-0.05, 0.15, 0.5))]
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


def test_a_pressure_that_says_no_unit_is_offered_in_the_usual_ones_with_the_mean_that_each_would_make(
    tmp_path, true_animal
):
    raw, _ = true_animal
    place = study_of(tmp_path / "study", raw, raw.flow, ("time [s]", "PAP", "flow [ml/s]"))
    (problem,) = [one for one in checked(place.desk)["problems"] if one["error"]]
    labels = [remedy["label"] for remedy in problem["remedies"][:2]]
    mean = raw.pressure.mean()
    expected = [f"The pressure is in {unit}: mean {mean * factor:.3g} mmHg" for unit, factor in UNITS_OF_PRESSURE]
    assert labels == expected
    pressed(place, "The pressure is in mmHg")
    assert place.recordings.described(place.desk, "rat 1")["indices"]["mPAP"] == pytest.approx(mean, rel=0.02)


def test_a_column_that_differs_between_groups_is_adjusted_for_beside_those_that_are_already(tmp_path, true_animal):
    raw, _ = true_animal
    place = study_of(tmp_path / "study", raw, raw.flow)
    rows = [f"rat {k},{'HPH' if k > 3 else 'CTL'},networks/lung.csv,recordings/a.csv,raw,yes,{sex},{weight}"
            for k, (sex, weight) in enumerate(zip("mmffmf", (300, 310, 305, 320, 309, 330)), 1)]  # fmt: skip
    header = "animal,group,network,recording,kind,shared recording,sex,weight [g]"
    (tmp_path / "study/animals.csv").write_text("\n".join([header, *rows, ""]), "utf-8")
    act(place, {"do": "set-groups", "groups": ["CTL", "HPH"]})
    pressed(place, "Adjust the groups for weight", "Adjust the groups for sex")
    settings = read_settings(tmp_path / "study/study.yaml")[0]
    assert sorted(settings.design.covariates) == ["sex", "weight"]


def test_a_study_that_files_are_dropped_for_is_of_the_species_that_was_chosen(tmp_path, true_animal):
    raw, _ = true_animal
    study_of(tmp_path / "lab", raw, raw.flow)
    place = Workplace.around(Desk(tmp_path / "study"))
    folder = tmp_path / "study/recordings"
    folder.mkdir(parents=True)
    (tmp_path / "lab/recordings/a.csv").rename(folder / "a.csv")
    (folder / "notes.txt").write_text("a rat, awake", "utf-8")
    (folder / "animals.csv").write_text("ID,sex\na,f\n", "utf-8")
    files = [f"recordings/{name}" for name in ("a.csv", "animals.csv")]
    act(place, {"do": "add-files", "files": files, "species": "rat"})
    assert read_settings(tmp_path / "study/study.yaml")[0].species == "rat"
    assert shown(place.desk)["unlisted"] == []
