"""The measured mouse lung: from VMTK's centerlines to a simulated tree of 532 vessels."""

import numpy as np
import pytest

from vasowave.lung.exchange import read_centerlines
from vasowave.lung.measure import network_of, taper
from vasowave.lung.revise import largest_vessels
from vasowave.pulse.network import implausible_sizes

VOXEL = 0.00427
"""cm, assumed: the file is in voxels and does not say their size."""


@pytest.fixture(scope="module")
def tree(shared):
    # A loop would warn, and warnings are errors.
    return read_centerlines(next((shared / "mouse-lung-centerline").glob("*.vtp")), unit=VOXEL)


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
