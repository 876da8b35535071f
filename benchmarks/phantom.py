"""A phantom: a given network as curved tubes in space, and the micro-CT volume one would get of it."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.ndimage import gaussian_filter
from scipy.spatial import cKDTree

from vasowave.base import InputError, NumericalError
from vasowave.lung.read import Volume
from vasowave.pulse.network import Network

PE90_RADIUS = 0.043
"""Inner radius of the PE-90 cannula, cm."""


@dataclass(frozen=True, eq=False)
class Embedding:
    """A network in space.

    Attributes
    ----------
    network : Network
    lines : tuple of float array, shape (point, 3)
        Axis of each vessel from its junction to its end, z, y, x, cm; its length is the vessel's.
    cannula : float array, shape (2, 3)
        Outer end and tip of the cannula's axis, cm.
    """

    network: Network
    lines: tuple[np.ndarray, ...]
    cannula: np.ndarray


def embed(network: Network, rng: np.random.Generator, step: float = 0.004, cannula: float = 0.2) -> Embedding:
    """Place `network` in space as curved vessels that touch only at junctions; lengths are exact.

    Parameters
    ----------
    network : Network
    rng : numpy.random.Generator
    step : float
        Largest distance of neighboring points, cm.
    cannula : float
        Length of the cannula, cm.

    Raises
    ------
    NumericalError
        If no placement without contact was found.
    """
    for _ in range(60):
        lines = _try_embedding(network, rng, step, cannula)
        if lines is not None:
            start = np.array([-cannula, 0.0, 0.0])
            return Embedding(network, lines, np.stack([start, np.zeros(3)]))
    raise NumericalError(f"no placement of the {len(network)} vessels without contact; try another seed")


def _try_embedding(
    network: Network, rng: np.random.Generator, step: float, cannula: float
) -> tuple[np.ndarray, ...] | None:
    lines: dict[int, np.ndarray] = {}
    ends: dict[int, tuple[np.ndarray, np.ndarray]] = {-1: (np.zeros(3), np.array([1.0, 0.0, 0.0]))}
    for row in np.concatenate(network.generations):
        parent = int(network.parent[row])
        point, direction = ends[parent]
        for _ in range(60):
            start = direction if parent < 0 else _branch_direction(network, row, lines, direction, rng)
            line, end = _curve(point, start, network.length[row], step, rng)
            if _is_free(network, row, line, lines, cannula):
                break
        else:
            return None
        lines[row], ends[row] = line, (line[-1], end)
    return tuple(lines[row] for row in range(len(network)))


def _branch_direction(
    network: Network, row: int, lines: dict[int, np.ndarray], parent: np.ndarray, rng: np.random.Generator
) -> np.ndarray:
    """Return a direction 20-75 degrees off the parent's, opposite to the sisters'; thin vessels turn more."""
    sisters = [d for d in network.daughters[network.parent[row]] if d in lines]
    aside = rng.normal(size=3)
    for sister in sisters:
        aside = -(lines[sister][1] - lines[sister][0]) / np.linalg.norm(lines[sister][1] - lines[sister][0])
        aside = aside + 0.25 * rng.normal(size=3)
    aside = aside - parent * (aside @ parent)
    aside /= np.linalg.norm(aside)
    thinness = 1 - network.radius[row] / network.radius[network.parent[row]]
    angle = np.radians(np.clip(rng.normal(25 + 55 * thinness, 6), 20, 75))
    return np.cos(angle) * parent + np.sin(angle) * aside


def _curve(
    start: np.ndarray, direction: np.ndarray, length: float, step: float, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Return a smooth curve of exactly `length`, and its direction at the end."""
    count = max(8, int(np.ceil(length / step)))
    bend = np.cross(direction, rng.normal(size=3))
    turn = bend / np.linalg.norm(bend) * min(1.5 * length, 0.6) * rng.uniform(0.3, 1.0) / count
    points, tangent = [start], direction
    for _ in range(count):
        points.append(points[-1] + tangent * length / count)
        tangent = tangent + np.cross(turn, tangent)
        tangent = tangent / np.linalg.norm(tangent)
    return np.array(points), tangent


def _is_free(network: Network, row: int, line: np.ndarray, lines: dict[int, np.ndarray], cannula: float) -> bool:
    """Whether `line` keeps clear of all vessels but its parent and, near the junction, its sisters."""
    radius = network.radius
    others = [(np.linspace([-cannula, 0, 0], [0, 0, 0], 50), radius[network.root])] if network.parent[row] >= 0 else []
    for other, placed in lines.items():
        if other != network.parent[row] and network.parent[other] != network.parent[row]:
            others.append((placed, radius[other]))
    for placed, other_radius in others:
        if cKDTree(placed).query(line)[0].min() < radius[row] + other_radius + 0.01:
            return False
    junction = line[0]
    for other in lines:
        is_parent = other == network.parent[row]
        if not (is_parent or network.parent[other] == network.parent[row]):
            continue
        away = np.linalg.norm(line - junction, axis=1) > 3.0 * (radius[row] + radius[other])
        close = cKDTree(lines[other]).query(line[away])[0] < radius[row] + radius[other] + 0.01
        if close.any():
            return False
    return True


def render(
    embedding: Embedding,
    shape: int,
    spacing: float,
    rng: np.random.Generator,
    *,
    noise: float = 6.0,
    blur: float = 0.8,
    inhomogeneity: float = 0.0,
) -> Volume:
    """Return the volume of `embedding`: vessels 100, background 12, as in the project's measured phantoms.

    Parameters
    ----------
    shape : int
        Voxels along each edge.
    spacing : float
        Voxel size, cm.
    noise : float
        Standard deviation of the (correlated) noise, grey levels.
    blur : float
        Standard deviation of the point-spread function, voxels.
    inhomogeneity : float
        Largest relative deviation of the vessels' grey level.

    Raises
    ------
    InputError
        If the network does not fit into the volume.
    """
    points = np.concatenate([*embedding.lines, embedding.cannula])
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    origin = middle - spacing * (shape - 1) / 2
    reach = np.ptp(points, axis=0).max() + 2 * embedding.network.radius.max() + 6 * spacing
    if reach > shape * spacing:
        raise InputError(f"the network needs {reach:.3g} cm, the volume has {shape * spacing:.3g}; use more voxels")
    distance = np.full((shape, shape, shape), 2.0, dtype=np.float32)  # voxels outside the surface
    network = embedding.network
    _add_tube(distance, (embedding.cannula - origin) / spacing, PE90_RADIUS / spacing, True)
    for row, line in enumerate(embedding.lines):
        is_end = not network.daughters[row]
        _add_tube(distance, (line - origin) / spacing, network.radius[row] / spacing, is_end)
    grey = np.clip(0.5 - distance, 0, 1)
    if inhomogeneity:
        wave = np.sin(2 * np.pi * (np.arange(shape) / shape + rng.uniform()))
        grey *= (1 + inhomogeneity * wave[:, None, None] * wave[None, :, None]).astype(np.float32)
    grey = 12 + 88 * gaussian_filter(grey, blur)
    if noise:
        grain = gaussian_filter(rng.standard_normal(grey.shape, dtype=np.float32), 0.7)
        grey += grain * np.float32(noise / grain.std())
    return Volume(grey, np.full(3, spacing), origin)


def _add_tube(distance: np.ndarray, line: np.ndarray, radius: float, cut_end: bool) -> None:
    """Lower `distance` (voxels, signed) to the tube around `line`; a terminal is cut flat."""
    # A voxel's share of the lumen falls linearly over one voxel at the wall, which adds π/12 to a circle's area.
    radius = float(np.sqrt(max(radius**2 - 1 / 12, 0.01)))
    count = max(int(np.linalg.norm(np.diff(line, axis=0), axis=1).sum() / 0.25), 8)
    at = np.linspace(0, len(line) - 1, count)
    fine = np.stack([np.interp(at, np.arange(len(line)), line[:, k]) for k in range(3)], axis=1)
    tangent = fine[-1] - fine[-4]
    tangent /= np.linalg.norm(tangent)
    pieces = max(1, int(count * 0.25 / (3 * radius)))
    for index, piece in enumerate(np.array_split(fine, pieces)):
        low = np.maximum(np.floor(piece.min(axis=0) - radius - 2).astype(int), 0)
        high = np.minimum(np.ceil(piece.max(axis=0) + radius + 3).astype(int), distance.shape)
        box = tuple(slice(a, b) for a, b in zip(low, high, strict=True))
        voxels = np.stack(np.meshgrid(*map(np.arange, low, high), indexing="ij"), axis=-1).reshape(-1, 3)
        value = cKDTree(piece).query(voxels)[0] - radius
        if cut_end and index == pieces - 1:
            value = np.maximum(value, (voxels - fine[-1]) @ tangent)
        local = distance[box]
        np.minimum(local, value.reshape(local.shape), out=local)


def write_dicom_series(volume: Volume, folder: str | Path) -> None:
    """Write `volume` as one DICOM file a slice (16 bit, 0.05 grey levels a step)."""
    from pydicom.dataset import FileDataset, FileMetaDataset
    from pydicom.uid import CTImageStorage, ExplicitVRLittleEndian, generate_uid

    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    series, frame, slope = generate_uid(), generate_uid(), 0.05
    for index, plane in enumerate(volume.grey):
        meta = FileMetaDataset()
        meta.TransferSyntaxUID, meta.MediaStorageSOPClassUID = ExplicitVRLittleEndian, CTImageStorage
        meta.MediaStorageSOPInstanceUID = generate_uid()
        image = FileDataset("", {}, file_meta=meta, preamble=b"\0" * 128)
        image.SOPClassUID, image.SOPInstanceUID = CTImageStorage, meta.MediaStorageSOPInstanceUID
        image.SeriesInstanceUID, image.StudyInstanceUID, image.FrameOfReferenceUID = series, frame, frame
        image.Modality, image.PatientName, image.PatientID = "CT", "Phantom", "phantom"
        image.InstanceNumber = index + 1
        z, y, x = (volume.origin + np.array([index, 0, 0]) * volume.spacing) * 10
        image.ImagePositionPatient = [f"{value:.9g}" for value in (x, y, z)]
        image.ImageOrientationPatient = [1, 0, 0, 0, 1, 0]
        image.PixelSpacing = [f"{value * 10:.9g}" for value in volume.spacing[1:]]
        image.SliceThickness = f"{volume.spacing[0] * 10:.9g}"
        image.Rows, image.Columns = plane.shape
        image.SamplesPerPixel, image.PhotometricInterpretation = 1, "MONOCHROME2"
        image.BitsAllocated, image.BitsStored, image.HighBit, image.PixelRepresentation = 16, 16, 15, 1
        image.RescaleSlope, image.RescaleIntercept = slope, 0
        image.PixelData = np.round(plane / slope).astype("<i2").tobytes()
        image.save_as(folder / f"slice{index + 1:04d}.dcm", enforce_file_format=True)
