"""Parts of a model at their limits: the last value that is taken, and the first that is refused."""

from dataclasses import replace

import numpy as np
import pytest

import vasowave as vw
from vasowave.datasets import control_network
from vasowave.errors import InputError
from vasowave.model.outlets import ReflectionCoefficient
from vasowave.model.ventricle import LEAST_SAMPLES

NETWORK = control_network()


@pytest.fixture(scope="module")
def model():
    nominal = vw.estimate_nominal(NETWORK, vw.virtual_mouse())
    return vw.Model(NETWORK, vw.LinearWall(57.0), nominal.outlets)


def test_a_narrowing_leaves_what_it_says_before_and_beyond_it(model):
    whole = float(NETWORK.length[1])
    found = vw.narrowed(model, "2", area_lost=0.75, length=0.2 * whole, place=0.3).network
    rows = [found.name.index(name) for name in ("2", "2 narrow", "2 beyond")]
    assert found.length[rows] == pytest.approx(whole * np.array([0.2, 0.2, 0.6]))
    assert found.radius[rows] == pytest.approx(NETWORK.radius[1] * np.array([1.0, 0.5, 1.0]))


@pytest.mark.parametrize("value", [-1.0, 1.0, 1.01])
def test_a_reflection_coefficient_lies_between_its_ends(value):
    with pytest.raises(InputError, match=rf"vessel 'b': R_t = {value:g}; it lies between"):
        ReflectionCoefficient(np.array([9.0, 9.0]), np.array([0.5, value])).checked(("a", "b"))
    ReflectionCoefficient(np.array([9.0, 9.0]), np.array([0.999, -0.999])).checked(("a", "b"))


def test_a_reflection_coefficient_is_what_a_resistance_reflects():
    beds = ReflectionCoefficient(np.array([10.0]), np.array([0.5]))
    assert beds.circuit().proximal == pytest.approx([30.0])
    assert beds.scaled(2.0).R_t == pytest.approx([(60 - 10) / 70])
    assert beds.with_totals(np.ones(1), {"R_T": 90.0}).R_t == pytest.approx([0.8])


def test_a_spectrum_needs_two_harmonics_a_positive_resistance_and_no_source():
    good = vw.Windkessel([20.0], [130.0], [1e-3]).impedance(2 * np.pi / 0.11 * np.arange(12))
    vw.ImpedanceSpectrum(good).checked(("a",))
    for wrong, said in ((good[:1], "it must be"), (good[:, :0], "it must be"), (-good, "not positive")):
        with pytest.raises(InputError, match=said):
            vw.ImpedanceSpectrum(wrong).checked(("a",))
    zero, source = good.copy(), good.copy()
    zero[0], source[-1] = 0.0, -1.0 + 0j
    for wrong in (zero, source):
        with pytest.raises(InputError, match="vessel 'a': its impedance is not finite, or its resistance"):
            vw.ImpedanceSpectrum(wrong).checked(("a",))


def test_elastances_are_rows_of_positive_numbers_long_enough():
    given = {"period": 0.11, "filling_pressure": 3.0, "valve_resistance": 2.0}
    vw.Ventricle(np.ones(LEAST_SAMPLES), **given)
    for wrong in (np.ones(LEAST_SAMPLES - 1), np.zeros(LEAST_SAMPLES)):
        with pytest.raises(InputError, match="elastance of a ventricle"):
            vw.Ventricle(wrong, **given)
    for name in given:
        with pytest.raises(InputError, match=f"the {name} of a ventricle is 0"):
            vw.Ventricle(np.ones(LEAST_SAMPLES), **{**given, name: 0.0})


def test_a_row_of_a_shape_is_positive():
    shape = vw.Shape(radius=np.full((1, 3), 1.0))
    assert replace(shape, radius=1e-9 + np.zeros((1, 3))) is not None
    for wrong in (np.zeros((1, 3)), np.ones((0, 3)), np.full((1, 3), np.nan)):
        with pytest.raises(InputError):
            vw.Shape(radius=wrong)
