"""What a user can ask of an extraction: the one definition from which the command line is made too."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from annotated_types import Ge, Le, Lt
from pydantic import BeforeValidator, SkipValidation

from vasowave.base.errors import InputError
from vasowave.base.settings import settings_class
from vasowave.base.species import SpeciesName
from vasowave.lung.places import Place, Places, Region, VoxelSize
from vasowave.pulse.network.network import HIGHEST


def parse_grey(text: str) -> tuple[tuple[float, float], ...]:
    """Return the pairs in ``"measured:linear,measured:linear"``.

    Raises
    ------
    InputError
        Not at least two pairs of numbers, both ascending.
    """
    try:
        pairs = tuple(
            (float(measured), float(linear)) for measured, linear in (pair.split(":") for pair in text.split(","))
        )
    except ValueError:
        pairs = ()
    if len(pairs) < 2 or not (np.isfinite(pairs).all() and (np.diff(pairs, axis=0) > 0).all()):
        raise InputError(f"grey '{text}': write at least two ascending pairs measured:linear, as 0:0,120:80,255:255")
    return pairs


def grey_text(pairs: Sequence[tuple[float, float]]) -> str:
    """Return what `parse_grey` reads."""
    rounded = ((float(f"{level:.4g}"), float(f"{linear_level:.4g}")) for level, linear_level in pairs)
    return ",".join(f"{measured:g}:{linear:g}" for measured, linear in rounded)


def _grey(value: Any) -> Any:
    return parse_grey(value if isinstance(value, str) else grey_text(value))


GreyPairs = Annotated[tuple[tuple[float, float], ...], SkipValidation, BeforeValidator(_grey)]


@settings_class
class Options:
    """What the user decides; places are z, y, x in cm, in the world as a viewer shows the image."""

    root: Place | None = None
    """Where the blood enters, the outer end of the cannula: x,y,z as a viewer shows it, cm (or with a unit:
    '9.1 12 4.5 mm'). An edit `root` overrules it, label 2 of the mask stands in."""
    outlets: Places | None = None
    """Guided mode, the network reaches these and no other: an outlet x,y,z, repeated, or a CSV with x [cm], y [cm],
    z [cm]. Labels from 3 on of the mask stand in for them."""
    threshold: float = 45.0
    """Grey level of the vessel wall; radii are repeated at ±20 % of it for their uncertainty."""
    seed: Place | None = None
    """A point inside the vessels, where the root is not inside them."""
    method: Literal["threshold", "level-set"] = "threshold"
    """threshold (region growing), or level-set (active contour)."""
    mask: Path | None = None
    """The lumen as edited by hand; labels: 1 lumen, 2 root, 3… outlets."""
    edits: Path | None = None
    """Corrections: remove, cut, merge, root, one a line; else `edits.txt` in the folder of the results."""
    grey: GreyPairs | None = None
    """Pairs measured:linear of grey levels, ascending, 0:0,120:80,255:255: they correct a scale that is bent, and the
    threshold then counts on the corrected one."""
    region: Region | None = None
    """Mask file, or box x,y,z:x,y,z; outside is no lumen."""
    voxel: VoxelSize | None = None
    """Voxel size, cm, in place of the file's: one number, or x,y,z."""
    cannula: Annotated[float, Ge(0), Lt(2)] = 0.086
    """Known inner diameter of the cannula, cm (PE-90: 0.086); 0 where there is none."""
    species: SpeciesName = "mouse"
    """Whose size, and main pulmonary artery where there is no cannula, voxels are checked by; other: unchecked."""
    pressure: Annotated[float, Ge(0), Le(HIGHEST)] = 0.0
    """Transmural pressure at which the vessels were filled for the image, mmHg; 0 where it is not known."""
    scale: Literal["file", "cannula"] = "file"
    """Whether lengths follow the file's voxel size or the cannula's known diameter."""
    loops: Literal["open", "refuse"] = "refuse"
    """Refuse a lumen that closes loops, or open them with a warning; both say where."""
    junction: Literal["axes", "tube", "vmtk"] = "axes"
    """Where a junction is said to be, for lengths alone: where the axes meet, or, for comparison with other programs,
    where daughters leave each other's tubes of half the radius (tube) or of the whole (VMTK's split point)."""
    generations: int | None = None
    """Keep the first so many generations."""
    vessels: int | None = None
    """Keep the largest so many vessels."""
    min_radius: float | None = None
    """Keep the vessels above this radius, cm."""

    def __post_init__(self) -> None:
        """Refuse what contradicts itself before any file is read."""
        check_wishes(self.generations, self.vessels, self.min_radius)
        if self.scale == "cannula" and not self.cannula:
            raise InputError("scale 'cannula' needs a cannula of known diameter")
        if self.mask is not None and self.method != "threshold":
            raise InputError("a mask is the lumen; the method 'level-set' would find another: leave one out")


def check_wishes(*wishes: float | None) -> None:
    """Raise `InputError` if more than one part of the tree is wanted."""
    if sum(wish is not None for wish in wishes) > 1:
        raise InputError("keep either the first generations, or so many vessels, or all above a radius")
