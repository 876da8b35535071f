"""Vascular beds: each is one class, ours and a user's, and what it says of itself holds for solver, fit and files."""

import re
from pathlib import Path

import numpy as np
import pytest

import vasowave as vw
from vasowave.base import InputError
from vasowave.pulse.calibration import calibrate
from vasowave.pulse.cycle import Recording
from vasowave.pulse.model import Model, Numerics, Site, find_bed, identity
from vasowave.pulse.solver import direction_between, pressure_derivatives, run_to_periodic, simulate

PAGE = Path(__file__).parents[3] / "docs" / "beds.md"
OWN = "our_beds:StiffTenth"
COARSE = Numerics(cell_size=0.3, samples=64, tolerance=1e-8)
CIRCUITS = ("windkessel", "rc", "resistance", "reflection", OWN)
KINDS = (*CIRCUITS, "tree", "blood_tree")
every_kind = pytest.mark.parametrize("kind", KINDS)


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


@every_kind
def test_a_bed_is_found_by_its_identity_and_has_the_resistance_it_is_given(kind):
    bed = find_bed(kind)
    assert find_bed(identity(bed)) is bed is find_bed(bed)
    beds = nominal_beds(bed, fork())
    assert beds.total_resistance() == pytest.approx(76.0)
    assert len(bed.bed().factors) == len(bed.bed().fitted or beds._fields)


@every_kind
def test_waves_at_the_ends_of_vessels_have_the_impedance_of_their_beds(kind, inflow):
    """The bed's own formula at every harmonic that carries flow, against what the steps in time made of it."""
    model = model_with(kind)
    steps = 4096
    waves = simulate(model, inflow, Numerics(cell_size=0.1, samples=512, steps_per_cycle=steps, tolerance=1e-9))
    ends = waves.sel(station="outlet").isel(vessel=model.network.terminals)
    P, Q = (np.fft.rfft(ends[name].transpose("time", "vessel").values, axis=0)[:9] for name in ("pressure", "flow"))
    omega = 2 * np.pi / inflow.period * np.arange(9)
    np.testing.assert_allclose(P / Q, model.outlets.impedance(omega), rtol=2e-3)  # of the steps and of rounded flows
    assert waves.attrs["cycles"] <= 8  # the slow modes are known after the first


@pytest.mark.parametrize(
    "kind", [OWN, *(pytest.param(kind, marks=pytest.mark.validation) for kind in KINDS if kind != OWN)]
)
def test_a_fit_finds_what_was_planted(kind, inflow):
    network, bed = fork(), find_bed(kind)
    free = (name for name, one in bed.bed().factors.items() if not one.held)
    planted = dict(zip(free, (1.3, 0.8, 1.2), strict=False))
    beds = nominal_beds(bed, network).scaled(*(planted.get(name, 1.0) for name in bed.bed().factors))
    truth = Model(network, vw.LinearWall(57.0), beds)
    pressure = simulate(truth, inflow, COARSE)["pressure"].values[:, 0, 0]
    fit = calibrate(network, Recording(pressure, inflow.flow, inflow.period), bed=bed, numerics=COARSE,
                    search=vw.Search(starts=2))  # fmt: skip
    assert fit.S < 1e-4 * fit.N
    assert fit.parameters["value"]["beta"] == pytest.approx(57.0, rel=2e-3)
    omega = 2 * np.pi / inflow.period * np.arange(6)
    np.testing.assert_allclose(fit.model.outlets.impedance(omega), truth.outlets.impedance(omega), rtol=5e-3)


@every_kind
def test_derivatives_by_the_fields_of_a_bed_are_those_of_the_runs(kind, inflow):
    step, numerics = 1e-4, Numerics(cell_size=0.3, samples=64, tolerance=1e-10, steps_per_cycle=256)
    below, above = (model_with(kind, np.exp(side * step)) for side in (-1, 1))
    runs = [run_to_periodic(model, inflow, numerics) for model in (below, above)]
    expected = (runs[1].inlet_pressure(256) - runs[0].inlet_pressure(256)) / (2 * step)
    run = run_to_periodic(model_with(kind), inflow, numerics)
    found = pressure_derivatives(run, inflow, [direction_between(below, above, 2 * step)], numerics)[0]
    assert np.abs(found - expected).max() < 1e-3 * np.abs(expected).max()


SLIPS = {
    "no resistance": ("0.9 * R, C)", "0.5 * R, C)", "does not have that resistance"),
    "a missing part": ("Circuit(0.1 * R, 0.9 * R, C)", "(0.1 * R, 0.9 * R)", "must return three arrays"),
    "a factor too few": ('"c": Parameter', '"r": Parameter', "describe each, with one factor each"),
    "a taken name": ('BedLaw("stiff_tenth"', 'BedLaw("rc"', "a name of its own"),
    "bounds exchanged": ("bounds=(0.02, 20.0)", "bounds=(20.0, 0.02)", "factor 'c': .*bounds positive and ordered"),
    "an error": (
        "return cls(resistance, time_constant / resistance)",
        "return cls(1 / 0, 1)",
        r"our_beds\.py, line 25",
    ),
    "another base": ("class StiffTenth(Bed)", "class StiffTenth", "is not a bed"),
}


@pytest.mark.parametrize("slip", SLIPS)
def test_a_slip_in_a_bed_is_told(slip, printed_bed, tmp_path):
    right, wrong, said = SLIPS[slip]
    assert printed_bed.count(right) == 1
    (tmp_path / "our_beds.py").write_text(printed_bed.replace(right, wrong), "utf-8")
    with pytest.raises(InputError, match=said):
        find_bed(OWN)
