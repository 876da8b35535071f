"""The artery that a recording is of: words of titles that speak of it, and what is plausible there."""

from dataclasses import dataclass, replace
from typing import Literal

from vasowave.base.species import SPECIES, Range, Species

SiteName = Literal["pulmonary artery", "aorta", "carotid", "brachial", "radial", "femoral", "renal", "mesenteric"]
"""Arteries by name."""

PULMONARY: SiteName = "pulmonary artery"


@dataclass(frozen=True)
class Artery:
    """An artery of the systemic circulation, against the pulmonary artery of the same animal.

    Attributes
    ----------
    words, stems : tuple of str
        Of titles that speak of it, and beginnings of such words.
    flow, radius : (float, float)
        By what the ranges of the output and of the pulmonary artery's radius are multiplied.
    """

    words: tuple[str, ...]
    stems: tuple[str, ...]
    flow: Range
    radius: Range


SYSTEMIC_PRESSURES: tuple[Range, Range] = (45.0, 180.0), (8.0, 140.0)
"""Mean and pulse pressure, mmHg, of the systemic arteries of mammals, from shock to severe hypertension: resting means
lie near 100 mmHg from mouse to horse (Schmidt-Nielsen 1984, Scaling)."""

SITES = {
    "aorta": Artery(("ao", "aop", "aorta", "aortic", "abp"), ("aort",), (0.3, 1.1), (0.3, 1.5)),
    "carotid": Artery(("carotid", "cca", "ica"), ("carot", "karot"), (0.01, 0.25), (0.05, 0.6)),
    "brachial": Artery(("brachial",), ("brachi",), (0.002, 0.1), (0.05, 0.5)),
    "radial": Artery(("radial",), ("radial",), (0.0005, 0.05), (0.02, 0.3)),
    "femoral": Artery(("femoral",), ("femor",), (0.005, 0.2), (0.05, 0.6)),
    "renal": Artery(("renal", "kidney"), ("renal",), (0.02, 0.3), (0.05, 0.6)),
    "mesenteric": Artery(("mesenteric", "sma"), ("mesent",), (0.01, 0.3), (0.05, 0.6)),
}
"""Systemic arteries; the shares of flow are wide and catch units, not disease."""


def ranges_at(species: str, site: str) -> Species:
    """Return what is plausible at an artery of a species, as `SPECIES` has it of the main pulmonary artery."""
    ranges = SPECIES[species]
    if site not in SITES:
        return ranges
    mean, pulse = SYSTEMIC_PRESSURES
    flow, radius = SITES[site].flow, SITES[site].radius
    return replace(
        ranges, mPAP=mean, pPAP=pulse, CO=_scaled(ranges.CO, flow), root_radius=_scaled(ranges.root_radius, radius),
        source=f"{ranges.source}; pressures of systemic arteries",
    )  # fmt: skip


def _scaled(limits: Range, shares: Range) -> Range:
    return limits[0] * shares[0], limits[1] * shares[1]
