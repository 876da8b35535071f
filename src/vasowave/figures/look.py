"""The first look at an image: its histogram, its grey scale, and the image seen through along its three axes."""

from typing import TYPE_CHECKING

import numpy as np

from vasowave.figures.projection import AXES, OUTLINE
from vasowave.figures.style import CTL, DATA, FAINT, HPH, NARROW, WIDEST, label_axes, new_figure, style
from vasowave.imaging.overview import Overview
from vasowave.imaging.read.volume import isotropic

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_NAMED = 4  # entrances that are numbered


def histogram_figure(seen: Overview) -> "Figure":
    """Return how often each grey level occurs, with background, threshold and lumen."""
    with style():
        figure = new_figure(NARROW, 6.0)
        ax = figure.subplots()
        ax.stairs(np.maximum(seen.histogram.counts, 0.5), seen.histogram.edges, fill=True, color=FAINT)
        ax.set_yscale("log")
        ax.yaxis.set_major_formatter(lambda count, _: f"{count:,.0f}")
        marks = ((seen.levels.background, "background", DATA, ":"), (seen.options.threshold, "threshold", HPH, "-"),
                 (seen.levels.lumen, "lumen", CTL, "--"))  # fmt: skip
        for level, name, color, dash in marks:
            ax.axvline(level, color=color, linestyle=dash, label=f"{name} {level:.4g}")
        figure.legend(loc="outside upper center", ncols=2)
        label_axes(ax, "grey level", "voxels")
    return figure


def grey_scale_figure(seen: Overview) -> "Figure | None":
    """Return measured against linear levels beside the two radii of each vessel; None where neither is known."""
    scale, measured = seen.grey.scale, seen.measured
    if measured is None:
        return None
    with style():
        figure = new_figure(WIDEST, 6.5)
        left, right = figure.subplots(1, 2)
        if scale is not None:
            left.plot(scale.measured, scale.measured, color=FAINT, label="a linear scale")
            left.plot(scale.measured, scale.linear, color=DATA, label="by the noise at each level")
            left.legend(loc="upper left")
        label_axes(left, "grey level", "linear grey level")
        radius = measured.inscribed
        right.axhline(1, color=FAINT)
        right.plot(10 * radius, measured.densitometric / radius, "o", color=CTL, markersize=4)
        label_axes(right, "inscribed radius [mm]", "densitometric / inscribed")
    return figure


def projections_figure(seen: Overview, wide: bool = True) -> "Figure":
    """Return the brightest voxel along y, x and z with the outline of the lumen, the proposed entrances and loops."""
    volume = isotropic(seen.image)
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
            _projection(ax, seen, volume, along)
    return figure


def _projection(ax: "Axes", seen: Overview, volume, along: int) -> None:  # type: ignore[no-untyped-def]
    picture = volume.grey.max(axis=along)
    up, right = (axis for axis in range(3) if axis != along)
    low = volume.origin - 0.5 * volume.spacing
    high = low + np.array(volume.grey.shape) * volume.spacing
    ax.imshow(picture, cmap="gray", origin="lower", extent=(low[right], high[right], low[up], high[up]),
              vmin=seen.levels.background, vmax=np.percentile(picture, 99.7))  # fmt: skip
    lumen = seen.lumen
    places = [lumen.origin[axis] + np.arange(lumen.mask.shape[axis]) * lumen.spacing for axis in (right, up)]
    ax.contour(*places, lumen.mask.any(axis=along), levels=[0.5], colors=OUTLINE, linewidths=0.5)
    for number, one in enumerate(seen.entrances[:_NAMED], 1):
        place = seen.image.frame.own(one.place)
        ax.plot(place[right], place[up], "s", color=HPH, markersize=4)
        ax.annotate(f"{number}", (place[right], place[up]), xytext=(4, 3), textcoords="offset points", color="#ffffff",
                    fontsize=8)  # fmt: skip
    for loop in seen.loops:
        place = seen.image.frame.own(loop.place)
        ax.plot(place[right], place[up], "o", markeredgecolor=CTL, markerfacecolor="none", markersize=7)
    ax.set_title(f"along {AXES[along]}")
    label_axes(ax, f"{AXES[right]} [cm]", f"{AXES[up]} [cm]")
