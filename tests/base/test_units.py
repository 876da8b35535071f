"""Every unit against its definition, written out by hand."""

import pytest

from vasowave.base import CANONICAL, MMHG, InputError, factor

DEFINITIONS = {
    "pressure": {
        "mmHg": 1.0, "Torr": 1.0, "kPa": 7.500638, "Pa": 7.500638e-3, "dyn/cm²": 7.500638e-4, "dynes/cm^2": 7.500638e-4,
        "cmH2O": 0.735561, "cm H2O": 0.735561, "mbar": 0.7500638, "hPa": 0.7500638, "mm Hg": 1.0,
    },
    "flow": {
        "ml/s": 1.0, "cc/s": 1.0, "cm³/s": 1.0, "µl/s": 1e-3, "μL/sec": 1e-3, "microl/s": 1e-3, "mm3/s": 1e-3,
        "ml/min": 0.0166667, "ul/min": 1.66667e-5, "l/min": 16.66667, "L/s": 1000.0, "m³/s": 1e6,
    },
    "length": {"cm": 1.0, "mm": 0.1, "µm": 1e-4, "micron": 1e-4, "m": 100.0},
    "time": {"s": 1.0, "sec": 1.0, "ms": 1e-3, "µs": 1e-6, "min": 60.0},
    "voltage": {"mV": 1.0, "V": 1000.0, "µV": 1e-3},
    "slope": {"cm/cm": 1.0, "um/um": 1.0, "1": 1.0, "um/mm": 1e-3, "%": 0.01},
    "velocity": {"cm/s": 1.0, "mm/s": 0.1, "m/s": 100.0},
    "area": {"cm2": 1.0, "mm²": 0.01, "um2": 1e-8, "m2": 1e4},
}  # fmt: skip


@pytest.mark.parametrize(
    ("unit", "quantity", "expected"), [(u, q, x) for q, known in DEFINITIONS.items() for u, x in known.items()]
)
def test_a_unit_is_what_it_is_defined_to_be(unit, quantity, expected):
    assert factor(unit, quantity) == pytest.approx(expected, rel=2e-6)


@pytest.mark.parametrize("quantity", list(CANONICAL))
def test_the_canonical_unit_of_a_quantity_is_one(quantity):
    assert factor(CANONICAL[quantity], quantity) == 1.0


def test_one_mmhg_is_the_pressure_of_a_millimeter_of_mercury():
    density, gravity = 13.5951, 980.665  # g/cm³, cm/s²
    assert pytest.approx(0.1 * density * gravity, rel=1e-4) == MMHG


def test_a_unit_of_another_quantity_is_refused_with_the_known_ones():
    with pytest.raises(InputError, match=r"'ml/s' is not a unit of pressure.*known: mmHg"):
        factor("ml/s", "pressure")
    with pytest.raises(InputError, match=r"did you mean 'kPa'"):
        factor("kPaa", "pressure")
