"""Radii of vessels by the areas of their sections, where a file of centerlines holds these beside the balls' radii.

A ball touches the nearest wall only, so that in a vessel that is not round its radius is too small for the area that
blood flows through. Where a section is open, or lies in a junction, its area is that of no vessel.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from vasowave.base.findings import Finding, look_kind, note_kind
from vasowave.lung.exchange.legacy_vtk import PolyLines
from vasowave.lung.measure.measurement import Measurement, mean_along
from vasowave.lung.tree import Line

AREA, CLOSED, BRANCHING = "CenterlineSectionArea", "CenterlineSectionClosed", "CenterlineSectionBifurcation"
"""Arrays of VMTK and SimVascular: area, and whether the section is closed and lies in a junction (0 or 1)."""


@dataclass(frozen=True)
class SectionRules:
    """When sections are believed.

    Attributes
    ----------
    smallest, largest : float
        Radius of a section over that of the ball in it. No section is smaller than its ball, but for its corners; one
        that is larger by far cuts a neighbor too.
    contradicted : float
        Share of the sections that may be smaller than their balls; with more, the areas are in another unit.
    alike : float
        Two radii that differ by no more than this share are the same.
    """

    smallest: float = 0.95
    largest: float = 2.0
    contradicted: float = 0.2
    alike: float = 0.03


RULES = SectionRules()

TWO_RADII = look_kind(
    "lines.two-radii",
    "the file holds two radii: those by the areas of the sections, which are taken, are {ratio:.3g} times those of the "
    "inscribed balls (median of {vessels} vessels; {low:.3g} to {high:.3g}){left}",
    "Look at sections where both differ: a vessel that is not round has the larger one, and so has an oblique section.",
)
ONE_RADIUS = note_kind(
    "lines.section-areas",
    "radii are those by the areas of the sections, {ratio:.3g} times those of the inscribed balls (median of {vessels} "
    "vessels; {low:.3g} to {high:.3g}){left}",
)
AREAS_ALONE = look_kind(
    "lines.section-areas-alone",
    "the file has no radii of balls: {closed} of {points} radii are those by the areas of closed sections, the others "
    "those of the nearest such; places of junctions and ends follow from them",
    "Export the radii of the balls (MaximumInscribedSphereRadius) too.",
)
NO_SECTIONS = look_kind(
    "lines.section-areas-unused",
    "the areas of its sections are not used: {percent:.0f} % of them are smaller than the balls in them (their "
    "radius is {ratio:.3g} times that of the ball in the middle)",
    "Write areas in the square of the unit of length, of the same lines.",
)


class Sections(NamedTuple):
    """Places along centerlines with the radii of the sections there, cm.

    Attributes
    ----------
    points : float array, shape (place, 3)
        z, y, x.
    radius : float array, shape (place,)
        √(area/π).
    ball : float array, shape (place,)
        Radius of the inscribed ball.
    """

    points: np.ndarray
    radius: np.ndarray
    ball: np.ndarray


def sections_of(data: PolyLines, points: Line, unit: float) -> Sections | None:
    """Return the sections that are closed and lie in no junction; None if the file has none."""
    radius = unit * area_radii(data)
    valid = np.isfinite(radius)
    return Sections(points.points[valid], radius[valid], points.radius[valid]) if valid.any() else None


def area_radii(data: PolyLines) -> np.ndarray:
    """Return the radius of the section at every point, NaN where it is open, lies in a junction, or there is none."""
    area = data.fields.get(AREA)
    if area is None or area.ndim != 1:
        return np.full(len(data.points), np.nan)
    valid = np.isfinite(area) & (area > 0)
    valid &= np.asarray(data.fields.get(CLOSED, 1.0)).astype(bool)
    valid &= ~np.asarray(data.fields.get(BRANCHING, 0.0)).astype(bool)
    return np.sqrt(np.where(valid, area, np.nan) / np.pi)


def with_section_radii(measured: Measurement, sections: Sections) -> tuple[Measurement, Finding]:
    """Return `measured` with the radii of its vessels by `sections`, and how they compare with those of the balls.

    A vessel without a section on its free stretch keeps the radius of its balls.
    """
    share = sections.radius / sections.ball
    small = share < RULES.smallest
    if small.mean() > RULES.contradicted:
        return measured, NO_SECTIONS(percent=100 * float(small.mean()), ratio=float(np.median(share)))
    believed = ~small & (share <= RULES.largest)
    tree = measured.tree
    distance, place = cKDTree(sections.points[believed]).query(tree.line.points)
    radius = np.where(distance <= tree.line.radius, sections.radius[believed][place], np.nan)
    radii = np.split(radius, np.cumsum([len(line) for line in tree.lines])[:-1])
    by_area = mean_along(tree, radii)
    ball = measured.network.radius
    has_area = np.isfinite(by_area)
    ratio = by_area[has_area] / ball[has_area]
    if not has_area.any():
        return measured, NO_SECTIONS(percent=100 * float(small.mean()), ratio=float(np.median(share)))
    remark = (
        "" if has_area.all() else f"; {int((~has_area).sum())} without a section on their free stretch keep the ball's"
    )
    middle = float(np.median(ratio))
    kind = ONE_RADIUS if np.abs(ratio - 1).max() <= RULES.alike else TWO_RADII
    finding = kind(
        ratio=middle, vessels=int(has_area.sum()), low=float(ratio.min()), high=float(ratio.max()), left=remark
    )
    network = replace(measured.network, radius=np.where(has_area, by_area, ball))
    return replace(measured, network=network), finding
