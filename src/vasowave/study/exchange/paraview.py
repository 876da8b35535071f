"""A cycle of waves as a series that ParaView plays: one PolyData file a frame, and the file of their times.

Tubes that widen and narrow as the vessels do, with pressure, flow, area and velocity at every point, about axes that
were measured or are drawn as a flat tree of their true lengths.
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.io.columns import read_columns
from vasowave.base.io.files import make_folder, write_file
from vasowave.lung.exchange.polydata import data_array
from vasowave.lung.tree import distance_along
from vasowave.pulse.analysis.shear import wall_shear
from vasowave.pulse.network.network import Network
from vasowave.study.exchange.solved import Solved
from vasowave.study.figures.network import layout

FILE, FRAMES = "waves.pvd", "frames"
_COUNT = 64  # frames of a cycle
_MOST_PLACES = 40  # rings of a vessel that its axis alone asks for
_HEAD = (
    '<?xml version="1.0"?>\n<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64" '
    'compressor="vtkZLibDataCompressor"><PolyData>\n'
)

SIDES = 16
"""Points of a ring."""

_BESIDE = 1.0  # distance between inlets, in lengths of their vessels
_LEAST_BOW, _BOW_POINTS = 0.15, 13  # height over its chord, so that parallel vessels lie apart
_APART = np.radians(75.0)  # between the outermost daughters of a vessel


def drawn_axes(network: Network) -> list[np.ndarray]:
    """Return a straight axis for each vessel, shape (2, 3), x, y, z in cm: true lengths, ordered as in the figure.

    Daughters leave their parent as arteries do: a wide one goes on nearly straight, a thin one turns away. A vessel
    that closes a loop is a bow to where it ends; it is drawn longer than it is where that is too far away.
    """
    angle = _angles(network)
    direction = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(len(network))])
    axes: list[np.ndarray] = [np.empty((0, 3))] * len(network)
    places: dict[int, np.ndarray] = {}
    for number, row in enumerate(network.inlets):
        places[int(network.start[row])] = np.array([0.0, -_BESIDE * number * network.length[row], 0.0])
    for rows in network.generations:
        for row in rows:
            start, node = places[int(network.start[row])], int(network.end[row])
            if node in places:
                axes[row] = _bow(start, places[node], float(network.length[row]))
                continue
            places[node] = start + network.length[row] * direction[row]
            axes[row] = np.stack([start, places[node]])
    return axes


def _bow(start: np.ndarray, end: np.ndarray, length: float) -> np.ndarray:
    """Return an arc of a parabola between two points, as long as a vessel that is longer than their distance."""
    chord = end - start
    distance = max(float(np.linalg.norm(chord)), 1e-9 * length)
    height = max(np.sqrt(3.0 / 8.0 * max(length / distance - 1.0, 0.0)), _LEAST_BOW) * distance
    share = np.linspace(0.0, 1.0, _BOW_POINTS)[:, np.newaxis]
    side = np.array([-chord[1], chord[0], 0.0]) / distance
    return np.asarray(start + share * chord - 4.0 * height * share * (1.0 - share) * side)


def _angles(network: Network) -> np.ndarray:
    """Return the direction of each vessel, rad from that of the root, shape (vessel,)."""
    place, angle = layout(network)[1], np.zeros(len(network))
    for row in np.concatenate(network.generations):
        daughters = np.array(sorted(network.daughters[row], key=place.__getitem__), dtype=int)
        fan = np.linspace(-0.5, 0.5, len(daughters)) if len(daughters) > 1 else np.zeros(len(daughters))
        if len(daughters):
            straight = np.average(fan, weights=network.area[daughters])
            angle[daughters] = angle[row] + _APART * (fan - straight)
    return angle


def read_axes(path: str | Path, network: Network) -> list[np.ndarray]:
    """Return the axes in the table of points that `vasowave extract` writes (``centerlines.csv``), x, y, z in cm.

    Raises
    ------
    InputError
        No such table, or a vessel of the network without two points in it.
    """
    table = read_columns(path)
    owner = np.array([row[table.require("vessel")] for row in table.cells])
    points = np.column_stack([table.numbers(table.require(axis), "length") for axis in "xyz"])
    axes = [points[owner == name] for name in network.name]
    short = next((name for name, axis in zip(network.name, axes) if len(axis) < 2), None)
    if short is not None:
        raise InputError(f"{path}: no axis of vessel '{short}'; are these the centerlines of this network?")
    return axes


class _Tube(NamedTuple):
    """One vessel: its axis, the directions to its rings, and its waves there."""

    points: np.ndarray  # (place, 3) cm
    around: np.ndarray  # (place, side, 3)
    waves: dict[str, np.ndarray]  # each (time, place)


def write_paraview(solved: Solved, folder: Path, axes: list[np.ndarray]) -> list[str]:
    """Write ``waves.pvd`` and its frames into `folder` and return what their reader should know.

    Parameters
    ----------
    solved : Solved
    folder : Path
    axes : list of float array, shape (point, 3)
        Of each vessel, x, y, z in cm.
    """
    tubes = [_tube(solved, row, axis) for row, axis in enumerate(axes)]
    first = np.cumsum([0, *(SIDES * len(tube.points) for tube in tubes)])
    faces = np.concatenate([quadrilaterals(len(tube.points), start) for tube, start in zip(tubes, first, strict=False)])
    owner = np.concatenate([np.full(SIDES * len(tube.points), row) for row, tube in enumerate(tubes)])
    samples = len(tubes[0].waves["area_cm2"])
    make_folder(folder / FRAMES)
    listed = []
    for frame in range(_COUNT):
        sample, name = frame * samples // _COUNT, f"{FRAMES}/{frame:03d}.vtp"
        time = sample * solved.inflow.period / samples
        write_file(folder / name, _frame(tubes, faces, owner, sample, time))
        listed.append(f'<DataSet timestep="{time!r}" part="0" file="{name}"/>')
    write_file(folder / FILE,
        '<?xml version="1.0"?>\n<VTKFile type="Collection" version="1.0" byte_order="LittleEndian"><Collection>\n'
        + "\n".join(listed) + "\n</Collection></VTKFile>\n")  # fmt: skip
    return [f"Open {FILE} in ParaView and press play: {_COUNT} frames of one cycle, coordinates in cm, time in s. The "
            "array 'vessel' is the row of the vessel in its table, from 0."]  # fmt: skip


def _tube(solved: Solved, row: int, axis: np.ndarray) -> _Tube:
    along, length = solved.along(row), solved.network.length[row]
    shares = np.linspace(0.0, 1.0, max(len(along.position), min(len(axis), _MOST_PLACES)))
    waves = {"pressure_mmHg": along.pressure, "flow_ml_per_s": along.flow, "area_cm2": along.area}
    waves = {name: _at(shares * length, along.position, values) for name, values in waves.items()}
    waves["velocity_cm_per_s"] = waves["flow_ml_per_s"] / waves["area_cm2"]
    period, blood = solved.inflow.period, solved.model.blood
    waves["wall_shear_Pa"] = wall_shear(waves["flow_ml_per_s"], waves["area_cm2"], period, blood)
    points = points_at(axis, shares)
    return _Tube(points, ring_directions(points), waves)


def _at(places: np.ndarray, position: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return values, shape (time, position), at other places of the vessel, by straight lines."""
    right = np.clip(np.searchsorted(position, places), 1, len(position) - 1)
    share = (places - position[right - 1]) / (position[right] - position[right - 1])
    return values[:, right - 1] * (1.0 - share) + values[:, right] * share


def _frame(tubes: list[_Tube], faces: np.ndarray, owner: np.ndarray, sample: int, time: float) -> str:
    radius = [np.sqrt(tube.waves["area_cm2"][sample] / np.pi) for tube in tubes]
    rings = [tube.points[:, None] + r[:, None, None] * tube.around for tube, r in zip(tubes, radius, strict=True)]
    points = np.concatenate([ring.reshape(-1, 3) for ring in rings])
    fields = {name: np.concatenate([np.repeat(tube.waves[name][sample], SIDES) for tube in tubes])
              for name in tubes[0].waves}  # fmt: skip
    arrays = "\n".join(data_array(name, values, "Float32") for name, values in fields.items())
    ends = 4 * np.arange(1, len(faces) + 1)
    return (
        f'{_HEAD}<FieldData><DataArray type="Float64" Name="TimeValue" NumberOfTuples="1" format="ascii">{time!r}'
        "</DataArray></FieldData>\n"
        f'<Piece NumberOfPoints="{len(points)}" NumberOfVerts="0" NumberOfLines="0" NumberOfStrips="0" '
        f'NumberOfPolys="{len(faces)}">\n<PointData Scalars="pressure_mmHg">{arrays}\n'
        f"{data_array('vessel', owner, 'Int32')}</PointData>\n<Points>"
        f"{data_array('Points', points, 'Float32')}</Points>\n"
        f"<Polys>{data_array('connectivity', faces.ravel(), 'Int32')}\n{data_array('offsets', ends, 'Int32')}</Polys>\n"
        "</Piece></PolyData></VTKFile>\n"
    )


def points_at(axis: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Return the points at these shares (0 to 1) of the length of `axis`, shape (place, 3)."""
    run = distance_along(axis)
    return np.column_stack([np.interp(share * run[-1], run, axis[:, i]) for i in range(3)])


def ring_directions(points: np.ndarray) -> np.ndarray:
    """Return unit vectors from an axis to the points of its rings, shape (place, side, 3).

    The rings stand across the axis and do not twist: each frame is the one before, turned into its own plane.
    """
    tangent = np.gradient(points, axis=0)
    tangent /= np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-300)
    across = np.zeros_like(points)
    normal = np.eye(3)[int(np.argmin(np.abs(tangent[0])))]
    for place, along in enumerate(tangent):
        normal = normal - np.dot(normal, along) * along
        normal = normal / np.linalg.norm(normal)
        across[place] = normal
    binormal = np.cross(tangent, across)
    turn = 2 * np.pi * np.arange(SIDES) / SIDES
    return np.cos(turn)[None, :, None] * across[:, None] + np.sin(turn)[None, :, None] * binormal[:, None]


def quadrilaterals(places: int, first: int) -> np.ndarray:
    """Return the corners of the faces between `places` rings, whose points are numbered from `first`; (face, 4)."""
    ring, side = np.meshgrid(np.arange(places - 1), np.arange(SIDES), indexing="ij")
    ring_start, next_start = ring * SIDES, (ring + 1) * SIDES
    after = (side + 1) % SIDES
    corners = np.stack([ring_start + side, ring_start + after, next_start + after, next_start + side], axis=-1)
    return first + corners.reshape(-1, 4)
