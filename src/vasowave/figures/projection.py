"""The image seen through: maximum-intensity projections with the mask's outline and the network, labelled."""

from typing import TYPE_CHECKING

import numpy as np

from vasowave.figures.style import HPH, WIDEST, label_axes, new_figure, style
from vasowave.imaging.lumen.segmentation import Segmentation
from vasowave.imaging.read.volume import Volume
from vasowave.imaging.tree import Tree

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

AXES = "zyx"
OUTLINE = "#ffb000"
NETWORK = "#00c2e0"
_MOST_LABELS = 60  # more would cover each other
_HALO = 0.1  # margin around the lumen, as a share of its size


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
    low, high = _box(volume, lumen)
    seen = volume.grey[tuple(slice(a, b) for a, b in zip(low, high, strict=True))].max(axis=along)
    up, right = (axis for axis in range(3) if axis != along)
    begin = volume.origin + (low - 0.5) * volume.spacing
    end = volume.origin + (high - 0.5) * volume.spacing
    extent = (begin[right], end[right], begin[up], end[up])
    limits = np.percentile(seen, [1, 99.7])
    ax.imshow(seen, cmap="gray", origin="lower", extent=extent, vmin=limits[0], vmax=limits[1])
    shadow = lumen.mask.any(axis=along)
    places = [lumen.origin[axis] + np.arange(lumen.mask.shape[axis]) * lumen.spacing for axis in (right, up)]
    ax.contour(*places, shadow, levels=[0.5], colors=OUTLINE, linewidths=0.5)
    for line in tree.lines:
        ax.plot(line.points[:, right], line.points[:, up], color=NETWORK, linewidth=0.9)
        ax.plot(line.points[-1:, right], line.points[-1:, up], "o", color=NETWORK, markersize=2)
    ax.plot(*tree.lines[0].points[:1, [right, up]].T, "s", color=HPH, markersize=4)
    if len(names) <= _MOST_LABELS:
        _name(ax, tree, names, right, up)
    ax.set(xlim=extent[:2], ylim=extent[2:], title=f"along {AXES[along]}")
    return label_axes(ax, f"{AXES[right]} [cm]", f"{AXES[up]} [cm]")


def _box(volume: Volume, lumen: Segmentation) -> tuple[np.ndarray, np.ndarray]:
    """Return the corners of the lumen with a margin, voxels of `volume`; the upper one is not inside."""
    margin = _HALO * np.array(lumen.mask.shape) * lumen.spacing
    far = lumen.origin + np.array(lumen.mask.shape) * lumen.spacing
    low = np.floor((lumen.origin - margin - volume.origin) / volume.spacing).astype(int)
    high = np.ceil((far + margin - volume.origin) / volume.spacing).astype(int)
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
