"""What simulations and fits cost, in counts that every machine repeats: what makes them dearer shows itself here.

A limit is what was counted when it was set, and a tenth for rounding elsewhere. Whoever needs less lowers it; whoever
needs more says why.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from vasowave import pulse
from vasowave.pulse.calibration import Search
from vasowave.pulse.cycle import Recording
from vasowave.pulse.examples import control_network, virtual_mouse
from vasowave.pulse.inference import posterior
from vasowave.pulse.model import LinearWall, Model, Numerics, TangentWall, estimate_nominal
from vasowave.pulse.solver import simulate
from work import Work, work_of

NETWORK, MOUSE = control_network(), virtual_mouse()
C6 = Path(__file__).parents[3] / ".." / "shared" / "data" / "mouse-c6"


def assert_within(work: Work, **limits: int) -> None:
    counted = work._asdict()
    assert {name: counted[name] for name in limits if counted[name] > limits[name]} == {}, (work, limits)
    assert all(counted[name] > 0 for name in limits)  # else the functions that are counted have other names now


@pytest.mark.parametrize("wall", [LinearWall, TangentWall])
def test_a_simulation_takes_three_cycles_and_one_linear_answer(wall):
    nominal = estimate_nominal(NETWORK, MOUSE)
    model = Model(NETWORK, nominal.wall(wall), nominal.outlets)
    assert_within(work_of(lambda: simulate(model, MOUSE)), cycles=3, linear=1)


@pytest.mark.parametrize(
    ("wall", "limits"),
    [
        ("linear", {"cycles": 37, "linearized": 38, "linear": 358}),
        pytest.param(
            "tangent", {"cycles": 67, "linearized": 68, "linear": 2886}, marks=pytest.mark.validation
        ),  # seconds; the look for a filter asks the linear network, which costs a hundredth, in place of simulations
    ],
    ids=["linear", "tangent"],
)
def test_a_fit_of_the_demo_asks_for_so_many_cycles(wall, limits):
    """From four starts, as the demo has them."""
    fits = []
    work = work_of(lambda: fits.append(pulse.calibrate(NETWORK, MOUSE, wall, search=Search(starts=4))))
    assert_within(work, **limits)
    assert fits[0].starts["simulations"].sum() <= {"linear": 9, "tangent": 18}[wall]


def test_a_lag_beside_the_parameters_asks_for_few_cycles_since_one_simulation_speaks_for_every_lag():
    omega = 2 * np.pi / MOUSE.period * np.arange(len(MOUSE.pressure) // 2 + 1)
    filtered = np.fft.irfft(np.fft.rfft(MOUSE.pressure) / (1 + 0.003j * omega), len(MOUSE.pressure))
    late, fits = replace(MOUSE, pressure=filtered), []
    work = work_of(lambda: fits.append(pulse.calibrate(NETWORK, late, "linear", starts=1, pressure_lag_sd=0.003)))
    assert_within(work, cycles=73, linearized=88, linear=850)
    assert fits[0].response["pressure_lag"].value == pytest.approx(0.003, abs=6e-4)


def test_twenty_starts_of_the_measured_mouse_ask_for_so_many_cycles():
    if not C6.is_dir():
        pytest.skip("the measured mouse is not beside the project (mouse-c6 is absent)")
    pressure, flow = (np.loadtxt(C6 / f"{name}C6_1024.dat")[:-1] for name in "pq")
    mouse = Recording(pressure, flow, 0.11)
    work = work_of(lambda: pulse.calibrate(NETWORK, mouse, "linear", search=Search(starts=20)))
    assert_within(work, cycles=41, linearized=51, linear=1478)


@pytest.mark.validation
def test_a_posterior_asks_for_so_many_cycles():
    coarse, few = Numerics(cell_size=0.4, samples=128), Search(pressure_harmonics=16)
    work = work_of(lambda: posterior(NETWORK, MOUSE, draws=100, numerics=coarse, search=few))
    # Where walkers turn hangs on the last digit: 807 to 818 cycles and 2 099 to 2 109 answers by processor and process.
    assert_within(work, cycles=835, linear=2150)
