"""Settings are declared once: what is made from the declaration follows it, and the type checker sees it."""

import json
import pickle
from dataclasses import FrozenInstanceError, asdict, is_dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import vasowave as vw
from vasowave.base import InputError, settings_of
from vasowave.cli import app
from vasowave.lung import Options
from vasowave.study.entering import written
from vasowave.study.folder import StudyFile, animal_settings, parse_settings

EARLIER = json.loads((Path(__file__).parent / "study" / "stored_settings.json").read_text("utf-8"))
"""What an index and a key held before settings were classes: dump of the study file, of `averaging`, and the key."""


def test_settings_that_an_earlier_version_stored_are_read_and_lead_to_the_same_keys():
    study = StudyFile(**EARLIER["dump"])
    said = json.loads(json.dumps(asdict(study)))
    assert said.pop("design") == json.loads(json.dumps(asdict(vw.Design())))  # which it did not know of
    assert said.pop("site") == "pulmonary artery"  # nor of others
    assert said["calibration"].pop("viscous") is None  # nor of this
    assert said["report"].pop("lung_sd") is None  # nor of this
    assert said["calibration"].pop("enters") is None  # nor of this
    assert {name for name, value in said.items() if value is None} >= set(said) - set(EARLIER["dump"])  # nor of these
    assert {name: said[name] for name in EARLIER["dump"]} == EARLIER["dump"]
    assert json.loads(json.dumps(asdict(study.averaging))) == EARLIER["averaging"]
    assert animal_settings(study).as_json() == EARLIER["key"]


def test_a_study_file_in_yaml_and_in_python_is_the_same_value():
    lines = [
        f"{name}: {{{', '.join(f'{key}: {said(one)}' for key, one in value.items())}}}"
        if isinstance(value, dict)
        else f"{name}: {said(value)}"
        for name, value in EARLIER["dump"].items()
    ]
    found, problems = parse_settings("\n".join(lines).encode())
    assert problems == []
    assert found == StudyFile(**EARLIER["dump"])


def said(value):
    return "" if value is None else written(value)


def with_sections(*kinds):
    """Yield classes of settings and those of the sections in them."""
    for kind in kinds:
        yield kind
        yield from with_sections(*(one.section for one in settings_of(kind).values() if one.section))


@pytest.mark.parametrize(
    "kind", dict.fromkeys(with_sections(StudyFile, vw.Settings, vw.Search, vw.Averaging, vw.Priors, Options))
)
def test_every_setting_says_what_it_means_and_its_values_cannot_be_changed(kind):
    values = kind()
    for name, one in settings_of(kind).items():
        assert one.meaning.endswith((".", "note says which).")) or one.section, name
        assert one.section is None or is_dataclass(one.section)
        with pytest.raises(FrozenInstanceError):
            setattr(values, name, None)
    assert repr(pickle.loads(pickle.dumps(values))) == repr(values)
    assert repr(replace(values)) == repr(values)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: vw.Search(starts=0), "starts: 0 is too small; at least 1"),
        (lambda: vw.Search(starts=2.5), "starts: 2.5 is not a whole number"),
        (
            lambda: vw.Search(method="spq"),
            r"method: 'spq' is not known \(did you mean 'sqp'\?\); choose from: least-sq",
        ),
        (lambda: vw.Search(bounds={"beta": (3, 2)}), "bounds.beta: 3 is not below 2"),
        (lambda: vw.Search(bounds={"beta": 3}), r"bounds.beta: write a list"),
        (lambda: vw.Search(fixed=3), "fixed: write 'name: value'"),
        (lambda: vw.Search(sees=3), r"no setting 'sees' \(did you mean 'seed'\?\); choose from: starts, "),
        (lambda: vw.Search(**{"self": 3}), "no setting 'self'"),
        (lambda: vw.Search(1, "sqp", False, {}, {}, "all", 0, None, "flow", 8), "argument"),
        (lambda: vw.Search(1, "spq"), "method: 'spq' is not known"),
        (lambda: replace(vw.Numerics(), tolerance=np.inf), "tolerance: inf is not a number; give a finite one"),
        (lambda: vw.Settings(walls=("linear", "linear")), "choose at least one, each once"),
        (lambda: vw.Numerics(accuracy=0.1, cycles_from_rest=8), "accuracy chooses steps and cycles"),
        (lambda: StudyFile(calibration={"starts": "x"}), "calibration.starts: 'x' is not a whole number"),
        (lambda: StudyFile(groups=None), "groups: write a list"),
        (lambda: vw.Numerics(tolerance="1,5"), "tolerance: '1,5' is not a number; write a decimal point"),
        (lambda: Options(root="1,2"), "root: '1,2' is not a place"),
        (lambda: Options(cannula=3), "cannula: 3 is too large; it must be below 2"),
    ],
)
def test_a_wrong_setting_is_one_sentence_in_python_too(make, words):
    with pytest.raises(InputError, match=words) as caught:
        make()
    assert "\n" not in str(caught.value)
    assert "pydantic" not in str(caught.value)


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ("animals: Mice.XLSX\n", "rows are added to CSV only; save it as CSV"),
        ("no such key: 1\n", "mend the study file"),
    ],
)
def test_rows_are_added_neither_to_a_workbook_nor_under_a_broken_study_file(tmp_path, settings, words):
    (tmp_path / "study.yaml").write_text(settings, "utf-8")
    (tmp_path / "lung.csv").write_text("name,parent,length [cm],radius [cm]\na,,0.4,0.05\n", "utf-8")
    told = CliRunner().invoke(app, ["add", str(tmp_path), str(tmp_path / "lung.csv")])
    assert told.exit_code != 0
    assert words in str(told.exception)
