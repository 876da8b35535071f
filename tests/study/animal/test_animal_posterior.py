"""The posterior in an animal's results: asked for by one word, stored beside the fit, readable by ArviZ."""

import numpy as np
import pytest

from vasowave.base import from_json, texts
from vasowave.pulse.examples import control_network, virtual_mouse
from vasowave.pulse.inference import SOURCES
from vasowave.pulse.network import Network
from vasowave.study.animal import Animal, AnimalResult, Settings, analyze, from_bytes, to_bytes
from vasowave.study.report import write_report
from vasowave.study.results import Journal


@pytest.mark.weekly
def test_the_posterior_of_an_animal_stands_beside_its_fit_and_goes_on_from_its_kept_simulations(tmp_path):
    mouse = Animal("mouse 6", "CTL", control_network(), virtual_mouse(), synthetic=True)
    settings = Settings(walls=("linear",), starts=1, inference="posterior")
    journal = Journal(tmp_path / "key.jsonl")
    result = AnimalResult.from_datatree(from_bytes(to_bytes(analyze(mouse, settings, kept=journal).to_datatree())))
    table = result.laws["linear"].posterior.table
    fitted = result.laws["linear"].calibration
    assert table["quantity"].values.tolist()[:1] == ["beta"]
    assert np.all(table["interval_low"] <= table["median"])
    assert np.all(table["median"] <= table["interval_high"])
    beta = table.sel(quantity="beta")
    assert float(beta["interval_low"]) < float(fitted["value"].sel(parameter="beta")) < float(beta["interval_high"])
    shares = sum(table[f"share_{name}"] for name in SOURCES)
    known = table["quantity"] != "discrepancy"  # which is no parameter
    np.testing.assert_allclose(shares[known], 1.0, atol=0.02)
    assert result.laws["linear"].posterior.draws("beta").ndim == 2
    said, notes = texts(from_json(table.attrs["findings"])), texts(result.findings)
    assert all(f"linear wall, posterior: {one}" in notes for one in said)
    kept = journal.simulations("linear")
    assert kept.is_file()
    again = analyze(mouse, settings, kept=Journal(tmp_path / "key.jsonl"))
    np.testing.assert_array_equal(again.laws["linear"].posterior.table["median"], table["median"])
    page = write_report([result], tmp_path / "report", pdf=False).with_name("supplement.html").read_text("utf-8")
    assert "Linear wall: posterior" in page


@pytest.mark.validation
def test_reference_draws_the_posterior_of_the_first_wall_law_alone(tmp_path):
    """One vessel with one unknown, for the sake of time."""
    network = Network(("1",), [-1], [0.4], [0.05])
    exact = dict.fromkeys(("radius_scale_sd", "length_scale_sd", "k_sd", "flow_gain_sd", "taper_sd"), 0.0)
    mouse = Animal("mouse", "CTL", network, virtual_mouse(), synthetic=True)
    settings = Settings(walls=("linear", "power"), starts=1, inference="reference", pressure_harmonics=8,
                        fixed={"r1": 1.0, "r2": 1.0, "c1": 1.0}, **exact)  # fmt: skip
    result = analyze(mouse, settings)
    assert {name: law.posterior is not None for name, law in result.laws.items()} == {"linear": True, "power": False}
    assert result.failures == ()
    assert result.evidence is None
    vessel = result.laws["linear"].vessels.isel(vessel=0)
    width = float(np.log(vessel["mean_shear_high"] / vessel["mean_shear_low"])) / (2 * 1.96)
    distended = np.log1p(virtual_mouse().mean_pressure / result.laws["linear"].posterior.draws("beta"))
    assert width == pytest.approx(3 * np.hypot(0.05, distended.std()), rel=0.25)  # shear goes with r⁻³, image: 5 %
    assert float(vessel["mean_shear_low"]) < float(vessel["mean_shear"]) < float(vessel["mean_shear_high"])
    assert "mean_shear_low" not in result.laws["power"].vessels
    page = write_report([result], tmp_path / "report", pdf=False).with_name("supplement.html").read_text("utf-8")
    assert "Linear wall: posterior" in page
    assert "Power wall: posterior" not in page
    assert "An evidence is" not in page
