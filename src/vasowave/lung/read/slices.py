"""Slices as pictures (BMP, PNG, JPEG, TIFF), one file each, in the order of the number in their names."""

import re
from collections import defaultdict
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from vasowave.base.cures import VOXEL
from vasowave.base.errors import InputError
from vasowave.base.findings import Finding
from vasowave.lung.read.findings import CROPPED, FLAT_SCALE, LEFT_OUT, STEP
from vasowave.lung.read.folder import surveyed
from vasowave.lung.read.formats import VOLUMES, VolumeFormat
from vasowave.lung.read.sidecars import read_fields, section_step, voxel_size_in
from vasowave.lung.read.tiff import read_tiff
from vasowave.lung.read.volume import UNSIZED, Image

_MIN_SLICES = 3
_MAX_COLOR_LEVELS = 2
"""Levels by which the channels of a grey picture may differ, as after JPEG."""


class Stack(NamedTuple):
    """Slices in their order, their numbers, and pictures that are no slices."""

    files: list[Path]
    numbers: list[int]
    singles: list[Path]


def read_slices(folder: Path) -> Image:
    """Read a stack of pictures; the texts beside it may say how large a voxel is."""
    survey = surveyed(folder)
    stack = stack_of(folder, survey.pictures)
    pictures = [_picture(file) for file in stack.files]
    unlike = next((k for k, picture in enumerate(pictures) if picture.grey.shape != pictures[0].grey.shape), None)
    if unlike is not None:
        raise InputError(
            f"{folder}: {stack.files[0].name} and {stack.files[unlike].name} differ in size; keep one stack"
        )
    texts = [read_fields(path) for path in survey.texts]
    size, step = voxel_size_in(texts, folder), section_step(texts)
    number_step = stack.numbers[1] - stack.numbers[0]
    if number_step not in (1, step):
        raise InputError(
            f"{folder}: {stack.files[0].name} is followed by {stack.files[1].name}, and no text beside them says that "
            "slices lie so far apart; copy all, or number them one by one and give the size of a voxel",
            [VOXEL],
        )
    spacing, provenance = (
        (UNSIZED, "no slice holds a size of voxels, and no text beside them") if size is None else size
    )
    findings = [*dict.fromkeys(finding for picture in pictures for finding in picture.findings)]
    if stack.singles:
        names = ", ".join(path.name for path in stack.singles)
        findings.append(LEFT_OUT(count=len(stack.singles), names=names))
    if step > 1 and number_step == 1:
        findings.append(STEP(step=step, first=stack.numbers[0], second=stack.numbers[1]))
    findings += _contradictions(stack, texts, pictures[0], spacing)
    grey = np.stack([picture.grey for picture in pictures])
    return Image(grey, spacing, np.zeros(3), provenance=provenance, findings=tuple(findings))


def stack_of(folder: Path, pictures: list[Path]) -> Stack:
    """Return the slices among pictures by the one number in their names that counts.

    Raises
    ------
    InputError
        Several stacks, no or several numbers that count, a number that is missing or there twice.
    """
    groups: dict[str, list[Path]] = defaultdict(list)
    for path in pictures:
        groups[re.sub(r"\d+", "#", path.name.lower())].append(path)
    stacks = [group for group in groups.values() if len(group) >= _MIN_SLICES]
    if len(stacks) != 1:
        names = ", ".join(group[0].name for group in list(groups.values())[:4])
        problem = "more than one stack of slices" if stacks else f"fewer than {_MIN_SLICES} slices of one name"
        raise InputError(f"{folder}: {problem} ({names} …); give a folder with one stack")
    columns = np.array([[int(number) for number in re.findall(r"\d+", path.name)] for path in stacks[0]], dtype=object)
    counting = [column for column in columns.T if len(set(column)) > 1]
    if len(counting) != 1:
        raise InputError(f"{folder}: which number in the names counts the slices ({stacks[0][0].name})? Rename them")
    order = sorted(range(len(columns)), key=lambda k: counting[0][k])
    numbers, files = [int(counting[0][k]) for k in order], [stacks[0][k] for k in order]
    steps = [after - before for before, after in pairwise(numbers)]
    k = next((k for k, step in enumerate(steps) if step == 0 or (min(steps) > 0 and step != min(steps))), None)
    if k is not None:
        problem = "slices are missing between" if steps[k] else "one number for"
        raise InputError(f"{folder}: {problem} {files[k].name} and {files[k + 1].name}; export the stack again")
    return Stack(files, numbers, [path for group in groups.values() if group is not stacks[0] for path in group])


def _picture(path: Path) -> Image:
    """Return one slice; a picture in color is one if its channels agree."""
    image = read_tiff(path) if path.name.lower().endswith((".tif", ".tiff")) else _flat(path)
    grey = np.squeeze(image.grey)
    if grey.ndim == 3 and grey.shape[-1] in (2, 3, 4):
        color = grey[..., : 3 if grey.shape[-1] > 2 else 1].astype(int)
        if np.ptp(color, axis=-1).max() > _MAX_COLOR_LEVELS:
            raise InputError(f"{path}: a picture in color; export grey levels")
        grey = grey[..., 0]
    if grey.ndim != 2:
        raise InputError(f"{path}: holds more than one slice; give it without the others")
    return image._replace(grey=grey)


def _flat(path: Path) -> Image:
    from PIL import Image as Pillow

    try:
        with Pillow.open(path) as picture:
            is_palette = picture.mode in ("P", "PA")
            grey = np.array(picture.convert("RGB") if is_palette else picture)
    except Exception:
        raise InputError(f"{path}: not a readable picture, or truncated; export it again") from None
    return Image(grey, UNSIZED, np.zeros(3))


def _contradictions(stack: Stack, texts: list[dict[str, str]], first: Image, spacing: np.ndarray) -> list[Finding]:
    """Return findings where the log counts other slices, or the slices' own scale is another."""
    findings = []
    for fields in texts:
        plain = {key.rpartition("/")[2]: value for key, value in fields.items()}
        ends = [plain.get(f"{end} section", "") for end in ("first", "last")]
        if not all(end.isdigit() for end in ends):
            continue
        counted = dict(zip(("wanted_first", "wanted_last"), map(int, ends), strict=True))
        if (int(ends[1]) - int(ends[0])) // section_step([fields]) + 1 != len(stack.files):
            findings.append(CROPPED(first=stack.numbers[0], last=stack.numbers[-1], source="the log", **counted))
    scale = first.spacing[1:]
    if np.isfinite([*scale, *spacing]).all() and not np.allclose(scale, spacing[1:], rtol=5e-3):
        size, used = (" × ".join(f"{1e4 * length:.4g}" for length in sides[::-1]) for sides in (scale, spacing[1:]))
        findings.append(FLAT_SCALE(size=size, used=used, source=first.provenance))
    return findings


def _is_stack(path: Path, start: bytes) -> bool:
    return path.is_dir() and not surveyed(path).dicom


VOLUMES.register(VolumeFormat("slices", "slices", (), _is_stack, read_slices, oriented=False))
