"""Errors of image, probe and transducer as columns of the table of animals."""

import numpy as np
import pytest

from vasowave.study.folder import StudyFile, animal_settings, read_animals, variables_of
from vasowave.study.results import animal_key, load_animal
from vasowave.study.running import read_study

HEADER = "animal,group,network,recording,zero [mmHg],zero after [mmHg],flow gain sd,hematocrit [1],probe"


def rewritten(folder, *cells, header=HEADER):
    lines = (folder / "animals.csv").read_text("utf-8").splitlines()
    known = [line.split(",")[:4] for line in lines if line and not line.startswith("#")][1:]
    rows = [",".join([*one, *cells]) for one in known]
    (folder / "animals.csv").write_text("\n".join([header, *rows]) + "\n", "utf-8")
    return read_animals(folder / "animals.csv", None)


def test_a_column_takes_the_place_of_the_key_of_the_study(make_study):
    folder = make_study()
    rows, problems = rewritten(folder, "", "", "0.07", "", "A")
    assert not [one for one in problems if one.error]
    assert {row.errors["flow_gain_sd"] for row in rows} == {0.07}
    study = StudyFile(flow_gain_sd=0.2, zero_sd=1.0)
    settings = animal_settings(study, rows[0])
    assert (settings.flow_gain_sd, settings.zero_sd) == (0.07, 1.0)
    assert animal_settings(study).flow_gain_sd == 0.2


def test_a_zero_before_and_after_is_the_middle_with_the_error_of_a_drift_between(make_study):
    folder = make_study()
    (row, *_), _ = rewritten(folder, "0.4", "1.6", "", "", "")
    assert row.zero == pytest.approx(1.0)
    assert row.errors["zero_sd"] == pytest.approx(np.std(np.linspace(0.4, 1.6, 100_001)), rel=1e-4)  # even between
    (plain, *_), _ = rewritten(folder, "1.0", "", "", "", "")
    study = read_study(folder)
    one, other = (load_animal(each, study.settings, folder).recording for each in (row, plain))
    np.testing.assert_allclose(one.pressure, other.pressure)


def test_blood_of_more_cells_is_more_viscous_by_pries(make_study):
    folder = make_study()
    (row, *_), _ = rewritten(folder, "", "", "", "0.6", "")
    usual, thick = (animal_settings(StudyFile(), one).blood.viscosity for one in (None, row))
    # Pries et al. 1994: 1 + 2.2 ((1-H)^-0.8 - 1)/((1-0.45)^-0.8 - 1) of plasma's, 3.2 of it at 0.45
    assert thick / usual == pytest.approx((1 + 2.2 * (0.4**-0.8 - 1) / (0.55**-0.8 - 1)) / 3.2)
    _, problems = rewritten(folder, "", "", "", "45", "")
    assert any("give the share of cells" in str(one) for one in problems)


def test_blood_that_is_colder_is_as_much_more_viscous_as_water(make_study):
    folder = make_study()
    header = "animal,group,network,recording,temperature [°C]"
    (row, *_), problems = rewritten(folder, "25", header=header)
    assert not [one for one in problems if one.error]
    usual, cold = (animal_settings(StudyFile(), one).blood.viscosity for one in (None, row))
    assert cold / usual == pytest.approx(0.8900 / 0.6913, rel=1e-3)  # mPa s of water at 25 and 37 °C (IAPWS 2008)
    (body, *_), _ = rewritten(folder, "37", header=header)
    assert animal_settings(StudyFile(), body).blood.viscosity == pytest.approx(usual)
    study = read_study(folder)
    assert animal_key(body, study.settings, folder) != animal_key(row, study.settings, folder)
    assert {one.name: one.unit for one in variables_of([row])}["temperature"] == "°C"
    _, problems = rewritten(folder, "98", header=header)
    assert any("not that of an animal's blood" in str(one) for one in problems)


def test_what_animals_share_is_carried_and_no_slip(make_study):
    folder = make_study()
    rows, problems = rewritten(folder, "", "", "", "", "A")
    assert {one.name: set(one.levels.values()) for one in variables_of(rows)}["probe"] == {"A"}
    assert not [one for one in problems if "probe" in str(one)]
    study = read_study(folder)
    key = animal_key(rows[0], study.settings, folder)
    again, _ = rewritten(folder, "", "", "", "", "B")
    assert animal_key(again[0], study.settings, folder) == key  # who shares what is the comparison's business
    told, _ = rewritten(folder, "", "", "0.1", "", "B")
    assert animal_key(told[0], study.settings, folder) != key


def test_an_error_that_is_none_is_refused(make_study):
    folder = make_study()
    _, problems = rewritten(folder, "", "", "-0.1", "", "")
    assert any("not a positive number" in str(one) for one in problems)
    _, problems = rewritten(folder, "", "", "7", "", "")  # percent
    assert any("at most 2" in str(one) for one in problems)
