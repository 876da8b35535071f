import json

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from jsonschema import Draft202012Validator

import study_file
from vasowave.base import InputError, settings_of
from vasowave.study.entering import FOLDERS, new_study, schema_text, study_text, with_groups, with_values, written
from vasowave.study.folder import StudyFile, parse_settings, read_document


def said(text: str) -> list[str]:
    settings, problems = parse_settings(text.encode())
    assert settings is None
    return [str(problem) for problem in problems]


def test_the_template_is_the_default_study_and_its_schema_accepts_it():
    found, problems = parse_settings(study_text().encode())
    assert problems == []
    assert found == StudyFile()
    Draft202012Validator.check_schema(json.loads(schema_text()))
    Draft202012Validator(json.loads(schema_text())).validate(yaml.safe_load(study_text()))


def test_the_schema_refuses_what_the_reader_refuses():
    schema = Draft202012Validator(json.loads(schema_text()))
    for text in ("speces: mouse", "calibration: {starts: 0}", "calibration: {walls: [linaer]}", "blood: {density: -1}"):
        assert not schema.is_valid(yaml.safe_load(text))
        assert said(text)


def test_every_key_of_the_template_has_its_comment_and_example_lines_are_valid():
    lines = study_text().splitlines()
    for number, line in enumerate(lines):
        if line.strip() and not line.lstrip().startswith("#"):
            before = lines[number - 1].lstrip()
            assert before.startswith("#"), line
    uncommented = (
        study_text().replace("  bounds: {}\n  # bounds:", "  bounds:").replace("  fixed: {}\n  # fixed:", "  fixed:")
    )
    found, problems = parse_settings(uncommented.encode())
    assert problems == []
    assert found.calibration.bounds["beta"] == (10, 400)
    assert found.calibration.fixed == {"gamma": 2}


def test_all_slips_are_named_at_once_with_line_column_and_nearest_key():
    text = (
        "speces: rat\ncalibration:\n  starts: four\n  walls: [linear, tangnt]\n  bounds: {betta: [1, 2]}\n  seed: 1,5\n"
    )
    assert sorted(said(text)) == [
        "study.yaml, line 1, column 1: unknown key 'speces' (did you mean 'species'?); known here: "
        "title, animals, species, site, groups, image_pressure, catheter, practice, averaging, calibration, "
        "radius_scale_sd, length_scale_sd, k_sd, taper_sd, image_pressure_sd, flow_gain_sd, flow_delay_sd, zero_sd, "
        "flow_zero_sd, pressure_lag_sd, pressure_inertia_sd, flow_lag_sd, pressure_gain_sd, "
        "viscosity_sd, model_selection, noise_models, waves_at, inference, blood, numerics, design, report",
        "study.yaml, line 3, column 11: calibration.starts: 'four' is not a whole number; write one",
        "study.yaml, line 4, column 19: calibration.walls.1: unknown wall law 'tangnt' "
        "(did you mean 'tangent'?); choose from: linear, tangent, "
        "power, vein, or name a class of your own as module:Class",
        "study.yaml, line 5, column 12: calibration.bounds: 'betta' is not known (did you mean 'beta'?); "
        "choose from: beta, r1, r2, c1, p1, gamma, m",
        "study.yaml, line 6, column 9: calibration.seed: '1,5' is not a whole number; write one",
    ]


@pytest.mark.parametrize(
    ("text", "place", "words"),
    [
        ("starts: 4", "line 1, column 1", "belongs under 'calibration:'"),
        ("blood:\n  groups: [A]", "line 2, column 3", "belongs to the top level"),
        ("title:", "line 1, column 7", "empty"),
        (f"title: {'x' * 1001}", "line 1, column 8", "x…' is too long; at most 1000 letters"),
        ("groups: []", "line 1, column 9", "at least 1 must be given"),
        ("catheter: 60 Hz", "line 1, column 11", "write a list: [60, 0.4]"),
        ("catheter: [60]", "line 1, column 11", "write a list of two numbers: [60, 0.4]"),
        ("catheter: [1e-300, 0.4]", "line 1, column 12", "at least 0.1"),
        ("catheter: [60, 1e300]", "line 1, column 16", "at most 100"),
        ("averaging:\n  samples: 100000000", "line 2, column 12", "too large; at most 65536"),
        ("#" + "x" * (1 << 20), "", "larger than 1 MiB"),
        ("calibration:\n  bounds: {c1: [3, 2]}", "line 2, column 16", "3 is not below 2"),
        ("groups: [A, B, A]", "line 1, column 9", "'A' is listed twice"),
        ("groups: [Sham, HPH, sham]", "line 1, column 9", "groups 'Sham' and 'sham' differ by capitals alone"),
        ("blood:\n  density: 1,06", "line 2, column 12", "decimal point"),
        ("blood:\n  density: nan", "line 2, column 12", "finite"),
        ("averaging: 5", "line 1, column 12", "indented lines"),
        ("calibration:\n\tstarts: 5", "line 2, column 1", "tabs"),
        ("title: a\ntitle: b", "line 2, column 1", "a second time (first in line 1)"),
        ("title: &a x\nanimals: *a", "line 2, column 1", "alias"),
        ("- 1", "line 1", "key: value"),
    ],
)
def test_a_slip_is_named_where_it_stands(text, place, words):
    (message,) = said(text)
    assert place in message
    assert words in message


def test_numbers_and_labels_mean_what_they_look_like():
    found, _ = parse_settings(b"groups: [no, 1]\nnumerics: {tolerance: 1e-8}\ncalibration:\naveraging: {harmonics: }\n")
    assert found.groups == ["no", "1"]  # YAML 1.1 would make False and 1 of them
    assert found.numerics.tolerance == 1e-8  # and text of this
    assert found.calibration == StudyFile().calibration
    assert found.averaging.harmonics is None


@pytest.mark.parametrize("text", ["[" * 5000, "a: " + "{b: " * 3000, "\xff\xfe", "x: \x00", "? [a]\n: 1", "a: &x [*x]"])
def test_what_is_no_study_file_is_named_and_not_a_crash(text):
    found, problems = parse_settings(text.encode("latin-1"))
    assert found is None
    assert all(str(problem).startswith("study.yaml") for problem in problems)


KEYS = st.sampled_from([*settings_of(StudyFile), "starts", "walls", "bounds", "beta", "density", "cell_size", "x"])
LEAVES = (
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8) | st.sampled_from(["linear", "CTL"])
)
TREES = st.recursive(LEAVES, lambda t: st.lists(t, max_size=3) | st.dictionaries(KEYS, t, max_size=4), max_leaves=12)


@given(st.dictionaries(KEYS, TREES, max_size=5))
@settings(max_examples=150, deadline=None)
def test_any_tree_of_values_is_understood_or_refused_with_a_place(result):
    found, problems = parse_settings(yaml.safe_dump(result, allow_unicode=True).encode())
    assert (found is None) == bool(problems)
    assert all(problem.place.file == "study.yaml" and str(problem.finding) for problem in problems)


@given(st.binary(max_size=60) | st.text("ab:[]{}-&*!|>#'\"\n\t %@?,1", max_size=60).map(str.encode))
@settings(max_examples=300, deadline=None)
def test_any_bytes_are_understood_or_refused(raw):
    found, problems = parse_settings(raw)
    assert (found is None) == bool(problems)


@given(st.integers(0, 10**6), st.binary(min_size=1, max_size=3))
@settings(max_examples=150, deadline=None)
def test_a_damaged_template_is_understood_or_refused(at, damage):
    raw = study_text().encode()
    at %= len(raw)
    found, problems = parse_settings(raw[:at] + damage + raw[at + len(damage) :])
    assert (found is None) == bool(problems)


def test_new_changes_nothing_where_a_study_is(tmp_path):
    written = new_study(tmp_path / "s")
    assert sorted(path.name for path in (tmp_path / "s").iterdir()) == sorted([*FOLDERS, *(p.name for p in written)])
    (tmp_path / "s" / "study.yaml").write_text("title: mine\n")
    (tmp_path / "s" / "animals.csv").unlink()
    with pytest.raises(ValueError, match=r"study.yaml exists already"):
        new_study(tmp_path / "s")
    assert (tmp_path / "s" / "study.yaml").read_text() == "title: mine\n"
    assert not (tmp_path / "s" / "animals.csv").exists()


def test_the_documentation_lists_every_key_and_column_as_the_program_knows_it():
    assert study_file.PAGE.read_text(encoding="utf-8") == study_file.page(), "run `uv run python tools/study_file.py`"


def test_a_label_with_a_comma_stays_one_when_groups_are_written_anew(tmp_path):
    labels = ["HPH, drug", "CTL", "sham (1)"]
    assert parse_settings(study_text(labels).encode())[0].groups == labels
    (tmp_path / "study.yaml").write_text('groups: ["HPH, drug", CTL]\n', encoding="utf-8")
    assert parse_settings(with_groups(tmp_path / "study.yaml", labels).encode())[0].groups == labels
    assert yaml.safe_load(written({"a, b": ["c, d", 1.5]})) == {"a, b": ["c, d", 1.5]}


def test_a_name_with_a_comma_and_no_quotes_is_told_so():
    (first, second) = said("design:\n  contrasts: {rescue: {HPH, drug: 1, HPH, vehicle: -1}}")
    assert "line 2, column 24" in first
    assert "'HPH' has no value; a name that holds a comma stands in quotation marks" in first
    assert "column 38" in second
    found, problems = parse_settings(b'design:\n  contrasts: {rescue: {"HPH, drug": 1, "HPH, vehicle": -1}}')
    assert problems == []
    assert found.design.contrasts == {"rescue": {"HPH, drug": 1, "HPH, vehicle": -1}}


def test_a_species_that_is_not_known_is_named_before_anything_is_written(tmp_path):
    with pytest.raises(InputError, match=r"species 'mosue' is not known \(did you mean 'mouse'\?\); there are: mouse"):
        new_study(tmp_path / "s", species="mosue")
    with pytest.raises(InputError, match=r"'guinea pig' is not known; .* other \(any that is not named before it\)"):
        new_study(tmp_path / "s", species="guinea pig")
    assert not (tmp_path / "s").exists()


def test_one_value_of_a_study_file_is_changed_and_the_rest_stays(tmp_path):
    path = tmp_path / "study.yaml"

    def changed(text, key, value):
        path.write_text(text)
        return with_values(path, {tuple(key): value})

    assert changed("title: a  # mine\nspecies: rat\n", ("title",), "b") == "title: b  # mine\nspecies: rat\n"
    assert changed("title: a\n", ("species",), "rat") == "title: a\nspecies: rat\n"
    nested = "calibration:\n   starts: 3 # few\ntitle: a\n"
    assert changed(nested, ("calibration", "starts"), "4") == "calibration:\n   starts: 4 # few\ntitle: a\n"
    assert changed("calibration:\n  starts: 3\n", ("calibration", "beds"), "windkessel") == (
        "calibration:\n  beds: windkessel\n  starts: 3\n"
    )
    assert changed("title: a\n", ("report", "pdf"), "false") == "title: a\nreport:\n  pdf: false\n"
    with pytest.raises(InputError, match=r"'groups' is written over several lines; write there: groups: \[A, B\]$"):
        changed("groups:\n- CTL\n- HPH\n", ("groups",), "[A, B]")
    with pytest.raises(InputError, match=r"'report.pdf' is written over several|report.pdf"):
        changed("report: {pdf: true, law: linear}\n", ("report", "pdf"), "false")
    path.write_text("groups: [B]\n")
    assert with_groups(path, ["A", "C, D"]) == 'groups: [A, "C, D"]\n'


def test_a_study_file_that_is_not_there_says_where_the_study_is(tmp_path):
    (tmp_path / "study.yaml").write_text("")
    inner = tmp_path / "a" / "b"
    inner.mkdir(parents=True)
    with pytest.raises(InputError, match=f"no such file or directory; the study is {tmp_path}$"):
        read_document(inner / "study.yaml")
    with pytest.raises(InputError, match=r"a: is a folder; `vasowave new FOLDER` makes a new study"):
        read_document(tmp_path / "a")
