"""Whether an image can be of its species, by the size of its voxels, and whether a machine can work on it."""

import os
from dataclasses import dataclass

import numpy as np

from vasowave.base.cures import VOXEL, SetOption
from vasowave.base.errors import InputError
from vasowave.base.species import SPECIES
from vasowave.lung.read.findings import in_micrometers
from vasowave.lung.read.volume import Volume


@dataclass(frozen=True)
class ImageRules:
    """Outside of which the unit of an image's voxels is wrong.

    Attributes
    ----------
    max_edge, min_edge : float
        Longest edge of the image, in the widest and in the narrowest radius of the species' main pulmonary artery: for
        a mouse 12 and 0.06 cm, more than its body and less than a lobe.
    max_voxel : float
        Smallest edge of a voxel, in the widest such radius.
    bytes_per_cube : float
        Memory of an extraction beside the image (measured at 1000³ voxels: 5.1 GiB with an image of 8 bits).
    """

    max_edge: float = 150.0
    min_edge: float = 3.0
    max_voxel: float = 1.0
    bytes_per_cube: float = 4.5


RULES = ImageRules()


def require_plausible(volume: Volume, species: str) -> None:
    """Refuse an image that no animal of this species has, or that needs more memory than the machine has.

    Raises
    ------
    InputError
        With the size, what says it, and what to type; species beside `SPECIES` are not compared.
    """
    edges = np.array(volume.grey.shape) * volume.spacing
    _require_memory(volume, edges)
    if species not in SPECIES:
        return
    low, high = SPECIES[species].root_radius
    size, voxel = float(edges.max()), float(volume.spacing.min())
    if RULES.min_edge * low <= size <= RULES.max_edge * high and voxel <= RULES.max_voxel * high:
        return
    source = f" by {volume.provenance}" if volume.provenance else ""
    extent = " × ".join(f"{edge:.3g}" for edge in edges[::-1])
    raise InputError(
        f"the image measures {extent} cm (x, y, z), its voxels {in_micrometers(volume.spacing)} µm{source}: no "
        f"{species} is like that; the unit is probably wrong. Give the size of a voxel in cm, or the species "
        f"of the animal ({', '.join((*SPECIES, 'other'))})",
        [VOXEL, SetOption("Name the species", "species")],
    )


def _require_memory(volume: Volume, edges: np.ndarray) -> None:
    cubes = float(np.prod(edges / volume.spacing.min()))
    needed = cubes * RULES.bytes_per_cube + volume.grey.nbytes
    try:
        memory = float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, ValueError, OSError):
        return
    if needed > memory:
        raise InputError(
            f"the image has {cubes:.3g} voxels (as cubes), for which an extraction takes about {needed / 1e9:.0f} GB "
            f"of memory, and this machine has {memory / 1e9:.0f} GB; bin it to larger voxels, or cut out the lung"
        )
