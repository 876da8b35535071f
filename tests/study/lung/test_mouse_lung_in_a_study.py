"""The measured mouse lung: from VMTK's centerlines to a simulated tree of 532 vessels: in a study."""

import numpy as np
import pytest

from vasowave.catheter.read import read_recording
from vasowave.lung.exchange import read_centerlines
from vasowave.lung.measure import network_of
from vasowave.pulse.model import LinearWall, Model, Numerics, estimate_nominal, linear_solution
from vasowave.pulse.solver import simulate

VOXEL = 0.00427
"""cm, assumed: the file is in voxels and does not say their size."""


@pytest.fixture(scope="module")
def tree(shared):
    # A loop would warn, and warnings are errors.
    return read_centerlines(next((shared / "mouse-lung-centerline").glob("*.vtp")), unit=VOXEL)


@pytest.fixture(scope="module")
def mouse(shared):
    folder = shared / "mouse-c6"
    return read_recording(folder / "pC6_1024.dat", folder / "qC6_1024.dat", period=0.11)


@pytest.mark.validation
@pytest.mark.filterwarnings(
    "ignore:.*strained beyond:vasowave.base.errors.VasowaveWarning"
)  # another mouse's nominal wall
def test_the_lung_simulates_and_agrees_with_the_frequency_domain(tree, mouse):
    network = network_of(tree)
    nominal = estimate_nominal(network, mouse)
    model = Model(network, nominal.wall(LinearWall), nominal.outlets)
    result = simulate(model, mouse, Numerics(samples=128))
    assert result.attrs["converged"]
    assert result.attrs["volume_error"] < 1e-10
    p, q = result["pressure"].values, result["flow"].values
    assert np.isfinite(p).all()
    inlet = p[:, network.root, 0]
    # The beds take up R_T; what the 532 vessels add to the mean pressure is friction.
    beds = nominal.total_resistance * mouse.cardiac_output
    assert beds < inlet.mean() < 1.2 * beds
    assert q[:, network.terminals, -1].mean(0).sum() == pytest.approx(q[:, network.root, 0].mean(), rel=1e-5)
    drop = p[:, :, 0].mean(0) - p[:, :, -1].mean(0)
    assert (drop > -0.02).all()  # an expansion may win back some pressure
    linear = linear_solution(model, mouse.inflow, 40)
    predicted = linear.in_time(linear.pressure[:, network.root], result["time"].values)
    error = np.sqrt(np.mean((inlet - predicted) ** 2))
    print(f"inlet {inlet.min():.2f} {inlet.mean():.2f} {inlet.max():.2f} mmHg, linear theory within {error:.3f} rms, "
          f"{result.attrs['cycles']} cycles of {result.attrs['steps_per_cycle']} steps")  # fmt: skip
    assert error < 0.05 * np.ptp(inlet)
