"""The measured mouse lung: from VMTK's centerlines to a simulated tree of 532 vessels."""

import numpy as np
import pytest

from vasowave.catheter.read import read_recording
from vasowave.lung.exchange import read_centerlines
from vasowave.lung.measure import network_of, taper
from vasowave.lung.revise import largest_vessels
from vasowave.pulse.model import LinearWall, Model, Numerics, estimate_nominal, linear_solution
from vasowave.pulse.network import implausible_sizes
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


def test_the_lung_is_one_tree_of_plausible_vessels(tree):
    network = network_of(tree)
    assert len(network) == 532
    assert implausible_sizes(network) == []
    assert network.radius[network.root] == network.radius.max()
    # The root is the control mouse's main pulmonary artery: 0.047 cm in the paper, at another voxel size perhaps.
    assert 0.035 < network.radius[network.root] < 0.055
    inner = [row for row in range(len(network)) if network.daughters[row]]
    # Murray-like branching: the daughters' areas together are about that of the parent, and no daughter is much wider.
    ratio = np.array([sum(network.area[d] for d in network.daughters[row]) / network.area[row] for row in inner])
    assert 0.9 < np.median(ratio) < 1.6
    wider = [max(network.radius[d] for d in network.daughters[row]) / network.radius[row] for row in inner]
    assert np.quantile(wider, 0.95) < 1.1


def test_the_lungs_long_vessels_taper_away_from_the_heart(tree):
    slope = taper(tree).slope
    long = network_of(tree).length > 0.1
    assert long.sum() > 30
    # Radii halve over some centimeters: about 1 cm per 50 cm, and most vessels narrow.
    assert 0.005 < np.nanmedian(slope[long]) < 0.05
    assert np.nanmean(slope[long] > 0) > 0.7


def test_the_largest_21_vessels_of_the_lung_are_a_network_like_the_papers(tree):
    network = network_of(tree)
    rows = largest_vessels(network, 21)
    assert len(rows) == 21
    kept = set(rows.tolist())
    assert all(network.parent[row] in kept for row in rows if row != network.root)
    assert all(set(network.daughters[row]) <= kept or not kept & set(network.daughters[row]) for row in rows)
    left = network.radius[[row for row in range(len(network)) if row not in kept]]
    assert np.median(network.radius[rows]) > np.quantile(left, 0.95)


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
