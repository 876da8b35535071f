"""The one unit system of vasowave: cm, s, ml, mmHg.

Only density carries mass, so only density is converted: in these units it is
``density / MMHG`` (mmHg s²/cm²), and every equation of the model then holds as printed.
Other units exist at the edge of the program only, in the headers of files.
"""

from functools import lru_cache

from vasowave.base.errors import InputError, did_you_mean

MMHG = 1333.22
"""One mmHg in dyn/cm²."""

MILLIWATT = 1e-4 * MMHG
"""One mmHg ml/s in mW, and one mmHg ml in mJ."""

_FACTORS = {
    "pressure": {
        "mmHg": 1.0,
        "Torr": 1.0,
        "kPa": 1e4 / MMHG,
        "Pa": 10.0 / MMHG,
        "dyn/cm2": 1.0 / MMHG,
        "cmH2O": 980.665 / MMHG,
        "mbar": 1e3 / MMHG,
        "hPa": 1e3 / MMHG,
    },
    "flow": {
        "ml/s": 1.0,
        "cm3/s": 1.0,
        "ul/s": 1e-3,
        "mm3/s": 1e-3,
        "ml/min": 1.0 / 60.0,
        "cm3/min": 1.0 / 60.0,
        "ul/min": 1e-3 / 60.0,
        "l/min": 1e3 / 60.0,
        "l/s": 1e3,
        "m3/s": 1e6,
    },
    "length": {"cm": 1.0, "mm": 0.1, "um": 1e-4, "m": 100.0},
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0},
    "slope": {"cm/cm": 1.0, "mm/mm": 1.0, "um/um": 1.0, "1": 1.0, "um/mm": 1e-3, "%": 0.01},
    "velocity": {"cm/s": 1.0, "mm/s": 0.1, "m/s": 100.0},
    "area": {"cm2": 1.0, "mm2": 0.01, "um2": 1e-8, "m2": 1e4},
    "voltage": {"mV": 1.0, "V": 1e3, "uV": 1e-3},
    "volume": {"ml": 1.0, "cm3": 1.0, "ul": 1e-3, "mm3": 1e-3},
    "relative volume": {"RVU": 1.0},
}

CANONICAL = {name: next(unit for unit, scale in scales.items() if scale == 1.0) for name, scales in _FACTORS.items()}
"""The unit in which vasowave holds each kind of quantity."""


def factor(unit: str, quantity: str) -> float:
    """Return the number that turns a value in `unit` into the canonical unit of `quantity`.

    Parameters
    ----------
    unit : str
        As written by people: ``mmHg``, ``µl/s``, ``dyn/cm²`` …; case and spaces do not matter.
    quantity : {"pressure", "flow", "length", "time", "slope", "velocity", "area", "voltage", "volume"}
        Or "relative volume": units of a conductance catheter that nobody has calibrated, which are no volume.

    Raises
    ------
    InputError
        If `unit` is not a unit of `quantity`.
    """
    scales, name = _FACTORS[quantity], _plain(unit)
    for written, scale in scales.items():
        if written.lower() == name:
            return scale
    hint = did_you_mean(name, scales)
    raise InputError(f"'{unit}' is not a unit of {quantity}{hint}; known: {', '.join(scales)}")


def ratios(quantity: str) -> dict[str, float]:
    """Return the units of a quantity, and what turns each into the canonical one; of a diameter those of lengths."""
    return dict(_FACTORS["length" if quantity == "diameter" else quantity])


def is_of(unit: str, quantity: str) -> bool:
    """Whether a text is a unit of a quantity; none is none."""
    try:
        factor(unit, quantity)
    except InputError:
        return False
    return bool(unit)


def is_unit(text: str) -> bool:
    """Whether a text is a unit of any quantity."""
    return any(_plain(text) == written.lower() for scales in _FACTORS.values() for written in scales)


@lru_cache(4096)
def _plain(unit: str) -> str:
    """Return `unit` in lower case, without spaces, superscripts, carets and Greek letters."""
    text = unit.strip().lower().replace(" ", "").replace("^", "").replace("**", "")
    text = text.replace("_per_", "/").replace("liters", "l").replace("liter", "l")
    for written, plain in (
        ("µ", "u"),
        ("μ", "u"),
        ("²", "2"),
        ("³", "3"),
        ("·", ""),
        ("seconds", "s"),
        ("second", "s"),
        ("millis", "ms"),
        ("secs", "s"),
        ("sec", "s"),
        ("dynes", "dyn"),
        ("volts", "v"),
        ("volt", "v"),
        ("/mn", "/min"),
    ):
        text = text.replace(written, plain)
    for written, plain in (("cc", "cm3"), ("microl", "ul"), ("microns", "um"), ("micron", "um")):
        if text.startswith(written):
            text = plain + text[len(written) :]
    return text
