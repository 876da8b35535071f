"""The first look at an image as text for a terminal, as one page, and as JSON."""

import json
import shlex
from pathlib import Path
from typing import Any

import numpy as np

from vasowave.figures.look import grey_scale_figure, histogram_figure, projections_figure
from vasowave.findings import texts
from vasowave.imaging.options import Options, grey_text
from vasowave.imaging.overview import Overview
from vasowave.imaging.places import written
from vasowave.io.files import check_file, write_file
from vasowave.provenance import provenance
from vasowave.report.blocks import Drawing
from vasowave.report.environment import templates
from vasowave.report.html import embedded
from vasowave.settings import settings_of

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


def command(seen: Overview) -> str:
    """Return the command to type next."""
    source = Path("SCAN") if seen.source is None else seen.source
    name = source.name.split(".")[0] or "scan"
    defaults, words = settings_of(Options), ["vasowave", "extract", shlex.quote(str(source)), "-o", shlex.quote(name)]
    for key in ("root", "threshold", "method", "cannula", "species", "voxel", "grey", "loops"):
        value = getattr(seen.options, key)
        if value is None or (key != "root" and value == defaults[key].default):
            continue
        text = written(value) if key == "root" else grey_text(value) if key == "grey" else f"{value}"
        # A root whose first coordinate is negative would be taken for an option.
        words.append(f"--{key}={text.removesuffix('.0')}")
    return " ".join(words)


def facts(seen: Overview) -> list[tuple[str, str]]:
    """Return what is said of the image, each with its name."""
    image, levels = seen.image, seen.levels
    size = " × ".join(f"{count}" for count in image.grey.shape[::-1])
    span = " × ".join(f"{one:.3g}" for one in (np.array(image.grey.shape) * image.spacing)[::-1])
    spacing = " × ".join(f"{1e4 * one:.4g}" for one in image.spacing[::-1])
    low, high = seen.histogram.edges[[0, -1]]
    bits = seen.histogram.bits
    return [
        ("image", f"{seen.kind}, {size} voxels (x, y, z), {span} cm"),
        ("voxel", f"{spacing} µm"),
        (
            "grey levels",
            f"{low:.5g} to {high:.5g}, {f'whole numbers, {bits} bits' if bits else 'decimal numbers'}",
        ),
        ("background, lumen", f"{levels.background:.4g}, {levels.lumen:.4g}; noise {seen.lumen.noise:.3g} (SD)"),
        ("threshold", f"{seen.options.threshold:.4g}{' on the corrected scale' if seen.options.grey else ''}"),
        ("saturation", f"{seen.grey.saturated:.1%} of the lumen's voxels have its highest level"),
        ("grey scale", _scale(seen)),
        ("cannula", _cannula(seen.options.cannula)),
        ("loops", _loops(seen)),
    ]


def _cannula(diameter: float) -> str:
    known = f"{diameter:g} cm wide within, as is assumed" if diameter else "none"
    return f"{known}; if that is not so: --cannula DIAMETER, 0 where there is none"


def _scale(seen: Overview) -> str:
    scale, measured = seen.grey.scale, seen.measured
    if measured is None:
        return "not known without a first tree"
    ratio = measured.densitometric / measured.inscribed
    ratio = ratio[np.isfinite(ratio)]
    radii = f"; radius by grey level over radius by outline {np.median(ratio):.3f}" if len(ratio) else ""
    if scale is None:
        return f"not known: too little noise, or too few clear vessels{radii}"
    said = f"off by {scale.bend:+.0%} of the contrast at most, by the noise at each level{radii}"
    if seen.grey.offered:
        return f"{said}; --grey makes it linear and gives the cannula its known diameter"
    return said


def _loops(seen: Overview) -> str:
    if not seen.loops:
        return "none"
    places = "; ".join(f"{written(one.place)} (ring of {one.length:.2g} cm)" for one in seen.loops[:_SHOWN])
    what = "touching vessels, or an anastomosis; the command cuts each at its thinnest and doubts the vessels there"
    if seen.closed:
        what = "the level set closes them all"
    if seen.opening is not None and not seen.closed:
        what = f"none is left at a threshold of {seen.opening:.4g}"
    return f"{len(seen.loops)}, thinnest at (x,y,z, cm) {places}: {what}"


def entrance_rows(seen: Overview) -> list[tuple[str, str, str]]:
    """Return number, place and radius of the ends of the lumen where the blood may enter."""
    ends = seen.entrances[:_SHOWN]
    return [(f"{number}", written(one.place), f"{one.radius:.3g}") for number, one in enumerate(ends, 1)]


def look_text(seen: Overview) -> str:
    """Return the first look as text for a terminal."""
    lines = [f"{name + ':':<19}{text}" for name, text in facts(seen)]
    lines += ["", "Ends of the lumen, the widest first:"]
    lines += [f"  {number}  {place}  radius {radius} cm" for number, place, radius in entrance_rows(seen)]
    lines += ["", *(f"Warning: {text}" for text in texts(seen.findings))]
    return "\n".join([*lines, *_next(seen)])


def _next(seen: Overview) -> list[str]:
    sure = "" if seen.is_clear else " (is the first end where the blood enters? else take another)"
    return ["", f"Type next{sure}:", f"  {command(seen)}"]


def look_page(seen: Overview) -> str:
    """Return the first look as one HTML page that needs no network."""
    from markupsafe import Markup

    drawn = [("projections", projections_figure(seen)), ("histogram", histogram_figure(seen))]
    if scale := grey_scale_figure(seen):
        drawn.append(("grey-scale", scale))
    narrow = {"projections": projections_figure(seen, wide=False)}
    figures = [Drawing(name, _CAPTIONS[name], figure, narrow.get(name)) for name, figure in drawn]
    template = templates().get_template("look.html")
    return template.render(
        source="an image that was given as such" if seen.source is None else str(seen.source),
        facts=facts(seen),
        entrances=entrance_rows(seen),
        sure=seen.is_clear,
        notes=texts(seen.findings),
        command=command(seen),
        figures=[(Markup(embedded(one)), one.caption) for one in figures],
        provenance=_origin(seen),
    )


def look_json(seen: Overview) -> str:
    """Return the first look as JSON; lengths in cm, places x, y, z in the world."""
    scale = seen.grey.scale
    values: dict[str, Any] = {
        "kind": seen.kind,
        "size": seen.image.grey.shape[::-1],
        "spacing [cm]": seen.image.spacing[::-1].tolist(),
        "bits": seen.histogram.bits,
        "histogram": {"edges": seen.histogram.edges.tolist(), "counts": seen.histogram.counts.tolist()},
        "background": seen.levels.background,
        "lumen": seen.levels.lumen,
        "noise": seen.lumen.noise,
        "threshold": seen.options.threshold,
        "saturated": seen.grey.saturated,
        "bend": None if scale is None else scale.bend,
        "grey": seen.grey.offered,
        "entrances": [{"place [cm]": one.place[::-1].tolist(), "radius [cm]": one.radius} for one in seen.entrances],
        "loops": [{"place [cm]": one.place[::-1].tolist(), "length [cm]": one.length} for one in seen.loops],
        "findings": [{"code": one.code, "text": str(one)} for one in seen.findings],
        "command": command(seen),
        "provenance": _origin(seen),
    }
    return json.dumps(values, indent=1, ensure_ascii=False) + "\n"


def _origin(seen: Overview) -> dict[str, str]:
    return provenance([seen.source] if seen.source is not None and seen.source.is_file() else [])


def write_look(seen: Overview, path: Path) -> Path:
    """Write the page, or JSON if the name of the file ends so.

    Raises
    ------
    InputError
        Another ending, or a file that cannot be written.
    """
    check_look_file(path)
    return write_file(path, look_json(seen) if path.suffix.lower() == ".json" else look_page(seen))


def check_look_file(path: Path) -> None:
    """Raise `InputError` unless `path` is a page or JSON that can be written."""
    check_file(path, ".html", ".json")
