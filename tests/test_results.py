import hashlib
import warnings

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from made_fit import made_fit
from vasowave import results
from vasowave.errors import InputError
from vasowave.results import write_results


@pytest.fixture(scope="module")
def fits():
    return made_fit("linear"), made_fit("tangent")


def test_every_number_of_the_fits_stands_in_the_file_with_its_unit(fits, tmp_path):
    write_results(fits, tmp_path / "mouse")
    for fit in fits:
        with xr.open_dataset(tmp_path / "mouse" / "results.nc", group=f"{fit.wall}/calibration") as found:
            assert list(found["parameter"].values) == list(fit.parameters.index)
            np.testing.assert_array_equal(found["value"], fit.parameters["value"])
            np.testing.assert_array_equal(found["determined"], fit.parameters["determined"])
            np.testing.assert_array_equal(found["correlation"], fit.correlation)
            np.testing.assert_array_equal(found["start_S"], fit.starts["S [mmHg2]"])
            np.testing.assert_array_equal(found["pressure_residual"], fit.pressure_residual)
            np.testing.assert_array_equal(found["R1"], fit.model.outlets.R1)
            assert found["start_S"].units == "mmHg2"
            assert float(found["S"]) == fit.S
            assert found["C"].units == "ml/mmHg"


def test_the_simulation_and_its_numerics_come_back_unchanged(fits, tmp_path):
    write_results(fits, tmp_path / "mouse")
    with xr.open_dataset(tmp_path / "mouse" / "results.nc", group="tangent/simulation") as found:
        xr.testing.assert_equal(found.load(), fits[1].simulation)
        assert found.attrs["steps_per_cycle"] == 2048
        assert found["wave_speed"].units == "cm/s"


def test_the_measured_data_stand_beside_the_simulated(fits, tmp_path):
    write_results(fits, tmp_path / "mouse")
    with xr.open_dataset(tmp_path / "mouse" / "results.nc", group="recording") as found:
        np.testing.assert_array_equal(found["pressure"], fits[0].recording.pressure)
        assert found["flow"].units == "ml/s"
        assert found.attrs["period"] == fits[0].recording.period
    table = pd.read_csv(tmp_path / "mouse" / "waveforms.csv")
    measured = table[table["source"] == "measured"]
    np.testing.assert_array_equal(measured["pressure [mmHg]"], fits[0].recording.pressure)
    assert set(table["source"]) == {"measured", "linear", "tangent"}


def test_the_whole_file_opens_as_one_tree_with_provenance(fits, tmp_path):
    source = tmp_path / "cycle.csv"
    source.write_bytes(b"pressure [mmHg]\n")
    write_results(fits, tmp_path / "mouse", inputs=[source])
    with xr.open_datatree(tmp_path / "mouse" / "results.nc") as tree:
        assert set(tree.children) == {"network", "recording", "nominal", "linear", "tangent"}
        assert tree.attrs["sha256 of cycle.csv"] == hashlib.sha256(b"pressure [mmHg]\n").hexdigest()
        assert tree.attrs["numpy"] == np.__version__
        assert str(tree["network"]["parent"].sel(vessel="2").values) == "1"


def test_simulated_indices_are_those_of_the_simulated_cycle(fits):
    table = results.indices_table(fits).set_index("source")
    inlet = fits[0].simulation["pressure"].sel(vessel="1", station="inlet")
    assert table.loc["linear", "sPAP [mmHg]"] == pytest.approx(float(inlet.max()), abs=1e-12)
    assert table.loc["measured", "mPAP [mmHg]"] == fits[0].recording.mean_pressure


def test_every_column_with_a_quantity_names_its_unit(fits):
    tables = results.tables(fits)
    words = {"source", "wall", "stage", "vessel", "parameter", "other", "unit", "start", "simulations", "converged"}
    words |= {"agrees", "message", "at_bound", "free", "determined", "degrees_of_freedom"}
    in_unit_column = {"nominal", "lower", "upper", "value", "standard_error", "standard_error_correlated"}
    in_unit_column |= {"interval_low", "interval_high"}
    for name, table in tables.items():
        bare = {column for column in table.columns if "[" not in column} - words
        assert bare <= (in_unit_column if name == "parameters" else set()), name


def test_an_earlier_result_is_replaced_and_foreign_files_stay(fits, tmp_path):
    folder = tmp_path / "mouse"
    write_results(fits, folder)
    (folder / "notes.txt").write_text("mine")
    (folder / "report.html").write_text("old")
    write_results(fits[:1], folder)
    assert (folder / "notes.txt").read_text() == "mine"
    assert not (folder / "report.html").exists(), "a report of the earlier fit would contradict the new one"
    assert set(pd.read_csv(folder / "fits.csv")["wall"]) == {"linear"}
    assert [path.name for path in tmp_path.iterdir()] == ["mouse"]


def test_a_folder_with_other_work_is_refused_and_left_alone(fits, tmp_path):
    (tmp_path / "thesis.tex").write_text("ten years")
    with pytest.raises(InputError, match="not a vasowave result"):
        write_results(fits, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


def test_a_file_in_the_place_of_the_folder_is_refused(fits, tmp_path):
    (tmp_path / "mouse").write_text("not a folder")
    with pytest.raises(InputError, match="is a file"):
        write_results(fits, tmp_path / "mouse")


def test_a_failure_while_writing_leaves_the_earlier_result_whole(fits, tmp_path, monkeypatch):
    folder = tmp_path / "mouse"
    write_results(fits, folder)
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    monkeypatch.setattr(pd.DataFrame, "to_csv", _full_disk)
    with pytest.raises(InputError, match="No space left"):
        write_results(fits[:1], folder)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before
    assert [path.name for path in tmp_path.iterdir()] == ["mouse"]


def test_fits_of_two_recordings_do_not_share_a_folder(fits, tmp_path):
    other = made_fit("tangent", count=64)
    with pytest.raises(InputError, match="different recordings"):
        write_results([fits[0], other], tmp_path / "mouse")
    with pytest.raises(InputError, match="same wall law"):
        write_results([fits[0], fits[0]], tmp_path / "mouse")
    with pytest.raises(InputError, match="no fit"):
        write_results([], tmp_path / "mouse")
    assert not (tmp_path / "mouse").exists()


def test_a_parameter_that_was_held_fixed_has_an_empty_standard_error(tmp_path):
    fit = made_fit("linear")
    fit.parameters.loc["r1", "standard_error"] = np.nan
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        write_results([fit], tmp_path / "mouse")
    table = pd.read_csv(tmp_path / "mouse" / "parameters.csv").set_index("parameter")
    assert np.isnan(table.loc["r1", "standard_error"])


def _full_disk(*arguments, **options):
    raise OSError(28, "No space left on device")
