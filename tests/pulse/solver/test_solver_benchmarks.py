"""The field's benchmark cases that the model can express, against digitized three-dimensional solutions and theory.

Common carotid, thoracic aorta and aortic bifurcation (Boileau et al. 2015, Xiao et al. 2014), and one pulse in a tube
of 10 m. Walls are p = 4/3 E h/R0 (√(A/A0) - 1): β = 4/3 E h/R0.
"""

from dataclasses import replace

import numpy as np
import pytest

from vasowave.base import MMHG, VasowaveWarning
from vasowave.pulse.cycle import Inflow
from vasowave.pulse.model import Blood, LinearWall, Model, Numerics, PowerLaw, Windkessel
from vasowave.pulse.network import Network
from vasowave.pulse.solver import simulate

pytestmark = pytest.mark.validation

PASCAL = 10 / MMHG  # mmHg
RESISTANCE = PASCAL * 1e-6  # Pa s/m³ in mmHg s/ml
COMPLIANCE = 1e6 / PASCAL  # m³/Pa in ml/mmHg


@pytest.fixture(scope="module")
def cases(shared):
    folder = shared / "benchmarks"
    if not folder.is_dir():
        pytest.skip("the field's benchmark cases are not beside the project (benchmarks is absent)")
    return folder


def _inflow(path, period=None) -> Inflow:
    """Return a table of time (s) and flow (m³/s; digitized ones: ml/s and in any order) as an inflow."""
    time, flow = np.loadtxt(path, delimiter="," if path.suffix == ".csv" else None).T
    flow = flow if path.suffix == ".csv" else 1e6 * flow
    order, period = np.argsort(time), period or float(time[-1])
    return Inflow(np.interp(np.arange(256) * period / 256, time[order], flow[order], period=period), period)


def _model(name, parents, lengths, radii, modulus, thickness, exponent, bed):
    """Return a model from values in m, Pa and their products."""
    network = Network(name, np.array(parents), 100 * np.array(lengths), 100 * np.array(radii))
    beta = PASCAL * 4 / 3 * np.array(modulus) * np.array(thickness) / np.array(radii)
    R1, R2, C = bed
    outlets = Windkessel(RESISTANCE * R1, RESISTANCE * R2, COMPLIANCE * C)
    return Model(network, LinearWall(beta), outlets, Blood(1.060, 0.04 / 1.060, PowerLaw(exponent)))


def _distance(result, vessel, station, path):
    """Root mean square of the difference to a digitized pressure (s, Pa), as a share of its mean."""
    time, pressure = np.loadtxt(path, delimiter=",").T
    waves = result.pressure.sel(vessel=vessel, station=station).values
    period = result.attrs["period"]
    ours = np.interp(time, np.arange(len(waves) + 1) * period / len(waves), np.append(waves, waves[0]), period=period)
    return float(np.sqrt(np.mean((ours / PASCAL - pressure) ** 2)) / pressure.mean())


def test_common_carotid(cases):
    """With the inflow of the three-dimensional solution itself: the tabulated one is the same, 0.06 s later."""
    folder = cases / "digitised_3D_chezzoba" / "common_carotid_artery"
    inflow = _inflow(folder / "CC_inlet_BC.csv", 1.1)
    model = _model(("cca",), [-1], [0.126], [2.6485e-3], [7e5], [0.24e-3], 2, (2.4875e8, 1.8697e9, 1.7529e-10))
    result = simulate(model, inflow, Numerics(accuracy=0.05))
    for station, file in (("inlet", "inlet"), ("middle", "mid"), ("outlet", "outlet")):
        assert _distance(result, "cca", station, folder / f"{file}_pressure.csv") < 0.007, station


def test_thoracic_aorta(cases):
    inflow = _inflow(cases / "boileau2015_inputs_openBF" / "uta" / "uta_inlet.dat")
    model = _model(("uta",), [-1], [0.24137], [9.87e-3], [4e5], [0.82e-3], 9, (1.1752e7, 1.1167e8, 1.0163e-8))
    result = simulate(model, inflow, Numerics(accuracy=0.05))
    folder = cases / "digitised_3D_chezzoba" / "uper_thoracic_aorta"
    for station, file in (("inlet", "Inlet"), ("middle", "midpoint"), ("outlet", "outlet")):
        assert _distance(result, "uta", station, folder / f"{file}_pressure.csv") < 0.017, station


def test_aortic_bifurcation(cases):
    inflow = _inflow(cases / "boileau2015_inputs_openBF" / "ibif" / "ibif_inlet.dat")
    model = _model(
        ("aorta", "left", "right"), [-1, 0, 0], [0.086, 0.085, 0.085], [7.581e-3, 5.492e-3, 5.492e-3],
        [5e5, 7e5, 7e5], [0.9e-3, 0.68e-3, 0.68e-3], 9, (6.8123e7, 3.1013e9, 3.6664e-10),
    )  # fmt: skip
    result = simulate(model, inflow, Numerics(accuracy=0.05))
    folder = cases / "digitised_3D_chezzoba" / "bifurcation"
    places = (("aorta", "inlet", "Inlet_ao"), ("aorta", "middle", "mid_ao"), ("aorta", "outlet", "junction"))
    for vessel, station, file in (*places, ("left", "middle", "mid_il"), ("left", "outlet", "outlet_il")):
        assert _distance(result, vessel, station, folder / f"{file}_Pressure.csv") < 0.011, (vessel, station)


def _pulse() -> tuple[Model, Inflow]:
    """A pulse of 1 ml/s and 17 ms in a tube of 10 m without friction, whose end reflects nothing at rest."""
    beta, density, radius = PASCAL * 4 / 3 * 4e5 * 1.5e-3 / 1e-2, 1.05, 1.0
    network = Network(("tube",), np.array([-1]), np.array([1000.0]), np.array([radius]))
    inertia = density / MMHG
    Z_c = inertia * np.sqrt(beta / (2 * inertia)) / (np.pi * radius**2)
    outlets = Windkessel(0.999 * Z_c, 0.001 * Z_c, 1.0)
    t = 2.0 * np.arange(2048) / 2048
    return Model(network, LinearWall(beta), outlets, Blood(density, 0.0)), Inflow(np.exp(-1e4 * (t - 0.05) ** 2), 2.0)


def test_a_pulse_keeps_its_peak_over_ten_meters_where_an_accuracy_is_asked():
    """Without friction it must arrive as it left; cells of 0.5 cm lose 6 to 11 % of it, and the solver says so.

    An independent run found 11 % with 4096 steps; with the 3072 of the solver's choice waves disperse less.
    """
    model, inflow = _pulse()
    plain = Numerics(cell_size=0.5, samples=2048)  # fewer samples would miss the peak
    with pytest.warns(VasowaveWarning, match="depends on the grid"):
        coarse = [simulate(model, inflow, replace(plain, steps_per_cycle=steps)) for steps in (4096, None)]
    fine = simulate(model, inflow, replace(plain, accuracy=0.002))
    kept = [float(np.divide(*run.pressure.values[:, 0, [2, 0]].max(axis=0))) for run in (*coarse, fine)]
    np.testing.assert_allclose(kept, [0.893, 0.941, 1.0], atol=0.01)
    arrival = float(
        fine.time[fine.pressure.values[:, 0, 2].argmax()] - fine.time[fine.pressure.values[:, 0, 0].argmax()]
    )
    assert arrival == pytest.approx(1000 / np.sqrt(model.wall.beta[0] / (2 * model.blood.inertia)), rel=0.003)
