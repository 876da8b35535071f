"""What a person decides of single beats counts more than any rule, and the file of it can be read and written."""

import warnings
from pathlib import Path
from tempfile import mkdtemp

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from small_study import make_study_in

import vasowave as vw
from lab_files import exported, recorded
from vasowave.base import InputError, VasowaveWarning
from vasowave.catheter.beats import edits_text
from vasowave.study.results import animal_key, load_animal


@pytest.fixture(scope="module")
def raw():
    return recorded(1, mean=15.0)


@pytest.fixture(scope="module")
def plain(raw):
    return vw.average_beats(raw, 10)


def middle(beat):
    return 0.5 * (beat.start + beat.end)


def codes(average):
    return {one.code for one in average.findings}


def test_a_beat_that_is_rejected_by_hand_is_not_averaged_and_says_so(raw, plain):
    chosen = next(beat for beat in plain.beats if beat.averaged)
    edited = vw.average_beats(raw, 10, edits=[vw.BeatEdit("reject", middle(chosen))])
    beat = next(one for one in edited.beats if one.start == chosen.start)
    assert not beat.averaged
    assert beat.rejected.code == "beat.hand"
    assert "recording.beats-edited" in codes(edited)
    assert sum(one.averaged for one in edited.beats) == 10


def test_a_beat_that_a_rule_rejects_can_be_kept(raw, plain):
    """With nothing but kept beats to choose from, the rejected one is among the averaged ones."""
    lost = next(beat for beat in plain.beats if beat.rejected and 1 < beat.start < 8)
    others = [beat for beat in plain.beats if not beat.rejected]
    near = sorted(others, key=lambda one: abs(one.start - lost.start))[:9]
    edits = [vw.BeatEdit("keep", middle(lost))]
    edits += [vw.BeatEdit("reject", middle(one)) for one in others if one not in near]
    with warnings.catch_warnings():  # of the many that were rejected
        warnings.simplefilter("ignore", VasowaveWarning)
        edited = vw.average_beats(raw, 10, edits=edits)
    assert lost.start in {one.start for one in edited.beats if one.averaged}


def test_the_mean_cycle_is_that_of_the_beats_which_are_left(raw, plain):
    """The mean pressure is that of the samples between the first and the last averaged beat, counted here by hand."""
    edits = [vw.BeatEdit("reject", middle(one)) for one in plain.beats if one.averaged][:2]
    edited = vw.average_beats(raw, 10, drift="warn", edits=edits)
    mean = np.mean([raw.pressure[(raw.time >= one.start) & (raw.time < one.end)].mean()
                    for one in edited.beats if one.averaged])  # fmt: skip
    assert edited.recording.mean_pressure == pytest.approx(mean, abs=0.05)  # samples at the beats' ends


def test_a_beat_begins_where_it_is_moved_to_and_the_one_before_it_ends_there(raw, plain):
    beat = plain.beats[20]
    edited = vw.average_beats(raw, 10, edits=[vw.BeatEdit("move", beat.start + 0.002, beat.start - 0.005)])
    assert edited.beats[20].start == pytest.approx(beat.start - 0.005, abs=1e-12)
    assert edited.beats[19].end == edited.beats[20].start
    assert edited.beats[21].start == plain.beats[21].start


@pytest.mark.parametrize(
    "edit", [vw.BeatEdit("reject", 500.0), vw.BeatEdit("move", 3.0, 7.0), vw.BeatEdit("move", 80.0, 80.01)]
)
def test_an_edit_that_meets_no_beat_changes_nothing_and_is_told(raw, plain, edit):
    with pytest.warns(VasowaveWarning, match="meets no beat"):
        edited = vw.average_beats(raw, 10, edits=[edit])
    assert np.array_equal(edited.recording.pressure, plain.recording.pressure)
    assert "recording.edit-without-beat" in codes(edited)


times = st.integers(0, 10**6).map(lambda count: count / 1000)
edits = st.one_of(
    st.builds(vw.BeatEdit, st.sampled_from(["reject", "keep"]), times, st.none()),
    st.builds(vw.BeatEdit, st.just("move"), times, times),
)


@given(st.lists(edits, max_size=6))
def test_edits_survive_their_file(tmp_path_factory, some):
    path = Path(mkdtemp(dir=tmp_path_factory.getbasetemp())) / "beats.csv"
    path.write_text(edits_text(some), encoding="utf-8")
    assert sorted(vw.read_edits(path), key=str) == sorted(some, key=str)


@pytest.mark.parametrize(
    ("line", "said"),
    [("rejct,1.0,", "did you mean 'reject'"), ("move,1.0,", "a move needs"), ("keep,1.0,2.0", "leaves empty"),
     ("reject,soon,", "not a time"), ("reject,-1,", "not a time")],
)  # fmt: skip
def test_a_wrong_line_is_named(tmp_path, line, said):
    path = tmp_path / "beats.csv"
    path.write_text(f"action,time [s],to [s]\nkeep,1,\n{line}\n", encoding="utf-8")
    with pytest.raises(InputError, match=rf"line 3.*{said}"):
        vw.read_edits(path)


def made(folder, cells=""):
    make_study_in(folder, [vw.virtual_mouse(seed=seed) for seed in range(2)])
    (folder / "raw.txt").write_text(exported(recorded(3, mean=16.0)), encoding="utf-8")
    titles = "animal,group,network,recording,kind,beat edits,zero [mmHg]\n"
    (folder / "animals.csv").write_text(f"{titles}one,CTL,n.csv,raw.txt,raw,{cells}\n", encoding="utf-8")
    study = vw.read_study(folder)
    return load_animal(study.animals[0], study.settings, folder), animal_key(study.animals[0], study.settings, folder)


def test_a_study_follows_the_edits_of_its_table_and_a_changed_file_is_another_animal(tmp_path):
    plain, key = made(tmp_path / "a", ",")
    beat = next(one for one in plain.beats.beats if one.averaged)
    path = tmp_path / "beats.csv"
    path.write_text(edits_text([vw.BeatEdit("reject", middle(beat))]), encoding="utf-8")
    edited, other = made(tmp_path / "b", "../beats.csv,")
    assert beat.start not in {one.start for one in edited.beats.beats if one.averaged}
    assert key != other


def test_the_zero_of_the_transducer_is_subtracted(tmp_path):
    plain, _ = made(tmp_path / "a", ",")
    lower, _ = made(tmp_path / "b", ",1.5")
    assert lower.recording.mean_pressure == pytest.approx(plain.recording.mean_pressure - 1.5, abs=1e-9)
