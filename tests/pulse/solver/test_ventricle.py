"""A ventricle at the inlet: an elastance and a valve that drive the network."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from vasowave.base import InputError, NumericalError
from vasowave.pulse.cycle import Inflow
from vasowave.pulse.model import LinearWall, Model, Numerics, TangentWall, Ventricle, activation, windkessels
from vasowave.pulse.network import Network
from vasowave.pulse.solver import (
    Places,
    derivatives,
    direction_between,
    require_emptied,
    simulate,
    simulate_run,
    ventricular_waves,
    waves_at,
)

PERIOD, INLET = 0.11, Places(np.array([0]), np.array([0.0]))
NUMERICS = Numerics(cell_size=0.1, steps_per_cycle=4096, samples=256, tolerance=1e-7)


def ventricle(**changes):
    values = {"peak": 1400.0, "rest": 100.0, "period": PERIOD, "filling_pressure": 4.0} | changes
    return Ventricle.from_peak(**values)


LINEAR = LinearWall(57.0)
LONG = pytest.mark.validation  # kernels of their own are compiled for some seconds


def fork(wall=LINEAR, R_T=76.0, **more):
    network = Network(
        ("a", "b", "c"), np.array([-1, 0, 0]), np.array([0.75, 0.55, 0.35]), np.array([0.047, 0.037, 0.026])
    )
    return Model(network, wall, windkessels(network, R_T, 0.11, a=0.2), **more)


def at_inlet(run, driven):
    waves = waves_at(run, driven, INLET)
    return waves.pressure[:, 0], waves.flow[:, 0]


def test_a_stub_before_a_windkessel_is_the_ordinary_differential_equation():
    """A vessel of half a millimeter and a stiff wall is nothing: what is left has three elements and a ventricle."""
    stub = Network(("stub",), np.array([-1]), np.array([0.05]), np.array([0.3]))
    model = Model(stub, LinearWall(8000.0), windkessels(stub, 76.0, 0.12, a=0.1))
    bed, heart = model.outlets, ventricle(valve_resistance=1.0)
    Z, R, C = (float(np.ravel(value)[0]) for value in (bed.R1, bed.R2, bed.C))

    def change(t, state):
        volume, charge = state
        stiff = 100.0 + 1300.0 * activation(t / PERIOD, 0.35)
        flow = max((stiff * volume - charge) / (Z + heart.valve_resistance), 0.0)
        return -flow, (flow - charge / R) / C

    charge = 10.0
    for _ in range(20):
        solved = solve_ivp(change, (0, PERIOD), (heart.filled, charge), max_step=PERIOD / 200, rtol=1e-9, atol=1e-11)
        charge = solved.y[1, -1]
    run = simulate_run(model, heart, Numerics(samples=64))
    pressure, flow = ventricular_waves(heart, run.at_inlet[1])[0], run.at_inlet[1]
    volume = np.interp(np.arange(run.steps) * PERIOD / run.steps, solved.t, solved.y[0])
    true = (100 + 1300 * activation(solved.t / PERIOD, 0.35)) * solved.y[0]
    assert np.max(np.abs(ventricular_waves(heart, flow)[1] - volume)) < 0.003 * np.ptp(volume)
    assert flow.sum() * PERIOD / run.steps == pytest.approx(heart.filled - solved.y[0, -1], rel=1e-3)
    assert pressure.max() == pytest.approx(true.max(), rel=1e-3)


@pytest.mark.parametrize(
    "model",
    [
        fork(),
        pytest.param(
            fork(TangentWall(9.0, 4.0), outlet_pressure=3.0), marks=pytest.mark.validation
        ),  # kernels of their
        fork(junctions="total"),
        pytest.param(fork(wall_viscosity=0.05), marks=LONG),
    ],
    ids=["linear", "tangent before a wedge", "total pressure", "viscous"],
)
def test_what_a_ventricle_ejects_makes_its_pressure_again_as_an_inflow(model):
    heart = ventricle()
    run = simulate_run(model, heart, NUMERICS)
    pressure, flow = at_inlet(run, heart)
    again = Inflow(run.at_inlet[1], PERIOD)
    driven = simulate_run(model, again, NUMERICS)
    assert np.max(np.abs(at_inlet(driven, again)[0] - pressure)) < 1e-4
    assert abs(run.volume_error) < 1e-10
    assert flow.min() > -1e-9


def test_the_open_valve_joins_the_pressures_and_the_closed_one_lets_nothing_through():
    heart = ventricle(valve_resistance=2.0)
    run = simulate_run(fork(), heart, NUMERICS)
    inside, _ = ventricular_waves(heart, run.at_inlet[1])
    pressure, flow = run.inlet_pressure(run.steps), run.at_inlet[1]
    is_open = flow > 1e-9
    assert 0.2 < is_open.mean() < 0.6
    assert np.max(np.abs(inside - pressure - 2.0 * flow)[is_open]) < 1e-6
    closed = ~is_open & ~np.roll(is_open, 1)
    assert np.max(np.abs(flow[closed])) < 1e-12
    assert np.all(inside[closed] <= pressure[closed] + 1e-9)


def test_the_loop_of_pressure_and_volume_is_the_work_that_enters_the_network():
    heart = ventricle()
    waves = simulate(fork(), heart, Numerics(cell_size=0.05, samples=1024))
    flow, pressure = (waves[name].sel(vessel="a", station="inlet").to_numpy() for name in ("flow", "pressure"))
    entered = np.mean(pressure * flow) * PERIOD
    inside, volume = waves.ventricular_pressure.to_numpy(), waves.ventricular_volume.to_numpy()
    ejected = -np.trapezoid(inside, volume)
    lost = heart.valve_resistance * np.mean(flow**2) * PERIOD
    assert ejected == pytest.approx(entered + lost, rel=0.003)


def test_end_systolic_points_under_other_resistances_lie_on_the_elastance():
    """Suga's experiment: the load changes, the line through the upper left corners of the loops does not."""
    heart, corners, strokes = ventricle(), [], []
    for R_T in (50.0, 76.0, 120.0, 200.0):
        run = simulate_run(fork(R_T=R_T), heart, NUMERICS)
        pressure, volume = ventricular_waves(heart, run.at_inlet[1])
        corner = np.argmax(pressure / volume)
        corners.append((volume[corner], pressure[corner]))
        strokes.append(heart.filled - volume[-1])
    volume, pressure = np.transpose(corners)
    slope, intercept = np.polyfit(volume, pressure, 1)
    assert slope == pytest.approx(1400.0, rel=1e-4)
    assert abs(intercept) < 0.1
    assert np.all(np.diff(strokes) < 0)


def test_the_volume_that_is_ejected_does_not_depend_on_the_step():
    heart = ventricle()
    strokes = []
    for steps in (2048, 4096, 8192):
        run = simulate_run(fork(), heart, replace(NUMERICS, steps_per_cycle=steps))
        strokes.append(run.at_inlet[1].mean() * PERIOD)
    assert np.ptp(strokes) < 1e-5 * strokes[2]


def test_derivatives_of_a_network_behind_a_ventricle_are_refused():
    model, heart = fork(), ventricle()
    run = simulate_run(model, heart, NUMERICS)
    direction = direction_between(model, fork(R_T=80.0), 4.0)
    with pytest.raises(InputError, match="derivatives"):
        derivatives(run, heart, [direction], NUMERICS, (INLET, waves_at(run, heart, INLET)))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"peak": 90.0}, "below that of the peak"),
        ({"rest": 0.0}, "the elastance at rest, 0, is positive and"),
        ({"at": 1.5}, "between 0 and 1"),
        ({"filling_pressure": -1.0}, "filling_pressure of a ventricle is -1 mmHg"),
        ({"period": np.nan}, "period of a ventricle"),
        ({"valve_resistance": 0.0}, "valve_resistance"),
    ],
)
def test_a_ventricle_that_cannot_be_says_why(changes, words):
    with pytest.raises(InputError, match=words):
        ventricle(**changes)


@pytest.mark.parametrize("elastance", [np.ones(10), np.ones((64, 2)), np.zeros(64), np.full(64, np.nan)])
def test_an_elastance_is_one_row_of_positive_numbers(elastance):
    with pytest.raises(InputError, match="elastance"):
        Ventricle(elastance, 0.1, 4.0)


def test_a_ventricle_that_does_not_end_or_never_ejects_says_so():
    with pytest.raises(NumericalError, match="still ejects"):
        require_emptied(ventricle(), np.linspace(0.0, 1.0, 64))
    with pytest.raises(NumericalError, match="valve never opens"):
        simulate_run(fork(outlet_pressure=30.0), ventricle(filling_pressure=1.0), NUMERICS)
