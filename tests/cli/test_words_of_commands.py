"""What commands make of the words that are typed, and what they say, without computing anything."""

import pytest

from vasowave.cli import models, options
from vasowave.errors import InputError


def test_cells_of_a_row_are_taken_out_of_the_options():
    given = {"period": " 0.1 ", "unit": ["flow=ml/min", "pressure = kPa"], "channel": ["ecg=II"], "starts": "3"}
    assert options.row_cells(given) == {
        "period [s]": "0.1", "flow unit": "ml/min", "pressure unit": "kPa", "ecg channel": "II"
    }  # fmt: skip
    assert given == {"starts": "3"}
    for wrong in ("flwo=x", "flow", "flow="):
        with pytest.raises(InputError, match=rf"--unit {wrong}: write pressure=… or flow=…"):
            options.row_cells({"unit": [wrong]})
    with pytest.raises(InputError, match="did you mean 'flow'"):
        options.row_cells({"unit": ["flwo=x"]})
    with pytest.raises(InputError, match="--unit ecg=mV"):
        options.row_cells({"unit": ["ecg=mV"]})


def test_a_problem_of_options_is_named_by_its_option():
    given = options.GivenOptions("options", {"calibration": {"starts": "x"}})
    assert given.place(("calibration", "starts")).part == "--starts"
    assert given.place(()).part == "options"
    assert given.place(("calibration",)).part == "--calibration"


def test_places_that_bring_their_model_are_folders_and_openbfs_files(tmp_path):
    assert models.brings_its_model(tmp_path)
    assert models.brings_its_model(tmp_path / "x.YML")
    assert not models.brings_its_model(tmp_path / "x.csv")
    numerics = models.numerics_from(0.2, None)
    assert numerics.cell_size == 0.2
    assert models.numerics_from(None, None) == type(numerics)()
    with pytest.raises(InputError, match=r"unknown friction 'poisseuille' \(did you mean 'poiseuille'\?\); there are:"):
        models.model_from(tmp_path, [], None, "", ("", ""), "poisseuille")
    with pytest.raises(InputError, match="leave the recording out"):
        models.model_from(tmp_path, [tmp_path], None, "", ("", ""), "")
    with pytest.raises(InputError, match="leave --bed out"):
        models.model_from(tmp_path, [], None, "", ("", "windkessel"), "")
    with pytest.raises(InputError, match="openBF's wall is the linear one"):
        models._openbf(tmp_path / "x.yaml", "tangent")
