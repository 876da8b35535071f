"""Loops of pressure and volume on their way through a table of animals, an analysis, a comparison and a report."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import trapezoid

import vasowave as vw
from made_ventricle import made_ventricles
from vasowave.base import units
from vasowave.pulse.analysis import VENTRICULAR
from vasowave.study.animal import read_result, write_result
from vasowave.study.cohort import Family, gathered, primary_comparison
from vasowave.study.folder import StudyFile, read_row
from vasowave.study.report.sections import data_section
from vasowave.study.results import file_hashes, load_animal
from vasowave.study.running import fit_sentences, option_of

NETWORK = vw.control_network()
QUIET = {"drift": 0.0, "breaths": 0.0, "noise": 0.004, "volume_noise": 0.008}


@pytest.fixture(scope="module")
def made():
    return made_ventricles(np.random.default_rng(4), ("cosine",), ("mouse",), each=4, right=True, **QUIET)


def analyzed(name, group, function):
    animal = vw.Animal(name, group, NETWORK, vw.virtual_mouse(), synthetic=True, loops=function)
    return vw.analyze(animal, vw.Settings(walls=("linear",), starts=1, numerics=vw.Numerics(cell_size=0.3)))


def function_of(case, stiffer=1.0):
    return vw.pressure_volume(vw.PressureVolume(stiffer * case.pressure, case.volume, case.rate, case.name))


@pytest.fixture(scope="module")
def results(made):
    groups = ("CTL", "CTL", "HPH", "HPH")
    return [
        analyzed(f"{group} {place}", group, function_of(case, 3.0 if group == "HPH" else 1.0))
        for place, (group, case) in enumerate(zip(groups, made, strict=True))
    ]


def test_an_animal_has_the_numbers_of_its_loops_with_their_intervals(results, made, tmp_path):
    data = results[0].measured.quantities
    elastance = data["loops_E_es"]
    assert elastance.attrs["interval_low"] < made[0].elastance < elastance.attrs["interval_high"]
    assert elastance.attrs["units"] == "mmHg/ml"
    assert float(data["loops_SV"]) == pytest.approx(made[0].stroke_volume, rel=0.02)
    assert float(data["SV"]) != float(data["loops_SV"])  # that of the flow probe stays
    assert {f"loops_{name}" for name in VENTRICULAR} >= {name for name in data if name.startswith("loops_")}
    table = results[0].table().set_index("quantity")
    assert table.loc["loops_PRSW", "low"] < table.loc["loops_PRSW", "value"] < table.loc["loops_PRSW", "high"]
    write_result(results[0], tmp_path / "one.nc")
    assert read_result(tmp_path / "one.nc").identical(results[0])
    assert any(sentence.startswith("Ventricle by loops") for sentence in fit_sentences(results[0]))


def test_the_loops_that_are_kept_have_the_work_and_the_line_that_are_told(results, made):
    stored, numbers = results[0].loops, results[0].measured.quantities
    loops = stored.isel(loop=stored["steady"].to_numpy() == 1)
    work = [-trapezoid(p, V) * units.MILLIWATT for p, V in zip(loops["pressure"], loops["volume"], strict=True)]
    assert np.mean(work) == pytest.approx(float(numbers["loops_stroke_work"]), rel=0.01)
    (low, high), (start, end) = stored["line_pressure"].to_numpy(), stored["line_volume"].to_numpy()
    assert (high - low) / (end - start) == pytest.approx(float(numbers["loops_E_es"]))
    assert int(stored["family"].sum()) > 10


def test_the_supplement_and_the_panels_draw_the_loops_of_an_animal_of_each_group(results):
    names = [getattr(block, "name", "") for block in data_section(gathered(results)).blocks]
    assert [name for name in names if name.startswith("Loops")] == ["Loops-1", "Loops-2"]
    none_shown = [replace(result, loops=None if place < 2 else result.loops) for place, result in enumerate(results)]
    names = [getattr(block, "name", "") for block in data_section(gathered(none_shown)).blocks]
    assert [name for name in names if name.startswith("Loops")] == ["Loops-2"]
    ax = results[0].plot.loops()
    assert ax.get_xlabel() == "volume [µl]"
    assert len(ax.lines) == results[0].loops.sizes["loop"] + 3


def test_groups_are_compared_by_what_loops_tell_as_by_any_other_number(results, made):
    cohort = gathered(results)
    primary = primary_comparison(cohort, Family(quantities=("mPAP", "loops_E_es", "loops_EF", "loops_dp_dt_min")))
    ratios = {effect.quantity: effect.ratio for effect in primary.effects}
    truth = 3.0 * np.sqrt(made[2].elastance * made[3].elastance / made[0].elastance / made[1].elastance)
    assert ratios["loops_E_es"] == pytest.approx(truth, rel=0.06)
    assert "loops_EF" in ratios
    assert [omission.quantity for omission in primary.left_out] == ["mPAP", "loops_dp_dt_min"]  # alike, and negative


@pytest.fixture
def row_and_folder(tmp_path, made):
    vw.write_network(NETWORK, tmp_path / "network.csv")
    mouse = vw.virtual_mouse()
    signals = {"time [s]": mouse.time, "pressure [mmHg]": mouse.pressure, "flow [ml/s]": mouse.flow}
    pd.DataFrame(signals).to_csv(tmp_path / "cycle.csv", index=False)
    late = np.interp(made[0].time - 0.006, made[0].time, made[0].volume)
    loops = {"time [s]": made[0].time, "LVP [mmHg]": made[0].pressure, "Vol": 1000 * late}
    pd.DataFrame(loops).to_csv(tmp_path / "loops.csv", index=False)
    cells = {"animal": "one", "group": "CTL", "network": "network.csv", "recording": "cycle.csv", "loops": "loops.csv"}
    return cells, tmp_path


def loaded(cells, folder):
    row, problems = read_row(cells, folder, ["CTL"], option_of)
    assert not [problem for problem in problems if problem.error]
    assert "loops.csv" in file_hashes(row, folder)["loops"]
    return load_animal(row, StudyFile(title="t", groups=["CTL"]), folder)


def test_the_column_of_loops_is_read_with_unit_and_delay_of_the_volume(row_and_folder, made):
    cells, folder = row_and_folder
    with pytest.raises(vw.errors.InputError, match="volume has no unit"):
        loaded(cells, folder)
    animal = loaded(cells | {"volume unit": "ul"}, folder)
    assert animal.loops.source == "loops.csv"
    assert "loops.volume-late" in [finding.code for finding in animal.recording.notes]
    animal = loaded(cells | {"volume unit": "ul", "volume delay [s]": "0.006"}, folder)
    assert "loops.volume-late" not in [finding.code for finding in animal.recording.notes]
    assert animal.loops.estimates["E_es"].value == pytest.approx(made[0].elastance, rel=0.05)


def test_the_delay_that_is_told_is_the_whole_one_whatever_was_given_before(row_and_folder):
    cells, folder = row_and_folder
    for given, word in (("-0.004", "later"), ("0.012", "earlier")):
        animal = loaded(cells | {"volume unit": "ul", "volume delay [s]": given}, folder)
        (late,) = [finding for finding in animal.recording.notes if finding.code == "loops.volume-late"]
        assert dict(late.values)["seconds"] == pytest.approx(0.006, abs=0.0015)
        assert word in str(late)


def test_a_file_that_is_not_there_and_a_unit_of_no_volume_are_refused(row_and_folder):
    cells, folder = row_and_folder
    for wrong in ({"loops": "none.csv"}, {"volume unit": "ml/s"}):
        _, problems = read_row(cells | wrong, folder, ["CTL"], option_of)
        assert [problem for problem in problems if problem.error]


def test_what_mends_loops_never_writes_into_a_column_of_the_recording(row_and_folder):
    cells, folder = row_and_folder
    with pytest.raises(vw.errors.InputError) as told:
        loaded(cells, folder)
    assert {title for cure in told.value.cures for title, _ in cure.cells} == {"volume unit"}
    table = pd.read_csv(folder / "loops.csv").rename(columns={"LVP [mmHg]": "LVP"})
    table.to_csv(folder / "loops.csv", index=False)
    with pytest.raises(vw.errors.InputError, match=r"pressure has no unit.*export these channels") as told:
        loaded(cells | {"volume unit": "ul"}, folder)
    assert told.value.cures == ()
