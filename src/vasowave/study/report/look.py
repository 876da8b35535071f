"""The first look at an image as text for a terminal, as one page, and as JSON."""

import json
import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from vasowave.base.findings import texts
from vasowave.base.io.files import check_file, write_file
from vasowave.base.settings import settings_of
from vasowave.base.software import provenance
from vasowave.lung.options import Options, grey_text
from vasowave.lung.overview import Overview
from vasowave.lung.places import voxel_text, written
from vasowave.study.figures.look import grey_scale_figure, histogram_figure, projections_figure
from vasowave.study.report.blocks import Drawing
from vasowave.study.report.html import embedded, templates

_SHOWN = 6  # entrances and loops
_CAPTIONS = {
    "histogram": "Voxels of each grey level, with the background, the proposed threshold, and the middle of the widest "
    "vessels.",
    "grey-scale": "Left: what the noise at each grey level says that the level would be on a linear scale. Right: "
    "radius by grey level over radius by outline, vessel by vessel; where both are right it is 1 for wide and thin "
    "vessels alike.",
    "projections": "The brightest voxel along each axis of the image, the outline of the lumen (ochre), the ends where "
    "the blood may enter, the widest first (magenta squares), and where loops are thinnest (circles).",
}

_WRITTEN: dict[str, Callable[[Any], str]] = {"root": written, "grey": grey_text, "voxel": voxel_text}


def command(overview: Overview) -> str:
    """Return the command to type next."""
    source = Path("SCAN") if overview.source is None else overview.source
    name = source.name.split(".")[0] or "scan"
    defaults, words = settings_of(Options), ["vasowave", "extract", shlex.quote(str(source)), "-o", shlex.quote(name)]
    for key in ("root", "threshold", "method", "cannula", "species", "voxel", "grey", "loops"):
        value = getattr(overview.options, key)
        if value is None or (key != "root" and value == defaults[key].default):
            continue
        text = _WRITTEN.get(key, str)(value)
        # A root whose first coordinate is negative would be taken for an option.
        words.append(f"--{key}={text.removesuffix('.0')}")
    return " ".join(words)


def facts(overview: Overview) -> list[tuple[str, str]]:
    """Return what is said of the image, each with its name."""
    image, levels = overview.image, overview.levels
    size = " × ".join(f"{count}" for count in image.grey.shape[::-1])
    span = " × ".join(f"{length:.3g}" for length in (np.array(image.grey.shape) * image.spacing)[::-1])
    spacing = " × ".join(f"{1e4 * length:.4g}" for length in image.spacing[::-1])
    low, high = overview.histogram.edges[[0, -1]]
    bits, cannula = overview.histogram.bits, overview.options.cannula
    within = f"{cannula:g} cm wide within, as is assumed" if cannula else "none"
    return [
        ("image", f"{overview.kind}, {size} voxels (x, y, z), {span} cm"),
        ("voxel", f"{spacing} µm" + (f", by {image.provenance}" if image.provenance else "")),
        ("grey levels", f"{low:.5g} to {high:.5g}, {f'whole numbers, {bits} bits' if bits else 'decimal numbers'}"),
        ("background, lumen", f"{levels.background:.4g}, {levels.lumen:.4g}; noise {overview.lumen.noise:.3g} (SD)"),
        ("threshold", f"{overview.options.threshold:.4g}{' on the corrected scale' if overview.options.grey else ''}"),
        ("saturation", f"{overview.grey.saturated:.1%} of the lumen's voxels have its highest level"),
        ("grey scale", _scale(overview)),
        ("cannula", f"{within}; if that is not so, give its diameter, 0 where there is none"),
        ("loops", _loops(overview)),
    ]


def _scale(overview: Overview) -> str:
    scale, measured = overview.grey.scale, overview.measured
    if measured is None:
        return "not known without a first tree"
    ratio = measured.densitometric / measured.inscribed
    ratio = ratio[np.isfinite(ratio)]
    radii = f"; radius by grey level over radius by outline {np.median(ratio):.3f}" if len(ratio) else ""
    if scale is None:
        return f"not known: too little noise, or too few clear vessels{radii}"
    text = f"off by {scale.bend:+.0%} of the contrast at most, by the noise at each level{radii}"
    if overview.grey.offered:
        return f"{text}; corrected grey levels make it linear and give the cannula its known diameter"
    return text


def _loops(overview: Overview) -> str:
    if not overview.loops:
        return "none"
    places = "; ".join(f"{written(loop.place)} (ring of {loop.length:.2g} cm)" for loop in overview.loops[:_SHOWN])
    comment = "touching vessels, or an anastomosis; the command cuts each at its thinnest and doubts the vessels there"
    if overview.closed:
        comment = "the level set closes them all"
    if overview.opening is not None and not overview.closed:
        comment = f"none is left at a threshold of {overview.opening:.4g}"
    return f"{len(overview.loops)}, thinnest at (x,y,z, cm) {places}: {comment}"


def entrance_rows(overview: Overview) -> list[tuple[str, str, str]]:
    """Return number, place and radius of the ends of the lumen where the blood may enter."""
    ends = overview.entrances[:_SHOWN]
    return [(f"{number}", written(end.place), f"{end.radius:.3g}") for number, end in enumerate(ends, 1)]


def look_text(overview: Overview) -> str:
    """Return the first look as text for a terminal."""
    lines = [f"{name + ':':<19}{text}" for name, text in facts(overview)]
    lines += ["", "Ends of the lumen, the widest first:"]
    lines += [f"  {number}  {place}  radius {radius} cm" for number, place, radius in entrance_rows(overview)]
    lines += ["", *(f"Warning: {text}" for text in texts(overview.findings))]
    sure = "" if overview.is_clear else " (is the first end where the blood enters? else take another)"
    return "\n".join([*lines, "", f"Type next{sure}:", f"  {command(overview)}"])


def look_page(overview: Overview) -> str:
    """Return the first look as one HTML page that needs no network."""
    from markupsafe import Markup

    drawn = [("projections", projections_figure(overview)), ("histogram", histogram_figure(overview))]
    if scale := grey_scale_figure(overview):
        drawn.append(("grey-scale", scale))
    narrow = {"projections": projections_figure(overview, wide=False)}
    figures = [Drawing(name, _CAPTIONS[name], figure, narrow.get(name)) for name, figure in drawn]
    template = templates().get_template("look.html")
    return template.render(
        source="an image that was given as such" if overview.source is None else str(overview.source),
        facts=facts(overview),
        entrances=entrance_rows(overview),
        sure=overview.is_clear,
        notes=texts(overview.findings),
        command=command(overview),
        figures=[(Markup(embedded(drawing)), drawing.caption) for drawing in figures],
        provenance=_origin(overview),
    )


def look_json(overview: Overview) -> str:
    """Return the first look as JSON; lengths in cm, places x, y, z in the world."""
    scale = overview.grey.scale
    values: dict[str, Any] = {
        "kind": overview.kind,
        "size": overview.image.grey.shape[::-1],
        "spacing [cm]": overview.image.spacing[::-1].tolist(),
        "spacing by": overview.image.provenance,
        "bits": overview.histogram.bits,
        "histogram": {"edges": overview.histogram.edges.tolist(), "counts": overview.histogram.counts.tolist()},
        "background": overview.levels.background,
        "lumen": overview.levels.lumen,
        "noise": overview.lumen.noise,
        "threshold": overview.options.threshold,
        "saturated": overview.grey.saturated,
        "bend": None if scale is None else scale.bend,
        "grey": overview.grey.offered,
        "entrances": [
            {"place [cm]": entrance.place[::-1].tolist(), "radius [cm]": entrance.radius}
            for entrance in overview.entrances
        ],
        "loops": [{"place [cm]": loop.place[::-1].tolist(), "length [cm]": loop.length} for loop in overview.loops],
        "findings": [{"code": finding.code, "text": str(finding)} for finding in overview.findings],
        "command": command(overview),
        "provenance": _origin(overview),
    }
    return json.dumps(values, indent=1, ensure_ascii=False) + "\n"


def _origin(overview: Overview) -> dict[str, str]:
    return provenance([overview.source] if overview.source is not None and overview.source.is_file() else [])


def write_look(overview: Overview, path: Path) -> Path:
    """Write the page, or JSON if the name of the file ends so.

    Raises
    ------
    InputError
        Another ending, or a file that cannot be written.
    """
    check_look_file(path)
    return write_file(path, look_json(overview) if path.suffix.lower() == ".json" else look_page(overview))


def check_look_file(path: Path) -> None:
    """Raise `InputError` unless `path` is a page or JSON that can be written."""
    check_file(path, ".html", ".json")
