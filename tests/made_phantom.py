"""A small phantom of five vessels on disk."""

import numpy as np

from phantom import embed, render, write_dicom_series
from vasowave.lung import write_volume, written
from vasowave.pulse.network import Network

NETWORK = Network(
    ("1", "2", "3", "4", "5"),
    np.array([-1, 0, 0, 1, 1]),
    np.array([0.35, 0.4, 0.3, 0.25, 0.3]),
    np.array([0.052, 0.042, 0.032, 0.034, 0.026]),
)
VOXEL = 0.0095


def phantom(seed=5, shape=140, spacing=VOXEL, noise=6.0):
    """Return the embedding of NETWORK and its volume."""
    rng = np.random.default_rng(seed)
    embedding = embed(NETWORK, rng)
    return embedding, render(embedding, shape, spacing, rng, noise=noise)


def root_of(embedding):
    return written(embedding.cannula[0])


def outlets_of(embedding):
    return [argument for row in NETWORK.terminals for argument in ("--outlet", written(embedding.lines[row][-1]))]


def written_scan(folder):
    """Write the phantom as a DICOM series and as one file; return the folder, its embedding and its volume."""
    embedding, volume = phantom()
    write_dicom_series(volume, folder / "dicom")
    write_volume(volume, folder / "image.nrrd")
    return folder, embedding, volume
