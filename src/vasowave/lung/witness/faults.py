"""Doubts about faults that all vessels share: kernels and filters, a wrong center, walls, and what outshines the agent.

Repeated thresholds and the scatter of sections do not know of them, so the network carries a common error of all radii.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

from vasowave.base.findings import FindingKind
from vasowave.lung.lumen.levels import LAG
from vasowave.lung.lumen.segmentation import Segmentation
from vasowave.lung.measure.measurement import Measurement
from vasowave.lung.measure.radii import GUESSED_SHARE
from vasowave.lung.read.volume import Volume
from vasowave.lung.tree import Line
from vasowave.lung.witness.doubts import Doubt, Grade, doubt_kind


@dataclass(frozen=True)
class FaultRules:
    """When a fault is named; lengths in voxels.

    Attributes
    ----------
    min_radius, margin, max_vessels, core, lags, min_pairs
        Noise is that of the widest vessels' middle: so wide, within the lumen by the margin, from places so near to the
        axis, by voxels so far apart, and not known from fewer pairs.
    max_filtered : float
        Noise as smooth as edges has a ratio of its differences over the two lags; below this share of it, a filter has
        smoothed the noise and spared the edges.
    min_excess, noise_margin : float
        Brighter than the agent is what exceeds it by this share of the contrast and so many SD of the noise.
    smoothing : float
        Levels are smoothed before, SD.
    min_share, min_bright_share, min_voxels
        Of a vessel's voxels, from which on dark inclusions, or those that are too bright, matter: of a thin bright rim
        blur leaves the brightest alone.
    min_hidden : float
        Walls that may widen radii by so much are named; of thinner ones, a tenth of a radius, hardly any image is free.
    filter_sd, double_sd : float
        Common error of the radii with a filter and with doubled edges: what they moved radii of known vessels by.
    """

    min_radius: float = 5.0
    margin: float = 1.8
    max_vessels: int = 6
    core: int = 2
    lags: tuple[int, int] = (2, 4)
    min_pairs: int = 150
    max_filtered: float = 0.75
    min_excess: float = 0.12
    noise_margin: float = 3.0
    smoothing: float = 0.5
    min_share: float = 0.01
    min_bright_share: float = 0.005
    min_voxels: int = 20
    min_hidden: float = 0.025
    filter_sd: float = 0.08
    double_sd: float = 0.1


RULES = FaultRules()
_ALL = "all radii: "
WALLS = doubt_kind(
    "image.walls",
    Grade.UNCERTAIN,
    _ALL + "walls of {level:.0%} of the agent's contrast, {width:.0%} of the radius thick, stand beside the lumen; the "
    "radii are those of the lumen without them, which grey levels would sum up to be {percent:.1f} % wider",
)
HIDDEN_WALLS = doubt_kind(
    "image.hidden-walls",
    Grade.UNCERTAIN,
    _ALL
    + "walls too thin to be told from blur may stand beside the lumen: the radii are {narrower:.1f} % narrower for "
    "them, and off by {percent:.1f} % (1 SD): {remedy}",
    "scan finer, or compare a cannula or a vessel of known diameter",
)
SHARPENED = doubt_kind(
    "image.sharpened",
    Grade.UNCERTAIN,
    _ALL + "a kernel sharpened the image: a shadow of {depth:.0%} of the contrast stands beside the vessels; radii are "
    "those of the edges, and thin vessels are known less well; {remedy}",
    "reconstruct with a smooth kernel",
)
DOUBLED = doubt_kind(
    "image.doubled-edges",
    Grade.LOOK,
    _ALL
    + "the vessels' edges are double, with a step at {level:.0%} of the contrast, {voxels:.1f} voxels wide: a wrong "
    "center of rotation, a lung that moved, or walls that took up agent; {remedy}",
    "correct the center and reconstruct again",
)
FILTERED = doubt_kind(
    "image.filtered",
    Grade.LOOK,
    _ALL
    + "noise is smoother than the edges are: a median or another filter that spares edges was used, which eats thin "
    "vessels; {remedy}",
    "extract from the image as it was reconstructed",
)
BRIGHTER = doubt_kind(
    "image.brighter-than-agent",
    Grade.LOOK,
    "vessel(s) {vessels}: up to {share:.0%} of the voxels outshine the agent, as calcified walls, bone or metal do; "
    "the lumen and its radius there are wrong: {remedy}",
    "look, and give a mask without them",
)
INCLUSIONS = doubt_kind(
    "image.inclusions",
    Grade.UNCERTAIN,
    "vessel(s) {vessels}: dark places within, up to {share:.0%} of a vessel, as clots and bubbles are, count as lumen, "
    "and its radius is known to half of that share at best: {remedy}",
    "look whether they are, and give a mask if blood does not flow there",
)


class Fault(NamedTuple):
    """A systematic fault: what it lets one doubt, and the SD of the factor that all radii share for it."""

    doubt: Doubt
    common_sd: float = 0.0


def fault_doubts(measured: Measurement, volume: Volume, lumen: Segmentation) -> list[Fault]:
    """Return what systematic faults the image (cubes) shows."""
    grey, names = measured.grey, measured.network.name
    if grey is None:
        return []
    faults, spacing = list[Fault](), float(volume.spacing[0])
    brighter = _brighter(measured, volume, lumen)
    edge = grey.edge
    if edge is not None and edge.kind == "double" and brighter:  # no center of rotation makes what outshines the agent
        edge = None
    if edge is not None:
        numbers = {"level": edge.level, "depth": -edge.level, "width": edge.width, "voxels": edge.width}
        kind = {"wall": WALLS, "shadow": SHARPENED, "double": DOUBLED}[edge.kind]
        changed = float(np.nanmedian(np.abs(1 / grey.share - 1)))
        finding = kind(percent=100 * changed, **numbers)
        common_sd = RULES.double_sd if edge.kind == "double" else GUESSED_SHARE * changed
        faults.append(Fault(Doubt("radius", finding, names), common_sd))
    elif max(grey.hidden_wall, widens := 1 - float(np.median(grey.share))) > RULES.min_hidden:
        finding = HIDDEN_WALLS(percent=100 * grey.hidden_wall, narrower=100 * widens)
        faults.append(Fault(Doubt("radius", finding, names), grey.hidden_wall))
    same_blur = edge is None or edge.kind == "wall"
    ratio = noise_ratio(measured, volume, lumen) if same_blur else None
    if ratio is not None and ratio < RULES.max_filtered * _unfiltered(grey.blur / spacing):
        faults.append(Fault(Doubt("radius", FILTERED(), names), RULES.filter_sd))
    if edge is None or edge.kind != "shadow":
        faults += map(Fault, brighter)
    faults += map(Fault, inclusion_doubts(measured, lumen))
    return faults


def inclusion_doubts(measured: Measurement, lumen: Segmentation) -> list[Doubt]:
    """Return the doubt about vessels of which a part was dark and counts as lumen, if there are any."""
    owner = _owners(lumen.inclusions, measured, lumen)
    return _inhabited(INCLUSIONS, owner[owner >= 0], measured, lumen.spacing)


def inclusion_shares(measured: Measurement, lumen: Segmentation) -> np.ndarray:
    """Return what share of each vessel was dark and counts as lumen, shape (vessel,)."""
    owner = _owners(lumen.inclusions, measured, lumen)
    return np.minimum(_shares(owner[owner >= 0], measured, lumen.spacing), 1.0)


def faults_beside(faults: Sequence[Fault], cannula_agrees: bool) -> list[Fault]:
    """Return the faults that a bent grey scale, which is told, does not explain.

    It blurs the edges of wide vessels; where a cannula agrees with it, levels that outshine the agent are of it, too.
    """
    explained = {HIDDEN_WALLS.code, *([BRIGHTER.code] if cannula_agrees else [])}
    return [fault for fault in faults if fault.doubt.finding.code not in explained]


def noise_ratio(measured: Measurement, volume: Volume, lumen: Segmentation) -> float | None:
    """Return how much less voxels within the widest vessels differ over the short lag than over the long one.

    Differences are those from the mean of both neighbors, which a slope of the agent does not know. None without wide
    vessels or noise; vessels with inclusions, which were filled evenly, do not tell.
    """
    spacing, radius = float(volume.spacing[0]), measured.network.radius
    is_wide = (radius >= RULES.min_radius * spacing) & (inclusion_shares(measured, lumen) == 0)
    widest = [row for row in np.argsort(-radius).tolist() if is_wide[row]][: RULES.max_vessels]
    differences: list[list[np.ndarray]] = [[], []]
    for row in widest:
        for gathered, lag in zip(differences, RULES.lags, strict=True):
            gathered.append(_differences(measured.tree.lines[row], float(radius[row]), volume, lag))
    short, long = (np.concatenate(gathered) if gathered else np.empty(0) for gathered in differences)
    if min(len(short), len(long)) < RULES.min_pairs or not np.abs(long).max() > 0:
        return None
    return float((np.abs(short).mean() / np.abs(long).mean()) ** 2)  # a median knows steps of whole levels alone


def _differences(line: Line, radius: float, volume: Volume, lag: int) -> np.ndarray:
    """Return by how much voxels around an axis differ from the mean of the two `lag` voxels before and after them."""
    side = np.arange(-RULES.core, RULES.core + 1)
    ball = np.stack(np.meshgrid(side, side, side, indexing="ij"), axis=-1).reshape(-1, 3)
    clear = line.points[(line.run > 2 * radius) & (line.run < line.length - 2 * radius)]
    if len(clear) == 0:
        return np.empty(0)
    middles = np.round((clear - volume.origin) / volume.spacing).astype(int)
    voxels = np.unique((middles[:, None] + ball).reshape(-1, 3), axis=0)
    axis, reach, differences = cKDTree(line.points), radius - RULES.margin * float(volume.spacing[0]), []
    for step in lag * np.eye(3, dtype=int):
        around = np.stack([voxels, voxels - step, voxels + step])
        away = axis.query(around * volume.spacing + volume.origin)[0]
        inside = (away < reach).all(axis=0) & ((around >= 0) & (around < volume.grey.shape)).all(axis=(0, 2))
        middle, before, after = (volume.grey[tuple(places[inside].T)].astype(float) for places in around)
        differences.append(middle - (before + after) / 2)
    return np.concatenate(differences)


def _unfiltered(blur: float) -> float:
    """Return the ratio of `noise_ratio` for noise that is as smooth as edges blurred by `blur`, voxels."""
    short, long = (
        1.5 - 2 * np.exp(-(lag**2) / (4 * blur**2)) + 0.5 * np.exp(-((2 * lag) ** 2) / (4 * blur**2))
        for lag in RULES.lags
    )
    return float(short / long)


def _brighter(measured: Measurement, volume: Volume, lumen: Segmentation) -> list[Doubt]:
    """Return which vessels hold voxels that are brighter than the agent in them."""
    assert measured.grey is not None
    typical = float(np.nanmedian(measured.grey.contrast))
    if not typical > 0:
        return []
    box = tuple(slice(first, first + count) for first, count in zip(lumen.corner, lumen.mask.shape, strict=True))
    grey = ndimage.gaussian_filter(volume.grey[box].astype(np.float32), RULES.smoothing)  # a rim is thin, noise is not
    differences = np.abs(grey[..., LAG:] - grey[..., :-LAG])[~lumen.mask[..., LAG:] & ~lumen.mask[..., :-LAG]]
    noise = 1.05 * float(np.median(differences)) if len(differences) else 0.0  # SD of normal noise, by its differences
    margin = lumen.background + RULES.noise_margin * noise
    bright = np.argwhere(lumen.mask & (grey > margin + (1 + RULES.min_excess) * typical))
    contrast = np.fmax([np.median(_levels_at(line, grey, lumen)) for line in measured.tree.lines], typical)
    owner = _owners(bright, measured, lumen)
    above = grey[tuple(bright.T)] > margin + (1 + RULES.min_excess) * contrast[owner]
    return _inhabited(BRIGHTER, owner[(owner >= 0) & above], measured, lumen.spacing)


def _levels_at(line: Line, grey: np.ndarray, lumen: Segmentation) -> np.ndarray:
    """Return the levels of the crop above the background along an axis, which rims of a vessel leave as they are."""
    voxels = np.round((line.points - lumen.origin) / lumen.spacing).astype(int)
    return np.asarray(grey[tuple(np.clip(voxels, 0, np.array(grey.shape) - 1).T)] - lumen.background)


def _owners(voxels: np.ndarray, measured: Measurement, lumen: Segmentation) -> np.ndarray:
    """Return the row of the vessel that holds each of the `voxels` of the crop, -1 where they lie beside all."""
    line, spacing = measured.tree.line, lumen.spacing
    distance, nearest = cKDTree(line.points).query(voxels * spacing + lumen.origin)
    return np.where(distance < 2 * line.radius[nearest] + 2 * spacing, measured.tree.owner[nearest], -1)


def _inhabited(kind: FindingKind, owner: np.ndarray, measured: Measurement, spacing: float) -> list[Doubt]:
    """Return the doubt about the vessels of which the voxels with an `owner` are a share that matters."""
    network, lines = measured.network, measured.tree.lines
    count, share = np.bincount(owner, minlength=len(network)), _shares(owner, measured, spacing)
    min_share = RULES.min_bright_share if kind is BRIGHTER else RULES.min_share
    rows = np.flatnonzero((count >= RULES.min_voxels) & (share > min_share)).tolist()
    if not rows:
        return []
    names = tuple(network.name[row] for row in rows)
    finding = kind(vessels=", ".join(names), share=float(min(share[rows].max(), 1.0)))
    return [Doubt("radius", finding, names, np.array([lines[row].points[len(lines[row]) // 2] for row in rows]))]


def _shares(owner: np.ndarray, measured: Measurement, spacing: float) -> np.ndarray:
    """Return what share of each vessel voxels with an `owner` are."""
    network = measured.network
    return np.bincount(owner, minlength=len(network)) * spacing**3 / (np.pi * network.radius**2 * network.length)
