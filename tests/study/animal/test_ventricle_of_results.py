"""The pressure in the ventricle on its way through an analysis, a stored file, a table of animals and a report."""

import numpy as np
import pytest

import vasowave as vw
from vasowave.pulse import COUPLING
from vasowave.study.animal import read_result, write_result
from vasowave.study.cohort import gathered
from vasowave.study.figures import ventricle_figure
from vasowave.study.folder import StudyFile, read_row
from vasowave.study.report.sections import data_section
from vasowave.study.results import file_hashes, load_animal
from vasowave.study.running import fit_sentences, option_of

NETWORK = vw.control_network()


@pytest.fixture(scope="module")
def beat():
    model = vw.Model(NETWORK, vw.LinearWall(60.0), vw.estimate_nominal(NETWORK, vw.virtual_mouse()).outlets)
    waves = vw.simulate(model, vw.Ventricle.from_peak(1400.0, 100.0, 0.11, 4.0), vw.Numerics(samples=256))
    root = waves.sel(vessel=NETWORK.name[NETWORK.root], station="inlet")
    recording = vw.Recording(root.pressure.to_numpy(), np.clip(root.flow.to_numpy(), 0, None), 0.11)
    return recording, vw.VentricularPressure(waves.ventricular_pressure.to_numpy(), 0.11)


@pytest.fixture
def lab_like(tmp_path, beat):
    """A row of the table of animals, and the folder of its files."""
    recording = beat[0]
    vw.write_network(NETWORK, tmp_path / "network.csv")
    table = np.column_stack([recording.time, recording.pressure, recording.flow])
    header = "time [s],pressure [mmHg],flow [ml/s]"
    np.savetxt(tmp_path / "cycle.csv", table, "%.7f", ",", header=header, comments="")
    return {"animal": "one", "group": "CTL", "network": "network.csv", "recording": "cycle.csv"}, tmp_path


@pytest.fixture(scope="module")
def result(beat):
    animal = vw.Animal("one", "CTL", NETWORK, beat[0], synthetic=True, ventricle=beat[1])
    coarse = vw.Numerics(cell_size=0.3, tolerance=1e-6)
    return vw.analyze(animal, vw.Settings(walls=("linear",), starts=1, numerics=coarse, flow_gain_sd=0.07))


def test_the_gain_of_a_probe_moves_both_elastances_and_not_their_ratio(result, beat):
    found, data = vw.coupling(*beat), result.measured.quantities
    assert [float(data[name]) for name in COUPLING] == pytest.approx([found.elastance, found.load, found.ratio])
    assert data["coupling"].attrs["interval_low"] == pytest.approx(found.ratio * np.exp(-1.96 * found.error), rel=0.01)
    assert data["E_es"].attrs["units"] == "mmHg/ml"
    assert data["E_a"].attrs["standard_error"] == pytest.approx(0.07 * found.load, rel=0.01)
    assert data["coupling"].attrs["standard_error"] == pytest.approx(found.error * found.ratio, rel=1e-3)


def test_a_stored_result_keeps_the_ventricle(result, tmp_path):
    write_result(result, tmp_path / "one.nc")
    again = read_result(tmp_path / "one.nc")
    assert again.identical(result)
    assert again.ventricle["fitted_pressure"].attrs["units"] == "mmHg"


def test_page_and_supplement_say_it(result):
    said = next(one for one in fit_sentences(result) if one.startswith("Ventricle and artery"))
    assert "E_es" in said
    assert said.endswith("Whether it keeps up with its load is open.")
    blocks = [
        one for one in data_section(gathered([result])).blocks if getattr(one, "name", "").startswith("Ventricle")
    ]
    assert len(blocks) == 1
    loop = ventricle_figure(result.ventricle).axes[1]
    assert (loop.get_xlabel(), loop.get_ylabel()) == ("volume above V₀ [µl]", "pressure [mmHg]")


def test_a_ventricle_that_does_not_fit_is_a_finding_and_the_rest_stays(beat):
    low = vw.VentricularPressure(beat[1].pressure / 7.5, 0.11)
    animal = vw.Animal("one", "CTL", NETWORK, beat[0], synthetic=True, ventricle=low)
    found = vw.analyze(animal, vw.Settings(walls=("linear",), starts=1, numerics=vw.Numerics(cell_size=0.3)))
    assert "ventricle.not-coupled" in [one.code for one in found.findings]
    assert found.ventricle is None
    assert "linear" in found.laws


def test_the_column_of_the_ventricle_is_read_and_is_among_the_files(tmp_path, lab_like, beat):
    cell, folder = lab_like
    time = np.arange(256) * 0.11 / 256
    table, header = np.c_[time, beat[1].pressure], "time [s],pressure [mmHg]"
    np.savetxt(folder / "rv.csv", table, "%.6f", ",", header=header, comments="")
    row, problems = read_row(cell | {"ventricle": "rv.csv"}, folder, ["CTL"], option_of)
    assert not [one for one in problems if one.error]
    assert "rv.csv" in file_hashes(row, folder)["ventricle"]
    animal = load_animal(row, StudyFile(title="t", groups=["CTL"]), folder)
    assert animal.ventricle.source == "rv.csv"
    assert animal.ventricle.period == pytest.approx(0.11, rel=1e-3)
    _, missing = read_row(cell | {"ventricle": "none.csv"}, folder, ["CTL"], option_of)
    assert [one for one in missing if one.error]
