"""Volumes unlike those of `phantom`: vessels that bend, taper, fade, touch and are not round.

Nothing here is shared with that phantom: axes are random curves of given tortuosity, sections are given by their
outline, and every kind of volume breaks one assumption of the extraction. A tree grows in voxels; SPACING makes it cm.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy import ndimage

from unlike_kinds import BACKGROUND, KINDS, SPACING, UNSEEN
from unlike_scans import artefacts, displaced, framed, lumen_of
from unlike_trees import grown, placed
from vasowave.lung.read import Volume

__all__ = ["KINDS", "SPACING", "UNSEEN", "Made", "make"]


@dataclass(frozen=True, eq=False)
class Made:
    """A volume and what is true of it; lengths in cm, places z, y, x.

    Attributes
    ----------
    ends : float array, shape (vessel, 3)
        Where each vessel ends.
    parent, length, radius : array, shape (vessel,)
        Radius of a circle of the section's mean area, averaged along the vessel.
    root : float array, shape (3,)
        Outer end of the cannula.
    """

    volume: Volume
    ends: np.ndarray
    parent: np.ndarray
    length: np.ndarray
    radius: np.ndarray
    root: np.ndarray

    @property
    def terminals(self):
        return np.setdiff1d(np.arange(len(self.parent)), self.parent)


def make(kind, seed):
    """Return the volume of `kind` with this seed."""
    rng = np.random.default_rng([seed, 77])
    for _ in range(200):
        tree = grown(kind, rng)
        if tree is not None:
            break
    else:
        raise RuntimeError(f"no tree of kind {kind} for seed {seed}")
    tree, shape = placed(tree, kind, rng)
    grey, background = lumen_of(tree, kind, shape, rng), np.zeros(shape, dtype=np.float32)
    grey = ndimage.gaussian_filter(displaced(grey, kind, rng), kind.psf)
    if kind.motion:
        grey = ndimage.gaussian_filter1d(grey, kind.motion, axis=1)
    background += BACKGROUND + artefacts(grey, kind, rng)
    white = rng.standard_t(kind.tails, shape) if kind.tails else rng.standard_normal(shape, dtype=np.float32)
    grain = ndimage.gaussian_filter(white.astype(np.float32), kind.grain)
    grey = background + kind.contrast * grey + np.float32(kind.noise) * grain / grain.std()
    if kind.frame:
        grey = framed(grey, tree, kind)
    return _made(grey, tree, kind)


def _made(grey, tree, kind):
    own = [vessel for vessel in tree[1:] if vessel.parent != -9]
    length = np.array([vessel.length for vessel in own])
    radius = np.array([_mean(vessel.radius, vessel.axis) for vessel in own])
    spacing = np.array([kind.slices, 1.0, 1.0]) * SPACING
    if kind.slices != 1:
        at = np.arange(0, grey.shape[0] - 1, kind.slices)
        low = np.floor(at).astype(int)
        share = (at - low)[:, None, None].astype(np.float32)
        grey = (1 - share) * grey[low] + share * grey[low + 1]
    ends = np.array([vessel.axis[-1] for vessel in own])
    if kind.view:
        inner = [vessel for row, vessel in enumerate(own) if any(other.parent == row for other in own)]
        least = max(vessel.axis[:, 0].max() + 2 * vessel.radius.max() for vessel in inner)
        last = int(max(grey.shape[0] * (1 - kind.view), least))
        grey = grey[:last]
        ends, length = _seen(own, last - 1, length)
    parent = np.array([vessel.parent for vessel in own])
    volume = Volume(grey, spacing, np.zeros(3))
    return Made(volume, ends * SPACING, parent, length * SPACING, radius * SPACING, tree[0].axis[0] * SPACING)


def _seen(vessels, last, length):
    """Return ends and lengths of vessels that the field of view cuts; inner vessels are never cut."""
    ends, length = [], length.copy()
    for row, vessel in enumerate(vessels):
        out = np.flatnonzero(vessel.axis[:, 0] > last)
        stop = out[0] if len(out) else len(vessel.axis)
        ends.append(vessel.axis[max(stop - 1, 1)])
        length[row] = replace(vessel, axis=vessel.axis[: max(stop, 2)]).length
    return np.array(ends), length


def _mean(values, axis):
    step = np.linalg.norm(np.diff(axis, axis=0), axis=1)
    return float((step * (values[1:] + values[:-1]) / 2).sum() / step.sum())
