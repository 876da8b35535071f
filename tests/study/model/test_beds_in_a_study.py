"""Vascular beds: each is one class, ours and a user's, and what it says of itself holds for solver, fit and files."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

import vasowave as vw
from vasowave.base import InputError
from vasowave.pulse.cycle import Recording
from vasowave.pulse.model import BEDS, Model, Numerics, Site, bed_quantities, changed_model, find_bed
from vasowave.pulse.solver import simulate
from vasowave.study.report import write_report

OWN = "our_beds:StiffTenth"
PAGE = Path(__file__).parents[3] / "docs" / "beds.md"
COARSE = Numerics(cell_size=0.3, samples=64, tolerance=1e-8)


def fork():
    return vw.Network(("1", "2", "3"), [-1, 0, 0], [0.41, 0.45, 0.37], [0.047, 0.026, 0.037])


@pytest.fixture(autouse=True)
def printed_bed(tmp_path, monkeypatch):
    """Put the program that the page on beds prints into the folder one is in."""
    programs = re.findall(r"```python\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)
    (program,) = (one for one in programs if "class StiffTenth" in one)
    (tmp_path / "our_beds.py").write_text(program, "utf-8")
    monkeypatch.chdir(tmp_path)
    return program


def nominal_beds(bed, network):
    return bed.of(network, Site(76.0, 0.12, 57.0, vw.Blood()))


def model_with(kind, scale=1.0):
    network = fork()
    beds = nominal_beds(find_bed(kind), network)
    return Model(network, vw.LinearWall(57.0), beds.scaled(*[scale] * len(beds.bed().factors)))


@pytest.mark.parametrize("kind", ["resistance", OWN, "blood_tree"])
def test_a_bed_is_swept_and_goes_to_the_programs_that_know_it(kind, inflow, tmp_path):
    model = model_with(kind)
    if kind == "blood_tree":
        mean = vw.sweep(model, inflow, {"dilation": [0.8, 1.0]}, COARSE)["root_pressure"].mean("time").values
        assert mean[0] > 1.8 * mean[1]  # 0.8^-4 is 2.4, and thin blood is less viscous
        for program in ("svzerod", "openbf"):
            with pytest.raises(InputError, match="this model has BloodTree"):
                vw.export_model(model, inflow, program, tmp_path / program, numerics=COARSE)
        return
    mean = vw.sweep(model, inflow, {"R_T": [60.0, 120.0]}, COARSE)["root_pressure"].mean("time").values
    rise = (mean[1] - mean[0]) / (60.0 * inflow.flow.mean())
    assert 0.9 < rise < 1.001  # the beds' resistance alone would give 1; vessels widen with pressure, and rub less
    assert changed_model(model, {"R_T": 120.0}).outlets.total_resistance() == pytest.approx(120.0)
    with pytest.raises(InputError, match="this model has no parameter 'a'"):
        vw.sweep(model, inflow, {"a": [0.1]}, COARSE)
    vw.export_model(model, inflow, "tables", tmp_path / "tables", numerics=COARSE)
    header = (tmp_path / "tables/parameters.csv").read_text("utf-8").splitlines()[0]
    assert header.count("R [mmHg s/ml]") == 1
    vw.export_model(model, inflow, "svzerod", tmp_path / "lumped", numerics=COARSE)
    beds = json.loads((tmp_path / "lumped/svzerod.json").read_text("utf-8"))["boundary_conditions"][1:]
    assert {one["bc_type"] for one in beds} == {"RESISTANCE" if kind == "resistance" else "RCR"}
    if kind == "resistance":
        with pytest.raises(InputError, match="openBF knows three-element Windkessels as outlets only"):
            vw.export_model(model, inflow, "openbf", tmp_path / "openbf", numerics=COARSE)


@pytest.mark.validation
@pytest.mark.parametrize("kind", ["rc", "resistance", OWN, "blood_tree"])
def test_a_bed_goes_from_an_analysis_to_posterior_report_and_stored_model(kind, inflow, tmp_path, undrawn):
    pressure = simulate(model_with(kind), inflow, COARSE)["pressure"].values[:, 0, 0]
    noise = 0.1 * np.random.default_rng(1).standard_normal(len(pressure))
    cycle = Recording(pressure + noise, inflow.flow, inflow.period)
    animal = vw.Animal("mouse", "CTL", fork(), cycle, synthetic=True)
    settings = vw.Settings(walls=("linear",), beds=kind, starts=1, numerics=COARSE, inference="posterior",
                           pressure_harmonics=8)  # fmt: skip
    result = vw.analyze(animal, settings)
    linear, said = result.laws["linear"], find_bed(kind).bed()
    quantities = linear.quantities
    free = [name for name, one in said.factors.items() if not one.held]
    names = [name if kind in BEDS else f"stiff_tenth.{name}" for name in free]
    assert set(names) <= set(linear.posterior.groups["posterior"].data_vars)
    assert ("C_p" in quantities) == (kind != "resistance")
    assert ("a" in quantities) == (kind in (OWN, "blood_tree"))
    if kind == "resistance":
        assert "C_p_over_C_T" not in quantities
        assert float(quantities["tau"]) == pytest.approx(float(quantities["R_T"] * quantities["C_v"]))
    page = write_report([result], tmp_path / "report").with_name("supplement.html").read_text("utf-8")
    assert said.title in page
    assert "r1·R1" not in page
    model = vw.stored_model(result)
    assert type(model.outlets) is find_bed(kind)
    stored = [linear.calibration[name].values for name in bed_quantities(type(model.outlets))]
    np.testing.assert_array_equal(list(model.outlets), stored)


def test_unknown_beds_are_refused_with_the_nearest_known_ones():
    with pytest.raises(InputError, match=r"unknown beds 'windkesel' \(did you mean 'windkessel'\?\)"):
        vw.Settings(beds="windkesel")
    with pytest.raises(InputError, match="no parameter 'r1'"):
        vw.Settings(beds="rc", fixed={"r1": 1.0})
