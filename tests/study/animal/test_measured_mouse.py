"""Mouse C6, measured, and the waveforms that the paper's own program computes for it."""

import json

import numpy as np
import pandas as pd
import pytest

from vasowave.base import MMHG
from vasowave.catheter.read import read_recording
from vasowave.pulse.calibration import Search, calibrate
from vasowave.pulse.cycle import Inflow, Recording, resample
from vasowave.pulse.examples import control_network
from vasowave.pulse.model import Blood, BoundaryLayer, LinearWall, Model, Numerics, Windkessel, estimate_nominal
from vasowave.pulse.network import Network
from vasowave.pulse.solver import PAPER, simulate


@pytest.fixture(scope="module")
def mouse(shared):
    folder = shared / "mouse-c6"
    return read_recording(folder / "pC6_1024.dat", folder / "qC6_1024.dat", period=0.11)


def test_nominal_parameters_of_mouse_c6_are_the_published_ones(mouse):
    nominal = estimate_nominal(control_network(), mouse)
    assert nominal.beta == pytest.approx(26.0, rel=0.05)
    assert nominal.total_resistance == pytest.approx(87.0, rel=0.05)
    assert nominal.time_constant == pytest.approx(0.14, rel=0.05)


@pytest.mark.parametrize("case", ["boundary-layer-friction", "constant-friction"])
def test_waveforms_agree_with_the_authors_program(shared, case):
    folder = shared / "reference-c6" / case
    given = json.loads((folder / "parameters.json").read_text())
    table, waves = pd.read_csv(folder / "network.csv"), pd.read_csv(folder / "waveforms.csv")
    control = control_network()
    network = Network(control.name, control.parent, table["L_eff_cm"].to_numpy(), control.radius)
    at = network.terminals
    columns = ["R1_mmHg_s_ml", "R2_mmHg_s_ml", "C_ml_mmHg"]
    outlets = Windkessel(*(table[column].to_numpy()[at] for column in columns))
    friction = BoundaryLayer(0.07) if case == "constant-friction" else BoundaryLayer()
    blood = Blood(given["rho"] * MMHG / given["conv"], given["nu"], friction)  # that program's conversion
    model = Model(network, LinearWall(given["beta_mmHg"]), outlets, blood)
    inflow = Inflow(pd.read_csv(folder / "inflow.csv")["q_ml_s"].to_numpy()[:-1], given["T_s"])
    result = simulate(model, inflow, Numerics(cell_size=0.025, samples=512, tolerance=1e-7))
    pressure = np.roll(result.pressure.values, -1, axis=0)  # its first line stands at T/512
    for v in range(21):
        for s, station in enumerate(("in", "mid", "out")):
            if station == "mid" and table["N_intervals"][v] % 2:
                continue  # that program's middle of an odd number of intervals is not the middle
            error = np.max(np.abs(pressure[:, v, s] - waves[f"p{v + 1}_{station}_mmHg"]))
            assert error < (0.005 if (v, station) == (0, "in") else 0.02), (v + 1, station, error)


def test_our_model_of_mouse_c6(mouse):
    fit = calibrate(control_network(), mouse, "linear", search=Search(starts=4))
    assert fit.parameters["value"]["beta"] == pytest.approx(57.3, rel=0.02)
    assert fit.total_resistance == pytest.approx(76.2, rel=0.02)
    assert fit.resistance_ratio == pytest.approx(0.127, rel=0.03)
    assert pytest.approx(149 / 1024, rel=0.02) == fit.mean_square
    assert (fit.compared.harmonics, fit.N) == (16, 33)
    pressure = fit.simulation.pressure.sel(vessel="1", station="inlet").values
    assert pressure.mean() == pytest.approx(mouse.mean_pressure, abs=0.3)
    assert pressure.max() == pytest.approx(mouse.systolic_pressure, abs=0.3)
    assert pressure.min() == pytest.approx(mouse.diastolic_pressure, abs=0.3)
    assert fit.starts["agrees"].all()


def test_the_papers_practice_gives_the_papers_optimum(shared):
    """Fixed friction radius, eight cycles from rest, lengths rounded down; a is found as 5.51 % (published 5.4 %)."""
    folder = shared / "mouse-c6"
    pressure = np.loadtxt(folder / "pC6_1024.dat")
    flow = np.loadtxt(folder / "qC6_8192.dat")[:-1]
    # That program's sample k stands at (k + 1) T/1024 and was compared with line k of the file.
    recording = Recording(np.roll(pressure, 1), resample(flow, 1024), 0.11)
    numerics, blood = PAPER
    search = Search(starts=1, paper_bounds=True, pressure_harmonics="all")
    network = PAPER.network(control_network())
    fit = calibrate(network, recording, "linear", blood=blood, search=search, numerics=numerics)
    assert fit.parameters["value"]["beta"] == pytest.approx(52.1, rel=0.01)
    assert fit.total_resistance == pytest.approx(65.6, rel=0.01)
    assert pytest.approx(125, rel=0.02) == fit.S
    assert fit.resistance_ratio == pytest.approx(0.0551, abs=0.0005)
