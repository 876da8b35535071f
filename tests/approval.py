"""Approved descriptions: what a program draws and writes, in files that are read when they change.

A description tells results (sizes, colors, places, ranges, words), never the source. Words must be the same,
numbers nearly so: another machine may round the last digit of a coordinate, and nobody sees it. When a change is meant,

    VASOWAVE_APPROVE=1 uv run pytest -n 0 -k approved

writes the descriptions anew; their difference says what a reader of the report will see otherwise.
"""

import base64
import dataclasses
import difflib
import io
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
PAPER = 0.02  # pt, as well: 7 µm on paper
NUMBER = re.compile(r"(?<![\w#.])[-+−]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w#])")
DIGEST = re.compile(r"[0-9a-f]{16,}")
BLOCKS = {"h1", "h2", "h3", "h4", "p", "li", "tr", "dt", "dd", "summary", "label", "button", "pre", "title"}
UNSEEN = {"svg", "style", "script"}
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
    """Return whether two lines have the same words and nearly the same numbers."""
    if one == other:
        return True
    lines = [line.replace("−", "-").replace("..", " .. ") for line in (one, other)]  # a range's ends are numbers, too
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
    """Describe a drawing: of every panel what looks alike, how much of it, from where to where, with its words."""
    root = ElementTree.fromstring(svg)
    yield f"== {name}: {_short(root.get('width'))} x {_short(root.get('height'))}"
    for panel in root.findall(".//*[@id='figure_1']/*"):
        kinds: dict[str, list[tuple[np.ndarray, str]]] = {}
        for look, points, words in _drawn(panel):
            kinds.setdefault(look, []).append((points, words))
        for look, parts in kinds.items():
            points = np.concatenate([part for part, _ in parts])
            words = " | ".join(word for _, word in parts if word)
            yield f"{len(parts)} {look}{_span(points)}{': ' * bool(words)}{words}"


def artists(figure: Any) -> Iterator[str]:
    """Describe a figure by what it was asked to draw, with the values themselves, before anything is laid out."""
    yield f"{len(figure.axes)} panels in {figure.get_figwidth():.4f} x {figure.get_figheight():.4f}"
    for legend in figure.legends:
        yield _legend(legend)
    for ax in figure.axes:
        place = " ".join(f"{value:.4f}" for value in ax.get_position().bounds)
        (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
        yield f"== {place}: {_title(ax)}; {ax.get_xscale()} {left:.5g}..{right:.5g} {ax.get_xlabel()};" + (
            f" {ax.get_yscale()} {low:.5g}..{high:.5g} {ax.get_ylabel()}{'' if ax.axison else ' (hidden)'}"
        )
        for axis in (ax.xaxis, ax.yaxis):
            words = [one.get_text() for one in axis.get_majorticklabels()]
            yield f"{axis.axis_name}: {' | '.join(words)!r} at {_numbers(axis.get_majorticklocs())}"
        for line in ax.lines:
            look = (line.get_color(), line.get_linestyle(), line.get_linewidth(), line.get_marker(),
                    line.get_markersize(), line.get_markerfacecolor(), line.get_alpha(), line.get_zorder(),
                    line.get_label(), line.get_gid())  # fmt: skip
            yield f"line {' '.join(map(str, look))}: {_numbers(line.get_xdata())}; {_numbers(line.get_ydata())}"
        for one in (*ax.patches, *ax.collections):
            paths = [one.get_path()] if hasattr(one, "get_path") else one.get_paths()
            points = np.concatenate([path.vertices for path in paths]) if paths else np.empty((0, 2))
            colors = np.round(np.atleast_2d(one.get_facecolor()), 3).tolist()
            look = (type(one).__name__, colors[:3], one.get_linewidth(), one.get_hatch(), one.get_label())
            yield f"{' '.join(map(str, look))}{_span(points)}"
        for text in ax.texts:
            arrow = getattr(text, "arrow_patch", None)
            said = f", arrow {arrow.get_linewidth():.4g} {arrow.get_edgecolor()} {arrow.get_gid()}" if arrow else ""
            at = f"{_numbers(getattr(text, 'xy', ()))} by {_numbers(text.get_position())}"
            look = (text.get_fontsize(), text.get_color(), text.get_ha(), text.get_va(), text.get_rotation())
            yield f"text {text.get_text()!r} at {at}: {' '.join(map(str, look))}{said}"
        if ax.get_legend():
            yield _legend(ax.get_legend())


def _legend(legend: Any) -> str:
    return f"legend of {legend._ncols}: {' | '.join(text.get_text() for text in legend.get_texts())}"


def _title(ax: Any) -> str:
    return repr(" ".join(filter(None, (ax.get_title(place) for place in ("left", "center", "right")))))


def _numbers(numbers: Iterable[float]) -> str:
    found = np.asarray(numbers, float)
    return values(found) if len(found) > 8 else " ".join(f"{one:.5g}" for one in found)


def _span(points: np.ndarray) -> str:
    if not len(points):
        return ""
    ranges = zip("xy", points.min(0), points.max(0), points.mean(0), strict=True)
    spans = (f"{axis} {low:.2f}..{high:.2f} ({mean:.2f})" for axis, low, high, mean in ranges)
    return f"; {len(points)} at {' '.join(spans)}"


def figures(folder: Path, without: tuple[str, ...] = ()) -> Iterator[str]:
    """Describe the drawings of a folder but some."""
    for path in sorted(folder.glob("*.svg")):
        if path.stem not in without:
            yield from figure(path.stem, path.read_text(encoding="utf-8"))


def _drawn(panel: ElementTree.Element) -> Iterator[tuple[str, np.ndarray, str]]:
    """Yield the look, the points and the words of every path, mark, text and picture of a panel."""
    for element in panel.iter():
        kind, look = element.tag.partition("}")[2], _look(element)
        if kind == "path":
            yield f"path {look}", _points(element.get("d", "")), ""
        elif kind == "use":
            yield f"mark {look}", np.array([[float(element.get(axis, 0)) for axis in "xy"]]), ""
        elif kind == "text":
            place = re.findall(r"[-\d.]+", element.get("transform", "")) or [0, element.get("x"), element.get("y")]
            yield f"text {look}", np.array([place[-2:]], float), "".join(element.itertext()).strip()
        elif kind == "title":
            yield "tip", np.empty((0, 2)), (element.text or "").strip()
        elif kind == "image":
            yield f"picture {_pixels(element)}", np.array([[float(element.get(axis, 0)) for axis in ("x", "y")]]), ""


def _look(element: ElementTree.Element) -> str:
    style = re.sub(r"font-family: [^;]*|stroke-line(cap|join): \w+", "", element.get("style", ""))
    turned = re.search(r"rotate\(([-\d.]+)", element.get("transform", ""))
    parts = [part.strip() for part in style.split(";") if part.strip()]
    return ", ".join(parts) + (f", turned {float(turned[1]):.0f}" if turned and float(turned[1]) else "")


def _points(path: str) -> np.ndarray:
    return np.array(re.findall(r"-?[\d.]+(?:e-?\d+)?", path), float).reshape(-1, 2)


def _pixels(element: ElementTree.Element) -> str:
    """Describe a picture by its size and mean color."""
    from matplotlib.image import imread

    data = base64.b64decode(element.get(LINK, "").partition(",")[2])
    pixels = imread(io.BytesIO(data))
    return f"{pixels.shape[0]} by {pixels.shape[1]} of " + " ".join(f"{mean:.2f}" for mean in pixels.mean((0, 1)))


def _short(length: str | None) -> str:
    return f"{float((length or '0').removesuffix('pt')):.1f}"


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
