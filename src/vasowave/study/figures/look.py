"""An image seen: its histogram and grey scale, and projections with outline, entrances or network."""

from typing import TYPE_CHECKING

import numpy as np

from vasowave.lung.lumen.segmentation import Segmentation
from vasowave.lung.overview import Overview
from vasowave.lung.read.volume import Volume, isotropic
from vasowave.lung.tree import Tree
from vasowave.study.figures.matplotlib_style import (
    CTL,
    DATA,
    FAINT,
    HPH,
    NARROW,
    WIDEST,
    label_axes,
    new_figure,
    style,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

AXES = "zyx"
OUTLINE = "#ffb000"
NETWORK = "#00c2e0"
_MOST_LABELS = 60  # more would cover each other
_HALO = 0.1  # margin around the lumen, as a share of its size
_NAMED = 4  # entrances that are numbered

Box = tuple[np.ndarray, np.ndarray]
"""Corners of a part of an image, voxels z, y, x; the upper one is not inside."""


def projection_figure(volume: Volume, lumen: Segmentation, tree: Tree, names: tuple[str, ...]) -> "Figure":
    """Return the projections along y, x and z on one scale; see `plot_projection`."""
    size = np.array(lumen.mask.shape) * lumen.spacing * (1 + 2 * _HALO)
    z, y, x = size
    with style():
        unit = (WIDEST - 2.5) / (x + y)
        figure = new_figure(WIDEST, unit * (z + y) + 3.2)
        panels = figure.subplots(2, 2, width_ratios=[x, y], height_ratios=[z, y])
        for ax, along in ((panels[0, 0], 1), (panels[0, 1], 2), (panels[1, 0], 0)):
            plot_projection(ax, volume, lumen, tree, names, along)
        _explain(panels[1, 1])
    return figure


def plot_projection(
    ax: "Axes", volume: Volume, lumen: Segmentation, tree: Tree, names: tuple[str, ...], along: int
) -> "Axes":
    """Draw the brightest voxel along one axis, the outline of the mask's shadow and the vessels with their names.

    Parameters
    ----------
    ax : Axes
    volume : Volume
    lumen : Segmentation
    tree : Tree
        In the coordinates of `volume`.
    names : tuple of str
        Of the vessels; written where there are at most 60.
    along : int
        Axis looked along: 0 for z, 1 for y, 2 for x.
    """
    right, up = _see_through(ax, volume, lumen, along, _box(volume, lumen))
    for line in tree.lines:
        ax.plot(line.points[:, right], line.points[:, up], color=NETWORK, linewidth=0.9)
        ax.plot(line.points[-1:, right], line.points[-1:, up], "o", color=NETWORK, markersize=2)
    ax.plot(*tree.lines[0].points[:1, [right, up]].T, "s", color=HPH, markersize=4)
    if len(names) <= _MOST_LABELS:
        _name(ax, tree, names, right, up)
    return ax


def _see_through(
    ax: "Axes", volume: Volume, lumen: Segmentation, along: int, box: Box, darkest: float | None = None
) -> tuple[int, int]:
    """Draw the brightest voxel along one axis and the outline of the lumen; return the axes to the right and upwards.

    Black is the `darkest` level, or that of one voxel in a hundred.
    """
    projection = volume.grey[tuple(map(slice, *box))].max(axis=along)
    up, right = (axis for axis in range(3) if axis != along)
    begin, end = (volume.origin + (corner - 0.5) * volume.spacing for corner in box)
    extent = (begin[right], end[right], begin[up], end[up])
    dark, bright = np.percentile(projection, [1, 99.7])
    dark = dark if darkest is None else darkest
    ax.imshow(projection, cmap="gray", origin="lower", extent=extent, vmin=dark, vmax=bright)
    places = [lumen.origin[axis] + np.arange(lumen.mask.shape[axis]) * lumen.spacing for axis in (right, up)]
    ax.contour(*places, lumen.mask.any(axis=along), levels=[0.5], colors=OUTLINE, linewidths=0.5)
    ax.set(xlim=extent[:2], ylim=extent[2:], title=f"along {AXES[along]}")
    label_axes(ax, f"{AXES[right]} [cm]", f"{AXES[up]} [cm]")
    return right, up


def _box(volume: Volume, lumen: Segmentation) -> Box:
    """Return the corners of the lumen with a margin, voxels of `volume`; the upper one is not inside."""
    margin = _HALO * np.array(lumen.mask.shape) * lumen.spacing
    end = lumen.origin + np.array(lumen.mask.shape) * lumen.spacing
    low = np.floor((lumen.origin - margin - volume.origin) / volume.spacing).astype(int)
    high = np.ceil((end + margin - volume.origin) / volume.spacing).astype(int)
    return np.maximum(low, 0), np.minimum(high, volume.grey.shape)


def _name(ax: "Axes", tree: Tree, names: tuple[str, ...], right: int, up: int) -> None:
    from matplotlib.patheffects import withStroke

    halo = [withStroke(linewidth=1.6, foreground="#000000")]
    for name, line in zip(names, tree.lines, strict=True):
        middle = line.points[len(line) // 2]
        ax.annotate(name, (middle[right], middle[up]), xytext=(2, 2), textcoords="offset points", fontsize=7,
                    color="#ffffff", path_effects=halo)  # fmt: skip


def _explain(ax: "Axes") -> None:
    from matplotlib.lines import Line2D

    ax.set_axis_off()
    entries = [
        Line2D([], [], color=OUTLINE, linewidth=1, label="outline of the lumen"),
        Line2D([], [], color=NETWORK, marker="o", markersize=3, label="vessels and where they end"),
        Line2D([], [], color=HPH, marker="s", linestyle="none", markersize=4, label="root"),
    ]
    ax.legend(handles=entries, loc="center left")


def histogram_figure(overview: Overview) -> "Figure":
    """Return how often each grey level occurs, with background, threshold and lumen."""
    with style():
        figure = new_figure(NARROW, 6.0)
        ax = figure.subplots()
        ax.stairs(np.maximum(overview.histogram.counts, 0.5), overview.histogram.edges, fill=True, color=FAINT)
        ax.set_yscale("log")
        ax.yaxis.set_major_formatter(lambda count, _: f"{count:,.0f}")
        marks = ((overview.levels.background, "background", DATA, ":"),
                 (overview.options.threshold, "threshold", HPH, "-"),
                 (overview.levels.lumen, "lumen", CTL, "--"))  # fmt: skip
        for level, name, color, dash in marks:
            ax.axvline(level, color=color, linestyle=dash, label=f"{name} {level:.4g}")
        figure.legend(loc="outside upper center", ncols=2)
        label_axes(ax, "grey level", "voxels")
    return figure


def grey_scale_figure(overview: Overview) -> "Figure | None":
    """Return measured against linear levels beside the two radii of each vessel; None where neither is known."""
    scale, measured = overview.grey.scale, overview.measured
    if measured is None:
        return None
    with style():
        figure = new_figure(WIDEST, 6.5)
        left_panel, right_panel = figure.subplots(1, 2)
        if scale is not None:
            left_panel.plot(scale.measured, scale.measured, color=FAINT, label="a linear scale")
            left_panel.plot(scale.measured, scale.linear, color=DATA, label="by the noise at each level")
            left_panel.legend(loc="upper left")
        label_axes(left_panel, "grey level", "linear grey level")
        radius = measured.inscribed
        right_panel.axhline(1, color=FAINT)
        right_panel.plot(10 * radius, measured.densitometric / radius, "o", color=CTL, markersize=4)
        label_axes(right_panel, "inscribed radius [mm]", "densitometric / inscribed")
    return figure


def projections_figure(overview: Overview, wide: bool = True) -> "Figure":
    """Return the brightest voxel along y, x and z with the outline of the lumen, the proposed entrances and loops."""
    volume = isotropic(overview.image)
    shape = np.array(volume.grey.shape) * volume.spacing
    z, y, x = shape / shape.max()
    with style():
        if wide:
            figure = new_figure(WIDEST, min(11.0, (WIDEST - 5) * max(z, y) / (2 * x + y)) + 2.5)
            axes = figure.subplots(1, 3, width_ratios=[x, y, x])
        else:
            figure = new_figure(NARROW, min(12.0, 6 * z / x) + min(12.0, 6 * z / y) + min(12.0, 6 * y / x) + 5)
            axes = figure.subplots(3, 1)
        for ax, along in zip(axes, (1, 2, 0), strict=True):
            _projection(ax, overview, volume, along)
    return figure


def _projection(ax: "Axes", overview: Overview, volume: Volume, along: int) -> None:
    box = np.zeros(3, dtype=int), np.array(volume.grey.shape)
    right, up = _see_through(ax, volume, overview.lumen, along, box, overview.levels.background)
    for number, entrance in enumerate(overview.entrances[:_NAMED], 1):
        place = overview.image.frame.own(entrance.place)
        ax.plot(place[right], place[up], "s", color=HPH, markersize=4)
        ax.annotate(f"{number}", (place[right], place[up]), xytext=(4, 3), textcoords="offset points", color="#ffffff",
                    fontsize=8)  # fmt: skip
    for loop in overview.loops:
        place = overview.image.frame.own(loop.place)
        ax.plot(place[right], place[up], "o", markeredgecolor=CTL, markerfacecolor="none", markersize=7)
