"""Approved descriptions: what a program draws and writes, in files that are read when they change.

A description tells results (words, values, kinds, looks), never the source, and of a drawing nothing of its layout.
Words must be the same, numbers nearly so: another machine may round the last digit, and nobody sees it. When a change
is meant,

    VASOWAVE_APPROVE=1 uv run pytest -n 0 -k approved

writes the descriptions anew; their difference says what a reader of the report will see otherwise.
"""

import base64
import dataclasses
import difflib
import io
import json
import math
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from html.parser import HTMLParser
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

import numpy as np

if TYPE_CHECKING:
    import xarray as xr

APPROVED = Path(__file__).parent / "approved"
RELATIVE = 2e-4  # difference of numbers that count as the same
PAPER = 0.02  # of values read back from a drawing, as well
NUMBER = re.compile(r"(?<![\w#.])[-+−]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w#])")
ENDS = re.compile(r"(?<= of )(\d+), ([-+\d.e]+) ([-+\d.e]+)(?= )")  # of an array: how many values, lowest, highest
DIGEST = re.compile(r"[0-9a-f]{16,}")
BLOCKS = {"h1", "h2", "h3", "h4", "p", "li", "tr", "dt", "dd", "summary", "label", "button", "pre", "title"}
UNSEEN = {"svg", "style", "script"}
MARK = "mark:"  # before what a page knows of a part of a drawing
BARE = re.compile(r"[-+−]?[\d.,]+(?:[×·]10.*)?")  # a number alone
LINK = "{http://www.w3.org/1999/xlink}href"


def approve(name: str, description: Iterable[str], absolute: float = 0.0, relative: float = RELATIVE) -> None:
    """Compare a description with the approved one, line by line, or write it where that was asked for."""
    path, lines = APPROVED / f"{name}.txt", [line.rstrip() for line in description]
    if os.environ.get("VASOWAVE_APPROVE"):
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    agreed = path.read_text(encoding="utf-8").splitlines()
    same = [line if alike(line, new, absolute, relative) else new for line, new in zip(agreed, lines, strict=False)]
    found = difflib.unified_diff(agreed, same + lines[len(agreed) :], "approved", "found", lineterm="", n=1)
    changed = "\n".join(list(found)[:60])
    assert not changed, f"{changed}\nMeant? VASOWAVE_APPROVE=1 uv run pytest -n 0 -k approved; read what changes"


def alike(one: str, other: str, absolute: float, relative: float) -> bool:
    """Return whether two lines have the same words and nearly the same numbers; ends of an array by the larger one."""
    if one == other:
        return True
    lines = [line.replace("−", "-").replace("..", " .. ") for line in (one, other)]  # a range's ends are numbers, too
    arrays = [ENDS.search(line) for line in lines]
    if arrays[0] and arrays[1]:
        ends = np.array([array.groups()[1:] for array in arrays if array], dtype=float)
        if np.ptp(ends, axis=0).max() > max(absolute, relative * np.abs(ends).max()):
            return False
        lines = [ENDS.sub(r"\1, # #", line) for line in lines]
    numbers, others = map(NUMBER.findall, lines)
    return (
        NUMBER.sub("#", lines[0]) == NUMBER.sub("#", lines[1])
        and len(numbers) == len(others)
        and all(
            math.isclose(float(a), float(b), rel_tol=relative, abs_tol=absolute)
            for a, b in zip(numbers, others, strict=True)
        )
    )


def figure(name: str, svg: str) -> Iterator[str]:
    """Describe a drawing: of every panel what looks alike and how much of it, with values where the panel has a scale.

    Where things lie on the paper is left out, and so are numbers along axes, which room and letters decide.
    """
    root = ElementTree.fromstring(svg)
    shapes = {f"#{one.get('id')}": len(_points(one.get("d", ""))) for one in root.iter() if one.get("id")}
    yield f"== {name}"
    for panel in root.findall(".//*[@id='figure_1']/*"):
        kinds: dict[str, list[tuple[np.ndarray, str]]] = {}
        scale = _scale(panel)
        for look, points, words in _drawn(panel, shapes):
            kinds.setdefault(look, []).append((scale(points), words))
        for look, parts in kinds.items():
            yield _alike_in_look(look, parts)


def artists(figure: Any) -> Iterator[str]:
    """Describe a figure by what it was asked to draw: words, kinds, looks and values, and not where they are put.

    Numbers along an axis that says nothing, and along one whose ticks are words, are places and no values.
    """
    yield f"{len(figure.axes)} panels"
    for legend in figure.legends:
        yield _legend(legend)
    for ax in figure.axes:
        yield f"== {_title(ax)}; x: {_axis(ax.xaxis)}; y: {_axis(ax.yaxis)}{'' if ax.axison else ' (hidden)'}"
        measured = [ax.axison and _measures(axis) for axis in (ax.xaxis, ax.yaxis)]
        kinds: dict[str, list[tuple[np.ndarray, str]]] = {}
        for look, points, words in _asked(ax):
            kinds.setdefault(look, []).append((np.where(measured, points, np.nan), words))
        for look, parts in kinds.items():
            yield _alike_in_look(look, parts)
        if ax.get_legend():
            yield _legend(ax.get_legend())


def _legend(legend: Any) -> str:
    return f"legend: {' | '.join(text.get_text() for text in legend.get_texts())}"


def _title(ax: Any) -> str:
    return repr(" ".join(filter(None, (ax.get_title(place) for place in ("left", "center", "right")))))


def _axis(axis: Any) -> str:
    said = [axis.get_scale(), axis.get_label_text(), "" if _measures(axis) else " | ".join(_ticks(axis))]
    return repr(" ".join(filter(None, said)))


def _ticks(axis: Any) -> list[str]:
    return [one.get_text() for one in axis.get_majorticklabels() if one.get_text()]


def _measures(axis: Any) -> bool:
    """Whether places along an axis are values; phases are written in halves of π."""
    shown = axis.get_tick_params().get("labelleft" if axis.axis_name == "y" else "labelbottom", True)
    return bool(shown or axis.get_label_text()) and not any(re.search(r"[^\W\d_π]", one) for one in _ticks(axis))


def _asked(ax: Any) -> Iterator[tuple[str, np.ndarray, str]]:
    """Yield the look, the points and the words of everything that a panel was asked to draw."""
    for line in ax.lines:
        marker = f"{line.get_marker()} {line.get_markersize():g} {line.get_markerfacecolor()}"
        marked = "" if line.get_marker() in ("None", "", None) else f", mark {marker}"
        look = f"line {line.get_color()} {line.get_linestyle()} {line.get_linewidth():g}{marked}{_clear(line)}"
        yield look, np.asarray(line.get_xydata(), float), _words(line)
    for one in (*ax.patches, *ax.collections):
        colors = np.unique(np.round(np.atleast_2d(one.get_facecolor()), 3), axis=0).tolist()
        look = f"{type(one).__name__} {colors[:3]} {np.atleast_1d(one.get_linewidth())[:1]} {one.get_hatch()}"
        yield look, _outline(one), _words(one)
    for text in ax.texts:
        arrow = getattr(text, "arrow_patch", None)
        said = f", arrow {arrow.get_linewidth():.3g} {np.round(arrow.get_edgecolor(), 3).tolist()}" if arrow else ""
        yield f"text {text.get_color()}{said}", np.empty((0, 2)), text.get_text()


def _clear(artist: Any) -> str:
    return f", opacity {artist.get_alpha():g}" if artist.get_alpha() is not None else ""


def _words(artist: Any) -> str:
    """Return the name of an artist in a legend and the tip that a page shows of it."""
    label, note = str(artist.get_label()), str(artist.get_gid() or "")
    tip = json.loads(note.removeprefix(MARK)).get("tip", "") if note.startswith(MARK) else ""
    return ", ".join(dict.fromkeys(one for one in (label, tip) if one and not one.startswith("_")))


def _outline(artist: Any) -> np.ndarray:
    """Return the corners of a patch or a collection in data; an arrow has only places."""
    if hasattr(artist, "get_paths"):
        paths = [path.vertices for path in artist.get_paths()]
        return np.concatenate(paths) if paths else np.empty((0, 2))
    if hasattr(artist, "get_arrowstyle"):
        return np.empty((0, 2))
    return np.asarray(artist.get_patch_transform().transform(artist.get_path().vertices))


def _alike_in_look(look: str, parts: list[tuple[np.ndarray, str]]) -> str:
    """Describe what looks alike: how many, their words, and values from where to where."""
    points = np.concatenate([part for part, _ in parts])
    known = [column[np.isfinite(column)] for column in points.T]
    spans = [f"{axis} {_span(values)}" for axis, values in zip("xy", known, strict=True) if len(values)]
    words = " | ".join(word for _, word in parts if word)
    return "; ".join([f"{len(parts)} {look}", *spans]) + (f": {words}" if words else "")


def _span(values: np.ndarray) -> str:
    low, high = values.min(), values.max()
    return f"{low:.5g}" if low == high else f"{low:.5g}..{high:.5g}"


def figures(folder: Path, without: tuple[str, ...] = ()) -> Iterator[str]:
    """Describe the drawings of a folder but some."""
    for path in sorted(folder.glob("*.svg")):
        if path.stem not in without:
            yield from figure(path.stem, path.read_text(encoding="utf-8"))


def _drawn(panel: ElementTree.Element, shapes: Mapping[str, int]) -> Iterator[tuple[str, np.ndarray, str]]:
    """Yield the look, the points and the words of every path, mark, text and picture of a panel."""
    nowhere, along = np.empty((0, 2)), _along_axes(panel)
    for element in panel.iter():
        kind, look = element.tag.partition("}")[2], _look(element)
        if kind == "text":
            words = "".join(element.itertext()).strip()
            if element not in along or not BARE.fullmatch(words):
                yield "text", nowhere, words
        elif element in along or look == "fill: none":  # nothing of which is seen
            continue
        elif kind == "path":
            yield f"path {look}", _points(element.get("d", "")), ""
        elif kind == "use":
            place = np.array([[float(element.get(axis, 0)) for axis in "xy"]])
            yield f"mark of {shapes.get(element.get(LINK, ''), 0)} points {look}", place, ""
        elif kind == "title":
            yield "tip", nowhere, (element.text or "").strip()
        elif kind == "image":
            yield f"picture of {_mean_color(element)}", nowhere, ""


def _along_axes(panel: ElementTree.Element) -> set[ElementTree.Element]:
    """Return what belongs to the axes of a panel or is a shape that is only referred to."""
    found = set()
    for element in panel.iter():
        if element.get("id", "").startswith("matplotlib.axis_") or element.tag.endswith("}defs"):
            found |= set(element.iter())
    return found


def _scale(panel: ElementTree.Element) -> Callable[[np.ndarray], np.ndarray]:
    """Return what turns points on paper into values; a panel without a scale of its own has none."""
    group = next((one for one in panel.iter() if one.get("data-scale")), None)
    path = None if group is None else group.find("{*}path")
    if group is None or path is None:
        return lambda points: np.full_like(points, np.nan)
    limits, frame = json.loads(group.get("data-scale", "")), _points(path.get("d", ""))
    left, bottom = frame[:, 0].min(), frame[:, 1].max()
    size = np.array([frame[:, 0].max() - left, frame[:, 1].min() - bottom])
    low, high = np.array([limits["x"], limits["y"]]).T
    return lambda points: low + (points - [left, bottom]) / size * (high - low)


def _look(element: ElementTree.Element) -> str:
    style = re.sub(r"stroke-line(cap|join): \w+", "", element.get("style", ""))
    return ", ".join(part.strip() for part in style.split(";") if part.strip())


def _points(path: str) -> np.ndarray:
    return np.array(re.findall(r"-?[\d.]+(?:e-?\d+)?", path), float).reshape(-1, 2)


def _mean_color(element: ElementTree.Element) -> str:
    from matplotlib.image import imread

    data = base64.b64decode(element.get(LINK, "").partition(",")[2])
    return " ".join(f"{mean:.2f}" for mean in imread(io.BytesIO(data)).mean((0, 1)))


class _Page(HTMLParser):
    """Collects the words of a page, a line for every heading, paragraph, entry and row of a table."""

    def __init__(self, text: str):
        super().__init__()
        self.lines, self.unseen = [""], 0
        self.feed(text)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.unseen, values = self.unseen + (tag in UNSEEN), dict(attributes)
        if tag == "svg":
            self.lines[-1] += f"[drawing: {values.get('style')}] "
        if self.unseen:
            return
        if tag in BLOCKS or "id" in values:
            hidden = " (hidden)" if "hidden" in values else ""
            self.lines.append(f"{tag}{'#' * ('id' in values)}{values.get('id', '')}{hidden}: ")
        elif tag in ("td", "th"):
            self.lines[-1] += " | "
        elif tag == "sub":
            self.lines[-1] += "_"

    def handle_endtag(self, tag: str) -> None:
        self.unseen -= tag in UNSEEN

    def handle_data(self, data: str) -> None:
        if not self.unseen:
            self.lines[-1] += re.sub(r"\s+", " ", data)


def page(path: Path) -> Iterator[str]:
    """Describe a page by its words, but for its last section, which tells versions and times."""
    text = path.read_text(encoding="utf-8")
    text = re.split(r'<section id="provenance"|<h2>How it was made', text)[0]
    yield f"== {path.name}"
    yield from (line for line in _Page(text).lines if line.strip(" |"))


def table(path: Path) -> Iterator[str]:
    """Describe a table by its columns: how many values, from where to where, or its different words."""
    import pandas as pd

    yield f"== {path.name}"
    for name, column in pd.read_csv(path).items():
        yield f"{name}: {values(column.to_numpy())}"


def tree(result: "xr.DataTree") -> Iterator[str]:
    """Describe results by their variables: dimensions, what they say of themselves, and their values.

    How many simulations a search took is left out: at its end the last digit of another processor decides.
    """
    for group in result.subtree:
        yield f"== {group.path}: {', '.join(sorted(map(str, group.attrs)))}"
        for name, variable in group.to_dataset(inherit=False).variables.items():
            if name == "start_simulations":
                continue
            said = "; ".join(f"{key} {value}" for key, value in variable.attrs.items())
            yield f"{name} ({', '.join(map(str, variable.dims))}): {values(variable.to_numpy())}; {said}"


def parts(name: str, value: Any) -> Iterator[str]:
    """Describe a value of ours by the values it is made of, each under its place; digests are left out."""
    if dataclasses.is_dataclass(value):
        value = {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
    elif hasattr(value, "_asdict"):
        value = value._asdict()
    if isinstance(value, tuple | list) and (_all(value, str) or _all(value, int | float)):
        value = np.asarray(value)
    if isinstance(value, Mapping):
        for key, one in value.items():
            yield from parts(f"{name}.{key}", one)
    elif isinstance(value, tuple | list):
        for key, one in enumerate(value):
            yield from parts(f"{name}[{key}]", one)
    elif not (isinstance(value, str) and DIGEST.fullmatch(value)):
        yield f"{name}: {values(np.asarray(value)) if isinstance(value, np.ndarray | float) else value}"


def _all(parts: Iterable[Any], kind: Any) -> bool:
    return all(isinstance(one, kind) for one in parts)


def values(column: np.ndarray) -> str:
    """Describe numbers by their count, range, mean and SD, words by themselves."""
    if column.dtype.kind not in "iufb":
        return f"{len(column)} of " + ", ".join(sorted({str(value) for value in column.ravel()})[:12])
    numbers = np.asarray(column, float).ravel()
    finite = numbers[np.isfinite(numbers)]
    if not len(finite):
        return f"{len(numbers)} without a value"
    of: tuple[Callable[[np.ndarray], float], ...] = (np.min, np.max, np.mean, np.std)
    return f"{len(finite)} of {len(numbers)}, " + " ".join(f"{function(finite):.5g}" for function in of)
