"""What looks wrong with a network, or is not known of it."""

import numpy as np

from vasowave.base import units
from vasowave.base.cures import UNKNOWN, SetCells
from vasowave.base.findings import Finding, look_kind, note_kind
from vasowave.base.species import SPECIES
from vasowave.pulse.network.network import Network

_WIDER = 2.0  # times the parent's radius: a wider vessel is looked at
_UNIT = "Correct the unit in the header of the network."
SLENDER = look_kind(
    "network.odd-slenderness",
    "vessels are {ratio:.2g} radii long (median); arteries are 3 to 100: is the radius in the same unit as the length, "
    "and is it a radius, not a diameter?",
    _UNIT,
)
ROOT_SIZE = look_kind(
    "network.odd-root",
    "the root's radius is {radius:.3g} cm; a mouse's main pulmonary artery has 0.05 cm, a human aorta 1.5 cm: is the "
    "unit in the header right?",
    _UNIT,
)
WIDENS = look_kind(
    "network.widens",
    "vessel '{vessel}' is {ratio:.2g} times as wide as its parent ({radius:.3g} cm after {parent:.3g} cm): is a "
    "decimal point in the wrong place?",
    "Correct the radius in the network's file, or keep it if the vessel really is a bulge.",
)
LONG = look_kind(
    "network.long",
    "vessel '{vessel}' is {ratio:.2g} radii long ({length:.3g} cm), where vessels of this network are {usual:.2g} "
    "(median): is a decimal point in the wrong place?",
    "Correct the length in the network's file, or keep it if the vessel really has no branch for so long.",
)
_LONG_RADII, _LONG_SD, _MIN_SD = 30.0, 2.5, 0.35  # of ln(length/radius), robust; 2.0 SD is the most of ten real trees
NO_PRESSURE = look_kind(
    "network.pressure-unknown",
    "The pressure at which the vessels were imaged is not known; their radii are taken for those at zero pressure. If "
    "they were filled, the wall seems stiffer and waves faster than they are, and how it stiffens cannot be told. "
    "{remedy}",
    "Give it in the network's file, in a column 'pressure [mmHg]', or beside it.",
    SetCells("Give the pressure of the image", (("image pressure [mmHg]", UNKNOWN),)),
)

LEFT_OUT = note_kind("network.left-out", "{what} are no part of a network and were left out")
UNUSED = note_kind("network.unused", "{what}: given and not used, as no part of a network")
UNKNOWN_VARIABLE = note_kind("network.unknown-variable", "the variable '{name}' is not known and was left out")


def implausible_sizes(network: Network) -> list[Finding]:
    """Return every sign that lengths or radii are in another unit than cm, or one radius is a slip."""
    ratio, widest = float(np.median(network.length / network.radius)), float(network.radius[network.root])
    slender = [] if 1.5 <= ratio <= 150 else [SLENDER(ratio=ratio)]
    root = [] if 0.004 <= widest <= 2.0 else [ROOT_SIZE(radius=widest)]
    ratios = np.where(network.parent < 0, 1.0, network.radius / network.radius[network.parent])
    row = int(np.argmax(ratios))
    sizes = {"radius": float(network.radius[row]), "parent": float(network.radius[network.parent[row]])}
    wide = [WIDENS(ratio=float(ratios[row]), **sizes).at(vessel=network.name[row])] if ratios[row] > _WIDER else []
    return [*slender, *root, *wide]


def long_vessels(network: Network) -> list[Finding]:
    """Return the vessel that is longest beside its radius, if it stands out from the others."""
    radii = np.log(network.length / network.radius)
    usual = float(np.median(radii))
    sd = max(1.4826 * float(np.median(np.abs(radii - usual))), _MIN_SD)
    row = int(np.argmax(radii))
    if radii[row] < max(usual + _LONG_SD * sd, np.log(_LONG_RADII)):
        return []
    ratio, length = float(np.exp(radii[row])), float(network.length[row])
    return [LONG(ratio=ratio, length=length, usual=float(np.exp(usual))).at(vessel=network.name[row])]


def unlike_the_species(network: Network, species: str, unit: float | None = None) -> str:
    """Return what is wrong with the root's radius in an animal of this `species`, and which unit would be right.

    Parameters
    ----------
    network : Network
    species : str
        See `SPECIES`; any other word is not checked.
    unit : float, optional
        What a number of the file was taken for, cm; without it lengths come from a voxel size.

    Returns
    -------
    str
        Empty where nothing is wrong.
    """
    if species not in SPECIES:
        return ""
    radius, (low, high) = float(network.radius[network.root]), SPECIES[species].root_radius
    if low <= radius <= high:
        return ""
    remark = (
        f"the root's radius is {radius:.3g} cm and the vessels are {float(network.length.sum()):.4g} cm long in all, "
        f"but a {species}'s main pulmonary artery has a radius of {low:g} to {high:g} cm"
    )
    right = f"{low / radius * (unit or 1):.2g} to {high / radius * (unit or 1):.2g}"
    if unit is None:
        remark += f": the voxel size is wrong, probably by a factor of {right}"
    else:
        number = radius / unit
        fitting = [name for name in ("um", "mm", "cm") if low <= number * units.factor(name, "length") <= high]
        remark += (
            f": the unit is probably {fitting[0]}"
            if fitting
            else f": the numbers are probably voxels; give the size of one in cm as the unit ({right} would fit)"
        )
    alternatives = [
        name for name, candidate in SPECIES.items() if candidate.root_radius[0] <= radius <= candidate.root_radius[1]
    ]
    fits = f"; it would fit a {' or a '.join(alternatives)}" if alternatives else ""
    return f"{remark}. If the animal is another{fits}: say its species ({', '.join((*SPECIES, 'other'))})"


def unknown_pressure(network: Network) -> list[Finding]:
    """Return a finding if the pressure at which the radii were measured is not known."""
    return [] if network.pressure else [NO_PRESSURE()]
