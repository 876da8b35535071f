"""What is told of an image as it is read."""

import numpy as np

from vasowave.base.cures import VOXEL
from vasowave.base.findings import look_kind

VOXEL_TYPED = look_kind(
    "image.voxel-typed",
    "its voxels measure {size} µm (x, y, z) by {source}, but {typed} µm were typed and are used. {remedy}",
    "Leave out the size, or make sure that the file is wrong.",
)
INVERTED = look_kind(
    "image.inverted",
    "its grey levels were inverted, for {source}; {remedy}",
    "if vessels are now dark, its header is wrong: export it with bright vessels.",
)
LEFT_OUT = look_kind(
    "image.left-out", "{count} files of the folder are no part of the image: {names}. {remedy}",
    "Make sure that none is a slice.",
)  # fmt: skip
STEP = look_kind(
    "image.slices-step",
    "its log says that slices lie {step} voxels apart, which is used, but their numbers do not ({first}, {second}). "
    "{remedy}",
    "Make sure that slices were numbered anew, or give the size of a voxel.",
    VOXEL,
)
CROPPED = look_kind(
    "image.slices-cropped",
    "there are slices {first} to {last}, but {source} says {wanted_first} to {wanted_last}. {remedy}",
    "Copy all slices, or crop on purpose.",
)
FLAT_SCALE = look_kind(
    "image.slices-scaled",
    "its slices say pixels of {size} µm (x, y) by {source}, but {used} µm are used. {remedy}",
    "Give the right size of a voxel.",
    VOXEL,
)


def in_micrometers(spacing: np.ndarray) -> str:
    """Return z, y, x (cm) as x, y, z in µm, for messages."""
    return " × ".join(f"{1e4 * length:.5g}" for length in spacing[::-1])
