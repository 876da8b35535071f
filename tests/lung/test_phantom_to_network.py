import warnings

import numpy as np
import pytest

from phantom import embed, render, write_dicom_series
from vasowave.base import InputError, VasowaveWarning
from vasowave.lung import Options, extract, match
from vasowave.lung.exchange import write_network_table
from vasowave.lung.lumen import segment
from vasowave.lung.read import Volume, read_volume
from vasowave.pulse.network import Network
from vasowave.pulse.network_formats import read_network


@pytest.fixture(scope="module")
def fork():
    """A parent and two daughters, thick against the voxels."""
    network = Network(("a", "b", "c"), np.array([-1, 0, 0]), np.array([0.4, 0.4, 0.3]), np.array([0.052, 0.04, 0.03]))
    rng = np.random.default_rng(5)
    embedding = embed(network, rng)
    return network, embedding, render(embedding, 140, 0.0085, rng)


def test_the_bright_volume_of_a_straight_tube_is_that_of_a_cylinder():
    network = Network(("a",), np.array([-1]), np.array([0.5]), np.array([0.05]))
    embedding = embed(network, np.random.default_rng(1), cannula=0.05)
    volume = render(embedding, 90, 0.008, np.random.default_rng(1), noise=0, blur=0.8)
    measured = ((volume.grey - 12) / 88).sum() * 0.008**3
    vessel, cannula = np.pi * 0.05**2 * 0.5, np.pi * 0.043**2 * 0.05
    caps = 2 / 3 * np.pi * (0.043**3 + (0.05**2 - 0.043**2) ** 1.5)  # both tubes begin round, the vessel's end is flat
    assert measured == pytest.approx(vessel + cannula + caps, rel=0.01)


def test_a_phantom_becomes_the_network_it_was_made_from(fork, tmp_path):
    network, embedding, volume = fork
    stages = []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VasowaveWarning)
        found = extract(volume, Options(root=embedding.cannula[0]), stages.append)
    pairs = match(network, found.network)
    assert len(found.network) == 3
    assert len(pairs) == 3
    order = [pairs[row] for row in range(3)]
    # Targets for a coarse phantom: 4 % in the radius, 10 % in the length.
    np.testing.assert_allclose(found.measured.densitometric[order], network.radius, rtol=0.04)
    np.testing.assert_allclose(found.network.length[order], network.length, rtol=0.10)
    assert stages == ["image", "lumen", "axes", "radii", "uncertainty", "witness"]
    assert (found.measured.radius_sd > 0).all()
    write_network_table(found.measured, tmp_path / "network.csv")
    again = read_network(tmp_path / "network.csv")
    np.testing.assert_array_equal(again.radius, found.network.radius)


def test_a_dicom_series_reads_back_as_it_was_written(fork, tmp_path):
    volume = fork[2]
    write_dicom_series(volume, tmp_path)
    again = read_volume(tmp_path)
    np.testing.assert_allclose(again.grey, volume.grey, atol=0.026)  # half a step of 0.05
    np.testing.assert_allclose(again.spacing, volume.spacing, rtol=1e-7)
    np.testing.assert_allclose(again.origin, volume.origin, rtol=1e-6)
    (tmp_path / "slice0050.dcm").rename(tmp_path.parent / "lost.dcm")
    with pytest.raises(InputError, match=r"1 slices missing between slice0049.dcm and slice0051.dcm"):
        read_volume(tmp_path)
    cut = (tmp_path / "slice0010.dcm").read_bytes()[:5000]
    (tmp_path.parent / "lost.dcm").rename(tmp_path / "slice0050.dcm")
    (tmp_path / "slice0010.dcm").write_bytes(cut)
    with pytest.raises(InputError, match=r"slice0010.dcm"):
        read_volume(tmp_path)


def test_two_trees_and_a_tree_at_the_border_are_warned_about():
    grey = np.random.default_rng(0).normal(12, 1, size=(40, 40, 40))
    grey[5:35, 10:16, 10:16] = 100
    grey[5:30, 25:31, 25:31] = 100
    with pytest.warns(VasowaveWarning, match="two separate trees"):
        segment(Volume(grey, np.full(3, 0.01), np.zeros(3)))
    grey[:, 25:31, 25:31] = 12
    grey[0:35, 10:16, 10:16] = 100
    with pytest.warns(VasowaveWarning, match="touches the border"):
        segment(Volume(grey, np.full(3, 0.01), np.zeros(3)))
