"""Comments of a recording are shown, choose the stretch, and explain steps beside them."""

import numpy as np
import pytest

from vasowave.base import VasowaveWarning
from vasowave.catheter.baseline import baseline_findings, with_comments
from vasowave.catheter.read import describe_recording, read_raw_recording
from vasowave.catheter.signals import Comment, comment_findings, is_intervention
from vasowave.pulse.cycle import Baseline, LevelStep


@pytest.mark.parametrize(
    "text",
    ["sildenafil 1 mg/kg i.v.", "10 % O2", "hypoxia on", "Injektion", "bolus", "NO 20 ppm", "50 µl saline", "U46619",
     "noradrenaline", "IVC occlusion", "after ligation", "PEEP 5", "FiO2 0.1"],
)  # fmt: skip
def test_drugs_doses_gases_and_manoeuvres_are_interventions(text):
    assert is_intervention(text)


@pytest.mark.parametrize(
    "text", ["baseline", "catheter in MPA", "calibration 20 mmHg", "zero", "start recording", "mouse 12, 24 g", "moved"]
)
def test_remarks_on_the_recording_are_none(text):
    assert not is_intervention(text)


def written(path, remark, at, before, after):
    """Write 12 s of a mouse whose mean pressure, mmHg, changes within a second after a remark."""
    time = np.arange(0.0, 12.0, 1e-3)
    beat = np.sin(np.pi * np.clip(((time / 0.11) % 1 - 0.1) / 0.8, 0, 1)) ** 2
    mean = before + (after - before) / (1 + np.exp(-(time - at - 1) / 0.2))
    rows = (
        f"{t:.3f}\t{p:.3f}\t{q:.4f}\t{f'#* {remark}' if i == round(at * 1000) else ''}"
        for i, (t, p, q) in enumerate(zip(time, mean - 6 + 15 * beat, 0.4 * beat, strict=True))
    )
    head = ["Interval=\t0.001 s", "ChannelTitle=\tPAP\tFlow", "UnitName=\tmmHg\tml/s"]
    path.write_text("\n".join([*head, *rows, ""]), encoding="utf-8")
    return path


def test_what_is_before_a_drug_is_averaged_and_how_to_choose_the_other_side_is_said(tmp_path):
    path = written(tmp_path / "raw.txt", "sildenafil 1 mg/kg i.v.", 7.0, 42.0, 31.0)
    with pytest.warns(VasowaveWarning, match="sildenafil 1 mg/kg i.v.' is noted at 7 s, so that what is before it"):
        raw = read_raw_recording(path)
    assert (raw.origin, raw.origin + raw.duration) == pytest.approx((0.0, 7.0))
    assert raw.beside == ()  # what is after the drug says nothing of the drift before it
    whole = np.mean(42.0 - 6 + 15 * np.sin(np.pi * np.clip((np.arange(1000) / 1000 - 0.1) / 0.8, 0, 1)) ** 2)
    assert raw.pressure.mean() == pytest.approx(whole, rel=0.01)
    assert "comments: 'sildenafil 1 mg/kg i.v.' at 7 s" in str(describe_recording(path))
    later = read_raw_recording(path, start=9.0)
    assert later.pressure.mean() == pytest.approx(whole - 11, rel=0.01)
    assert [one.code for one in later.notes if "interven" in one.code] == []


def test_where_too_little_is_before_the_first_intervention_what_is_after_it_is_read_and_said():
    part, around, found = comment_findings((Comment(1.0, "bolus"), Comment(0.5, "zero")), 60.0, None, None)
    assert part == around == (1.0, 60.0)
    assert [one.code for one in found] == ["recording.comments", "recording.intervention"]
    assert "what is after it was read, 1 to 60 s" in str(found[1])


def test_an_intervention_within_a_stretch_that_was_asked_for_is_told():
    part, around, found = comment_findings((Comment(30.0, "bolus"), Comment(50.0, "dose 2")), 90.0, 20.0, 40.0)
    assert part == (20.0, 40.0)
    assert around == (0.0, 50.0)
    assert [dict(one.values)["time"] for one in found if one.code.endswith("within")] == [30.0]


def test_a_step_beside_a_comment_is_not_called_an_instruments_and_stays():
    time = np.arange(10.0)
    baseline = Baseline(time, time, 2.0 * (time > 4), (LevelStep(4.5, 2.0),), 0.01, 0.0, removed=True)
    comments = (Comment(3.0, "clamp"),)
    told = [str(one) for one in baseline_findings(baseline, 0.0, 1.0, comments) if "step" in one.code]
    assert "beside the comment 'clamp' at 3 s, so that it may be the animal's" in told[0]
    assert with_comments(baseline, comments).own == "'clamp' is noted at 3 s"
    assert with_comments(baseline, (Comment(20.0, "clamp"),)).own == ""
