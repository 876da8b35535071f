"""Further sites on their way through an analysis, a stored file, a table of animals and a report."""

import numpy as np
import pytest

import vasowave as vw
from made_cohort import EXACT
from vasowave.study.animal import read_result, stored_sites, write_result
from vasowave.study.cohort import gathered
from vasowave.study.figures import sites_figure
from vasowave.study.folder import StudyFile, read_row
from vasowave.study.report.sections import sites_table
from vasowave.study.results import file_hashes, load_animal
from vasowave.study.running import fit_sentences, option_of

NETWORK, MOUSE = vw.control_network(), vw.virtual_mouse()
SITES = (
    vw.Observation("flow", "2", 0.01, mean=0.036, systolic=0.28),
    vw.Observation("pressure", "3", 0.2, cm=0.1, waveform=MOUSE.pressure[::8] - 0.4, zero_sd=0.7),
)


@pytest.fixture(scope="module")
def result():
    animal = vw.Animal("one", "CTL", NETWORK, MOUSE, synthetic=True, sites=SITES)
    return vw.analyze(animal, vw.Settings(walls=("linear",), starts=1))


def test_a_stored_result_keeps_its_sites_and_leads_back_to_them(result, tmp_path):
    write_result(result, tmp_path / "one.nc")
    again = read_result(tmp_path / "one.nc")
    assert again.identical(result)
    flow, pressure = stored_sites(again)
    assert (flow.quantity, flow.vessel, flow.numbers, flow.gain) == (
        "flow",
        "2",
        {"mean": 0.036, "systolic": 0.28},
        0.05,
    )
    assert (pressure.vessel, pressure.error, pressure.zero_sd) == ("3", 0.2, 0.7)
    assert pressure.place == pytest.approx(0.1 / NETWORK.length[2])
    assert pressure.waveform.mean() == pytest.approx(SITES[1].waveform.mean())


def test_the_report_has_a_row_and_a_panel_for_every_site(result):
    table = sites_table(gathered([result]))
    assert len(table.rows) == 2
    assert np.isfinite(table.data.select_dtypes(float)).to_numpy().all()
    fitted = [str(name) for name in result.laws["linear"].calibration["parameter"].values]
    assert table.data["quantity"].tolist() == 2 * ["wave_speed", "R_T", *fitted]
    assert (table.data["low"] < table.data["high"]).all()
    units = dict(zip(table.data["quantity"], table.data["unit"], strict=True))
    assert (units["wave_speed"], units["R_T"], units["beta"], units["r1"]) == ("cm/s", "mmHg s/ml", "mmHg", "1")
    assert "R_T without [mmHg s/ml]" in table.header
    drawn = [ax for ax in sites_figure(result).axes if ax.lines]
    assert [ax.get_ylabel() for ax in drawn] == ["flow [ml/s]", "pressure [mmHg]"]


def test_a_wrong_unit_is_told_first_and_r_t_ends_where_it_ends_without_sites():
    wrong = vw.Observation("flow", "2", 10.0, mean=36.0, systolic=280.0)
    animal = vw.Animal("one", "CTL", NETWORK, MOUSE, synthetic=True, sites=(wrong,))
    coarse = vw.Numerics(cell_size=0.3, tolerance=1e-6)
    found = vw.analyze(animal, vw.Settings(walls=("linear",), starts=1, numerics=coarse, **EXACT))
    first, second, *others = fit_sentences(found)
    assert first.startswith("warning: The flow in '2', 0.5 of its length is 1.08e+03 times what the recording")
    assert first.endswith("Do not use the numbers below before that is settled.")
    assert second.startswith("Pressure and flow")
    assert not any("flow in '2'" in one for one in others)
    law = found.laws["linear"]
    most = law.quantities["R_T"].attrs["interval_high"]  # what pressure and flow leave for the beds
    assert float(law.sites["high"].sel(quantity="R_T").item()) == pytest.approx(most, rel=1e-9)
    assert float(law.sites["high_without"].sel(quantity="R_T").item()) <= most


def test_the_column_of_sites_is_read_and_its_waveforms_are_among_the_files(tmp_path, lab_like):
    cell, folder = lab_like
    row, problems = read_row(cell | {"sites": "sites.csv"}, folder, ["CTL"], option_of)
    assert not [one for one in problems if one.error]
    assert [file.name for role, file in row.files.items() if "site" in role] == ["sites.csv", "wave.csv"]
    assert {"sites", "site 1"} <= set(file_hashes(row, folder))
    (site,) = load_animal(row, StudyFile(title="t", groups=["CTL"]), folder).sites
    assert site.waveform.max() == pytest.approx(0.2, rel=1e-3)
    missing, problems = read_row(cell | {"sites": "no.csv"}, folder, ["CTL"], option_of)
    assert missing is None
    assert "--sites" in str([one.finding.place for one in problems])


@pytest.fixture
def lab_like(tmp_path):
    vw.write_network(NETWORK, tmp_path / "network.csv")
    rows = zip(MOUSE.time, MOUSE.pressure, MOUSE.flow, strict=True)
    text = "\n".join(f"{t:.7f},{p:.6f},{q:.7f}" for t, p, q in rows)
    (tmp_path / "cycle.csv").write_text(f"time [s],pressure [mmHg],flow [ml/s]\n{text}\n")
    wave = "\n".join(f"{200 * np.sin(np.pi * k / 64) ** 2:.4f}" for k in range(64))
    (tmp_path / "wave.csv").write_text(f"flow [ul/s]\n{wave}\n")
    (tmp_path / "sites.csv").write_text("quantity,vessel,file,unit,error\nflow,2,wave.csv,ul/s,5\n")
    return {"animal": "one", "group": "CTL", "network": "network.csv", "recording": "cycle.csv"}, tmp_path
