import os
import re
from dataclasses import replace
from pathlib import Path
from tempfile import mkdtemp
from typing import get_args

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from small_study import SETTINGS, write_cycle
from typer.testing import CliRunner

from vasowave.base import SPECIES, InputError, SetSetting, SpeciesName, VasowaveWarning
from vasowave.cli import app
from vasowave.cli.options import read_settings
from vasowave.pulse.examples import control_network, hypertensive_network
from vasowave.pulse.network import Network, write_network
from vasowave.study.entering import check_study
from vasowave.study.folder import COLUMNS, BloodSection, parse_settings, read_animals
from vasowave.study.results import blood_findings, load_animal, physiology_findings
from vasowave.study.running import read_study, run_alone, run_study, running

PUT = "put the file there, or correct its name"


def said(folder: Path) -> list[str]:
    """Return what `check` says, paths left out, errors marked."""
    return [f"{'E' if p.error else 'W'} {p}".replace(f"{folder}/", "") for p in check_study(folder).problems]


def table(folder: Path, *rows: str, header: str = "animal,group,network,recording") -> None:
    (folder / "animals.csv").write_text("\n".join([header, *rows]) + "\n", "utf-8")


def test_a_new_study_says_what_to_fill_in(tmp_path):
    folder = tmp_path / "mine"
    new = CliRunner().invoke(app, ["new", str(folder)])
    assert new.exit_code == 0
    check = CliRunner().invoke(app, ["check", str(folder)])
    assert check.exit_code == 1
    assert "no animals yet; add one row per animal (animal, group, network file, recording file)" in check.output
    assert "networks/ and recordings/" in check.output


def test_a_recording_in_place_of_a_study_is_answered_with_what_takes_one(tmp_path):
    recording = tmp_path / "mouse 3.csv"
    recording.write_text("time [s],pressure [mmHg]\n0,12\n", encoding="utf-8")
    said = CliRunner().invoke(app, ["check", str(recording)])
    assert isinstance(said.exception, InputError)
    assert f"study.yaml; `vasowave new FOLDER` makes one, `vasowave add '{recording}'` in it" in str(said.exception)


def test_a_good_study_has_only_what_is_odd_and_status_0(make_study):
    folder = make_study()
    assert said(folder) == [
        "W animals.csv: group 'HPH' has one animal; a comparison needs two or more. Add animals to the group."
    ]
    checked = CliRunner().invoke(app, ["check", str(folder)])
    assert checked.exit_code == 0
    assert checked.output.endswith("\n0 errors, 1 warning\n")
    (folder / "recordings/0.csv").write_text("nothing\n", "utf-8")
    *lines, counts = CliRunner().invoke(app, ["check", str(folder)]).output.splitlines()
    kinds = [line.partition(":")[0] for line in lines]
    assert (kinds.count("error"), kinds.count("warning")) == (1, 1)
    assert counts == "1 error, 1 warning"


def test_everything_wrong_in_the_table_is_said_at_once(make_study):
    folder = make_study()
    table(
        folder,
        "a,CTR,n.csv,recordings/0.csv",
        "b,CTL,m.csv,recordings/00.csv",
        ",CTL,n.csv,recordings/1.csv",
        "c,HPH,n.csv,recordings",
        "c,HPH,n.csv,recordings/1.csv",
        "c,HPH,n.csv,recordings/2.csv",
        "d/e,HPH,n.csv,nowhere/2.csv",
    )
    assert said(folder) == [
        "E animals.csv, line 2, column 'group': 'CTR' is not a group of the study (did you mean 'CTL'?); "
        "write one of its groups (CTL, HPH), or add this one to them",
        "E animals.csv, line 3, column 'network': 'm.csv' does not exist (did you mean 'n.csv'?); " + PUT,
        "E animals.csv, line 3, column 'recording': 'recordings/00.csv' does not exist (did you mean '0.csv'?); " + PUT,
        "E animals.csv, line 4, column 'animal': the cell is empty. Fill it in.",
        "E animals.csv, line 5, column 'recording': 'recordings' is a folder; name a file inside it",
        "E animals.csv, line 8, column 'animal': 'd/e': a name consists of letters, digits, blanks and . , _ + - ( )",
        "E animals.csv, line 8, column 'recording': 'nowhere/2.csv' does not exist, nor does its folder; " + PUT,
        "E animals.csv, line 7, column 'animal': 'c' stands in line 6 already; rename one; where one animal was "
        "measured twice, say so in a column of your own, and name that as the design's subject",
    ]


@pytest.mark.parametrize(
    ("header", "row", "message"),
    [
        ("animal,group,network", "a,CTL,n.csv", "header: no column 'recording'"),
        ("animal,grop,network,recording", "a,b,c,d", "header, column 'grop': unknown column (did you mean 'group'?)"),
        (
            "animal,group,network,recording,wedge",
            "a,CTL,n.csv,recordings/0.csv,8",
            "header, column 'wedge': unknown column (did you mean 'wedge [mmHg]'?)",
        ),
        ("animal,group,network,recording,wedge [mmHg]", "a,CTL,n.csv,recordings/0.csv,1_0", "'1_0' is not a number"),
        ("animal,group,network,recording,flow unit", "a,CTL,n.csv,recordings/0.csv,ml/sec2", "not a unit of flow"),
        ("animal,group,network,recording", "a,CTL,n.csv", "line 2: 3 columns where 4 were expected"),
    ],
)
def test_a_slip_in_the_table_is_named_where_it_stands(make_study, header, row, message):
    folder = make_study()
    table(folder, row, header=header)
    assert any(message in line for line in said(folder)), said(folder)


def test_two_animals_with_the_same_bytes_are_an_error_unless_the_table_says_that_they_are_meant(make_study):
    folder = make_study()
    (folder / "recordings/1.csv").write_bytes((folder / "recordings/0.csv").read_bytes())
    (doubled,) = [line for line in said(folder) if line.startswith("E")]
    assert "line 3, column 'recording': the same recording as 'mouse 0' (line 2); remove one of" in doubled
    assert CliRunner().invoke(app, ["check", str(folder)]).exit_code == 1
    assert "the same recording as 'mouse 0'" in str(CliRunner().invoke(app, ["run", str(folder)]).exception)
    rows = (folder / "animals.csv").read_text("utf-8").splitlines()
    meant = [f"{row},{'shared recording' if i == 0 else 'yes' if i < 3 else ''}" for i, row in enumerate(rows)]
    (folder / "animals.csv").write_text("\n".join(meant) + "\n", "utf-8")
    assert [line for line in said(folder) if line.startswith("E")] == []


@pytest.mark.parametrize("subjects", [False, True], ids=["files", "rows of subjects"])
@pytest.mark.parametrize(
    ("column", "words"),
    [("ventricle", "the same pressure in the ventricle"), ("loops", "the same loops of pressure and volume")],
)
def test_one_ventricle_of_two_animals_is_an_error(make_study, mice, column, words, subjects):
    folder = make_study()
    time, turn = np.arange(1024) * 0.11 / 256, np.pi * np.arange(1024) / 128
    beat, volume = 3 + 20 * np.sin(turn).clip(0), 30 + 10 * np.cos(turn)
    rows = [f"{t:.6f},{p:.4f},{v:.4f}" for t, p, v in zip(time, beat, volume, strict=True)]
    (folder / "rv.csv").write_text("\n".join(["time [s],pressure [mmHg],volume [ul]", *rows, ""]), "utf-8")
    if subjects:
        titles = [f"{name}_{i} [{unit}]" for name, unit in (("p", "mmHg"), ("q", "ml/s")) for i in range(512)]
        cells = [[f"S{k}", 60 / mouse.period, *mouse.pressure, *mouse.flow] for k, mouse in enumerate(mice)]
        lines = [",".join(map(str, row)) for row in (["subject", "heart rate", *titles], *cells)]
        (folder / "all.csv").write_text("\n".join(lines) + "\n", "utf-8")
        named = (f"mouse {k},{group},n.csv,all.csv,S{k}" for k, group in enumerate(("CTL", "CTL", "HPH")))
        table(folder, *named, header="animal,group,network,recording,subject row")
    rows = (folder / "animals.csv").read_text("utf-8").splitlines()
    doubled = [f"{row},{column if i == 0 else 'rv.csv' if i < 3 else ''}" for i, row in enumerate(rows)]
    (folder / "animals.csv").write_text("\n".join(doubled) + "\n", "utf-8")
    errors = [line for line in said(folder) if line.startswith("E")]
    assert any(f"line 3, column '{column}': {words} as 'mouse 0' (line 2)" in error for error in errors)


@pytest.mark.parametrize("rewrite", ["line ends", "fewer digits", "another unit"])
def test_a_recording_that_was_written_anew_is_still_the_same_animal(make_study, mice, rewrite):
    folder = make_study()
    lines = (folder / "recordings/0.csv").read_text("utf-8").splitlines()
    if rewrite == "line ends":
        text = "\r\n".join([*lines, ""])
    elif rewrite == "fewer digits":
        rows = ["{:.6f},{:.4f},{:.5f}".format(*map(float, line.split(","))) for line in lines[1:]]
        text = "\n".join([lines[0], *rows, ""])
    else:
        rows = [(float(t), float(p) / 7.50062, float(q) * 60) for t, p, q in (line.split(",") for line in lines[1:])]
        text = "\n".join(["time [s],pressure [kPa],flow [ml/min]", *(f"{t:.17g},{p},{q}" for t, p, q in rows), ""])
    (folder / "recordings/1.csv").write_text(text, "utf-8")
    errors = [line for line in said(folder) if line.startswith("E")]
    assert len(errors) == 1
    assert "line 3, column 'recording': its averaged cycle is that of 'mouse 0' (line 2)" in errors[0]


def test_a_wrong_recording_and_a_wrong_network_are_both_named_with_file_and_line(make_study):
    folder = make_study()
    lines = (folder / "recordings/0.csv").read_text("utf-8").splitlines()
    lines[9] = lines[9].rpartition(",")[0] + ",x"
    (folder / "recordings/0.csv").write_text("\n".join(lines), "utf-8")
    (folder / "m.csv").write_text((folder / "n.csv").read_text("utf-8").replace("\n2,1,", "\n2,9,"))
    text = (folder / "animals.csv").read_text("utf-8")
    (folder / "animals.csv").write_text(text.replace("HPH,n.csv", "HPH,m.csv"), "utf-8")
    errors = [line for line in said(folder) if line.startswith("E")]
    assert len(errors) == 2
    assert "('mouse 0'): recordings/0.csv, line 10, column 'flow': 'x' is not a number" in errors[0]
    assert "('mouse 2'): m.csv, line 3 (vessel '2'): parent '9' is not in the table" in errors[1]


@pytest.mark.parametrize(
    ("change", "word"),
    [
        (lambda r: replace(r, period=2 * r.period), "HR 266.5 beats/min is implausible for a mouse"),
        (lambda r: replace(r, pressure=4 * r.pressure), "mPAP"),
        (lambda r: replace(r, flow=10 * r.flow), "CO 1.8 ml/s is implausible for a mouse"),
        (lambda r: replace(r, pressure=r.pressure.mean() + 0.1 * (r.pressure - r.pressure.mean())), "pPAP"),
    ],
)
def test_a_mouse_that_is_none_is_odd(make_study, mice, change, word):
    folder = make_study()
    write_cycle(folder / "recordings/2.csv", change(mice[2]))
    assert any(line.startswith("W animals.csv, line 4 ('mouse 2')") and word in line for line in said(folder))
    (folder / "study.yaml").write_text("species: other\n" + SETTINGS, "utf-8")
    assert not any("implausible" in line for line in said(folder))


@pytest.mark.validation
def test_a_viscosity_a_hundred_times_that_of_blood_is_told_before_anything_is_computed(make_study):
    folder = make_study(settings=SETTINGS + "blood: {viscosity: 4.62}\n")
    for number in range(3):
        (folder / f"recordings/{number}.csv").write_text("nothing\n", "utf-8")  # so that nothing can be computed
    study = read_study(folder)
    alone = replace(study, animals=study.animals[:1])

    def run_it_alone():
        with running(study.folder) as begun:
            run_alone(begun, alone)

    for run in (lambda: run_study(study), run_it_alone):
        with (
            pytest.warns(VasowaveWarning, match=r"blood\.viscosity: 4\.62 cm²/s is no blood's"),
            pytest.raises(InputError),
        ):
            run()


@pytest.mark.parametrize("viscosity", [0.01, 0.0462, 0.15])  # water, blood, and blood that hardly moves
def test_liquids_that_are_used_have_a_viscosity_that_nobody_warns_of(viscosity):
    assert blood_findings(BloodSection(viscosity=viscosity)) == []


def test_the_mean_mice_of_the_paper_are_plausible():
    from vasowave.pulse.examples import published_table

    paper = published_table("hemodynamics").set_index("quantity")
    for name, unit in {"HR": "beats/min", "mPAP": "mmHg", "pPAP": "mmHg", "CO": "ml/s"}.items():
        low, high = getattr(SPECIES["mouse"], name)
        assert unit == paper.loc[name, "unit"]
        for group in ("CTL", "HPH"):
            mean, sd = paper.loc[name, f"{group} mean"], paper.loc[name, f"{group} SD"]
            assert low <= mean - 2 * sd
            assert mean + 2 * sd <= high


KNOWN = {
    "rat": {"HR": (310, 420), "mPAP": (16, 19, 42, 60), "pPAP": (10, 60), "CO": (0.8, 2.2), "root_radius": (0.09, 0.2)},
    "rabbit": {"HR": (180, 300), "mPAP": (12, 18), "pPAP": (6, 20), "CO": (4, 12), "root_radius": (0.25, 0.4)},
    "dog": {"HR": (70, 160), "mPAP": (14, 20, 45), "pPAP": (10, 30), "CO": (25, 70), "root_radius": (0.6, 1.1)},
    "pig": {"HR": (80, 130), "mPAP": (15, 25, 45), "pPAP": (10, 30), "CO": (40, 120), "root_radius": (0.8, 1.4)},
    "human": {"HR": (60, 100), "mPAP": (14, 25, 80), "pPAP": (10, 70), "CO": (60, 130), "root_radius": (1.2, 2.0)},
}
"""Textbook values at rest, of healthy animals and of those with pulmonary hypertension."""


@pytest.mark.parametrize("species", KNOWN)
def test_values_as_published_are_plausible_and_those_in_another_unit_are_not(species):
    for name, values in KNOWN[species].items():
        low, high = getattr(SPECIES[species], name)
        assert all(low < value < high for value in values), name
    low, high = SPECIES[species].CO
    assert all(not low <= 60 * value <= high for value in KNOWN[species]["CO"])  # ml/min
    low, high = SPECIES[species].mPAP
    assert all(not low <= 0.133 * value <= high for value in KNOWN[species]["mPAP"] if value < 50)  # kPa
    low, high = SPECIES[species].root_radius
    assert all(not low <= 10 * value <= high for value in KNOWN[species]["root_radius"])  # mm


def test_every_species_that_can_be_named_has_its_ranges_and_every_range_is_one():
    assert set(get_args(SpeciesName)) == {*SPECIES, "other"}
    for one in SPECIES.values():
        ranges = [value for value in vars(one).values() if isinstance(value, tuple)]
        assert len(ranges) == 7
        assert all(0 < low < high for low, high in ranges)
        assert one.heart_rates[0] < one.HR[0] < one.HR[1] < one.heart_rates[1]


@pytest.mark.parametrize("network", [control_network(), hypertensive_network()])
def test_the_radius_of_a_published_root_is_plausible_its_diameter_is_not(network):
    low, high = SPECIES["mouse"].root_radius
    radius = network.radius[network.root]
    assert 2 * low <= radius <= 0.75 * high
    assert 2 * radius > high


@pytest.mark.parametrize(("factor", "stiff"), [(10.0, True), (0.1, True), (2.0, False)])
def test_a_network_in_another_unit_or_of_diameters_is_odd(make_study, factor, stiff):
    folder = make_study()
    radius, scale = [0.047, 0.026, 0.037], factor if stiff else 1.0  # a wrong unit is one of lengths and radii
    length = [scale * value for value in (0.41, 0.45, 0.37)]
    write_network(Network(("1", "2", "3"), [-1, 0, 0], length, [factor * r for r in radius]), folder / "n.csv")
    found = said(folder)
    assert any(f"root radius {0.047 * factor:.4g} cm is implausible for a mouse" in line for line in found)
    assert any("is not that of an artery" in line for line in found) is stiff


@pytest.mark.parametrize("line", ["density: 1057", "viscosity: 4.62"])
def test_blood_in_another_unit_is_odd(make_study, line):
    found = said(make_study(settings=SETTINGS + f"blood: {{{line}}}\n"))
    assert any(line.partition(":")[0] in text and "is no blood's" in text and "line 9" in text for text in found)


def test_bounds_that_exclude_the_nominal_value_are_named_where_they_stand(make_study):
    folder = make_study(
        settings=SETTINGS.replace("starts: 2", "starts: 2\n  bounds: {beta: [1000, 2000], c1: [0.5, 2]}")
    )
    errors = [line for line in said(folder) if line.startswith("E")]
    assert len(errors) == 3  # one for each animal
    assert errors[0].startswith(
        "E study.yaml, line 4, column 12: 'mouse 0': the bounds of beta, 1000 to 2000 mmHg, exclude"
    )
    assert re.search(r"nominal value of this animal, \d+\.?\d* mmHg; widen them", errors[0])


def test_settings_that_contradict_each_other_are_odd(make_study):
    text = "calibration:\n  walls: [linear]\n  bounds: {p1: [1, 9], r1: [0.1, 5]}\n  fixed: {r1: 1}\n"
    text += "  paper_bounds: true\n"
    warned = [line for line in said(make_study(settings=text)) if line.startswith("W study.yaml")]
    assert [re.search(r"line \d+, column \d+", line)[0] for line in warned[:3]] == [
        "line 3, column 12",
        "line 3, column 24",
        "line 5, column 3",
    ]
    assert "p1: no parameter of the linear wall" in warned[0]
    assert "r1: is fixed" in warned[1]
    assert "optima that the paper prints" in warned[2]
    assert len(warned) == 3  # not of `model_selection`, which the template has beside one law, too


@pytest.mark.parametrize(("said_C_T", "factor"), [("0.13e-4", "101"), ("0.131", "100")])
def test_the_published_slip_of_hph_2_would_be_noticed_in_either_direction(make_study, said_C_T, factor):
    folder = make_study()
    header = "animal,group,network,recording,R_T [mmHg s/ml],C_T [ml/mmHg],tau [s]"
    table(
        folder,
        f"a,HPH,n.csv,recordings/0.csv,84,{said_C_T},0.11",
        "b,HPH,n.csv,recordings/1.csv,84,1.3e-3,0.11",
        header=header,
    )
    slips = [line for line in said(folder) if "exponent" in line]
    assert len(slips) == 1
    assert slips[0].startswith(f"W animals.csv, line 2 ('a'): C_T {float(said_C_T):.3g} ml/mmHg as given, 0.00131 from")
    assert f"a factor of {factor}" in slips[0]


def test_what_several_animals_have_in_common_is_one_line_below_the_errors_and_each_is_said_if_asked(make_study, mice):
    folder = make_study()
    given = [0.131, 0.145, 0.162, 0.171, 0.183, 0.194]  # ml/mmHg; the recordings say a hundredth
    for number in range(len(given)):
        louder = replace(mice[0], pressure=(1 + 0.03 * number) * mice[0].pressure)
        write_cycle(folder / f"recordings/s{number}.csv", louder)
    rows = [f"m{number},CTL,n.csv,recordings/s{number}.csv,{value}" for number, value in enumerate(given)]
    table(folder, *rows, "odd,HPH,n.csv,recordings/none.csv,", header="animal,group,network,recording,C_T [ml/mmHg]")
    short, long = (CliRunner().invoke(app, [*option, "check", str(folder)]).output for option in ((), ("-v",)))
    lines = [line for line in short.splitlines() if line.startswith(("error", "warning"))]
    (together,) = [line for line in lines if "exponent" in line]
    assert "6 animals (m0, m1, m2 and 3 more), of the first: C_T 0.131 ml/mmHg as given" in together
    assert [line.partition(":")[0] for line in lines] == sorted(line.partition(":")[0] for line in lines)
    assert lines[0].startswith("error")
    assert re.search(r"roughly \d+ s with the report here", short)
    assert all(f"C_T {value} ml/mmHg as given" in long for value in given)
    assert f"; each by itself: vasowave -v check {folder}" in short.splitlines()[-1]


def test_what_pressure_and_flow_of_one_animal_have_in_common_is_two_lines(make_study, mice):
    from vasowave.catheter import synthetic_raw_recording

    raw = synthetic_raw_recording(mice[0], np.random.default_rng(1), duration=8.0, sampling_rate=500.0).raw
    fading = np.linspace(1.0, 0.5, len(raw.time))
    folder = make_study()
    np.savetxt(folder / "recordings/fading.csv", np.column_stack([raw.time, fading * raw.pressure, fading * raw.flow]),
               "%.6g", ",", header="time [s],pressure [mmHg],flow [ml/s]", comments="")  # fmt: skip
    table(folder, "a,CTL,n.csv,recordings/fading.csv", header="animal,group,network,recording")
    printed = CliRunner().invoke(app, ["check", str(folder)]).output
    assert "the pulse pressure differs by" in printed
    assert "the mean flow differs by" in printed
    assert "1 animals" not in printed


def test_raw_recordings_are_averaged_as_the_study_says(make_study, mice):
    from vasowave.catheter import synthetic_raw_recording

    folder = make_study(settings=SETTINGS + "averaging: {beats: 7, samples: 128, harmonics: 15}\n")
    raw = synthetic_raw_recording(mice[0], np.random.default_rng(3), duration=4.0).raw
    columns = np.column_stack([raw.time, raw.pressure, raw.flow, raw.ecg])
    header = "time [s],PAP [mmHg],Probe [ml/s],ecg [mV]"
    np.savetxt(folder / "raw.csv", columns, fmt="%.6g", delimiter=",", header=header, comments="")
    table(folder, "a,CTL,n.csv,raw.csv,raw,probe", header="animal,group,network,recording,kind,flow channel")
    study = read_study(folder)
    animal = load_animal(study.animals[0], study.settings, study.folder)
    assert sum(beat.averaged for beat in animal.beats.beats) == 7
    assert len(animal.recording.pressure) == 128
    assert animal.recording.mean_pressure == pytest.approx(mice[0].mean_pressure, rel=0.01)
    assert animal.recording.source == "raw.csv"


def test_a_continuous_recording_that_was_exported_again_is_still_the_same_animal(make_study, mice):
    from vasowave.catheter import synthetic_raw_recording

    folder = make_study()
    raw = synthetic_raw_recording(mice[0], np.random.default_rng(3)).raw
    columns = np.column_stack([raw.time, raw.pressure, raw.flow, np.round(raw.ecg, 2)])
    header = "time [s],pressure [mmHg],flow [ml/s],ecg [mV]"
    for name, rows in (("a", columns), ("b", columns[5000:])):
        np.savetxt(folder / f"{name}.csv", rows, fmt="%.5g", delimiter=",", header=header, comments="")
    lines = ("a,CTL,n.csv,a.csv,raw", "b,CTL,n.csv,b.csv,raw")
    table(folder, *lines, header="animal,group,network,recording,kind")
    (error,) = (line for line in said(folder) if line.startswith("E"))
    assert "line 3, column 'recording': its pressure is in that of 'a' (line 2), written anew" in error
    on_purpose = [f"{line},yes" for line in lines]
    table(folder, *on_purpose, header="animal,group,network,recording,kind,shared recording")
    assert not [line for line in said(folder) if line.startswith("E")]


def test_a_missing_study_names_the_command_that_makes_one(tmp_path):
    with pytest.raises(ValueError, match=r"study.yaml: no such file or directory; `vasowave new FOLDER`"):
        check_study(tmp_path)


CELLS = st.sampled_from(["a", "CTL", "n.csv", "1", "-1", "nan", "raw", "", '"', "x/y", "é", "1e999"]) | st.text(
    max_size=4
)


@given(
    st.lists(st.sampled_from([*COLUMNS, "x", ""]), max_size=8),
    st.lists(st.lists(CELLS, max_size=8), max_size=4),
)
@settings(max_examples=200, deadline=None)
def test_any_table_is_understood_or_refused(tmp_path_factory, header, rows):
    path = Path(mkdtemp(dir=tmp_path_factory.getbasetemp())) / "animals.csv"
    path.write_text("\n".join(",".join(row) for row in [header, *rows]), encoding="utf-8", errors="replace")
    understood, problems = read_animals(path, ["CTL", "HPH"])
    assert understood or problems
    assert all(str(problem.finding) for problem in problems)


def middle(species):
    names = ("HR", "mPAP", "pPAP", "CO", "root radius")
    return {name: 0.5 * sum(getattr(SPECIES[species], name.replace(" ", "_"))) for name in names}


def test_an_animal_that_fits_several_species_is_told_all_of_them_once():
    (found,) = physiology_findings(middle("dog"), 0.4, "mouse")
    assert "All of them fit a dog or a pig or a human: if it is one, name that species" in str(found)
    assert found.cures[0] == SetSetting("The species is dog", "species", "dog")
    assert not physiology_findings(middle("dog"), 0.4, "other")


def test_the_species_is_an_option_of_new_and_fit(tmp_path):
    done = CliRunner().invoke(app, ["new", str(tmp_path / "s"), "--species", "rat"])
    assert done.exit_code == 0, done.output
    made, _ = parse_settings((tmp_path / "s" / "study.yaml").read_bytes())
    assert made.species == "rat"
    refused = CliRunner().invoke(app, ["new", str(tmp_path / "t"), "--species", "rats"])
    assert "did you mean 'rat'?" in str(refused.exception)
    assert not (tmp_path / "t").exists()
    assert read_settings({"species": "rat"}, "one", "animal").species == "rat"
    assert "--species" in CliRunner().invoke(app, ["fit", "--help"], env={"COLUMNS": "200"}).output


def test_what_a_report_cannot_honour_and_a_wedge_of_some_animals_are_said_before_the_run(make_study):
    study = make_study()
    settings = study / "study.yaml"
    settings.write_text(
        "groups: [CTL, HPH]\ncalibration: {walls: [tangent, linear]}\nreport: {law: power, quantities: [mPAP, PVRR]}\n",
        "utf-8",
    )
    table = (study / "animals.csv").read_text("utf-8").strip().split("\n")
    wedged = [f"{table[0]},wedge [mmHg]", f"{table[1]},6", *(f"{row}," for row in table[2:])]
    (study / "animals.csv").write_text("\n".join([*wedged, ""]), "utf-8")
    found = {problem.finding.code: str(problem) for problem in check_study(study).problems}
    assert (
        "'power' is none of calibration.walls; choose one that is fitted: tangent, linear"
        in found["check.law-not-fitted"]
    )
    assert "no animal will have 'PVRR' (did you mean 'PVR'?)" in found["check.no-quantity"]
    assert f"1 of {len(table) - 1} recordings have a wedge pressure" in found["check.wedge-of-some"]


@pytest.mark.parametrize(("species", "asked"), [("pig", True), ("mouse", False)])
def test_of_animals_whose_right_hearts_are_catheterized_the_wedge_is_asked_for(make_study, species, asked):
    folder = make_study()
    settings = (folder / "study.yaml").read_text("utf-8")
    (folder / "study.yaml").write_text(f"{settings}\nspecies: {species}\n", "utf-8")
    codes = {problem.finding.code for problem in check_study(folder).problems}
    assert ("check.wedge-of-none" in codes) == asked


def test_what_is_assumed_of_outflow_and_question_is_a_note_with_its_setting_until_the_study_says_it(make_study):
    folder = make_study()
    notes = {problem.finding.code: problem for problem in check_study(folder).notes}
    assert set(notes) == {"check.wedge-assumed", "check.no-primary-quantity"}
    assert "over an assumed outflow pressure of 0 mmHg" in str(notes["check.wedge-assumed"])
    said = CliRunner().invoke(app, ["check", str(folder)])
    assert said.exit_code == 0
    assert said.output.count("note: ") == 2
    assert f"vasowave set {folder} 'report.quantities=[VALUE]'" in said.output
    settings = (folder / "study.yaml").read_text("utf-8")
    (folder / "study.yaml").write_text(f"{settings}\nreport: {{quantities: [PVR]}}\n", "utf-8")
    header, *rows = (folder / "animals.csv").read_text("utf-8").strip().split("\n")
    table = [f"{header},wedge [mmHg]", *(f"{row},6" for row in rows), ""]
    (folder / "animals.csv").write_text("\n".join(table), "utf-8")
    assert check_study(folder).notes == ()


@pytest.mark.parametrize("place", ["study.yaml", "animals.csv", "n.csv"])
def test_a_pipe_in_place_of_a_file_of_the_study_is_named_and_nobody_waits(make_study, place):
    folder = make_study(animals=1)
    (folder / place).unlink()
    os.mkfifo(folder / place)
    try:
        said = [str(one) for one in check_study(folder).problems if one.error]
    except InputError as error:
        said = [str(error)]
    assert any(place in one and "is a pipe or a device" in one for one in said), said


def test_a_name_that_would_steer_a_terminal_is_told_without_doing_so(make_study):
    folder = make_study(animals=1)
    table = (folder / "animals.csv").read_text("utf-8").replace("mouse 0", "mo\x1b]0;evil\x07use\u202e")
    (folder / "animals.csv").write_text(table, "utf-8")
    done = CliRunner().invoke(app, ["check", str(folder)], color=True)
    assert "'mo?]0;evil?use?': a name consists of letters" in done.output
    assert not {"\x1b", "\x07", "\u202e"} & set(done.output)
