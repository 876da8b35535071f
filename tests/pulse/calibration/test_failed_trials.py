"""A trial point that cannot be is a failed point of its search; a start or a law that fails leaves the others."""

import numpy as np
import pytest

from own_laws import Broken
from small_tree import SMALL
from vasowave.base import NumericalError
from vasowave.pulse.calibration import Coordinates, Search, calibrate, parameter_space
from vasowave.pulse.examples import control_network, virtual_mouse
from vasowave.pulse.model import LAWS, Blood, Numerics, estimate_nominal, find_law

FAST = Numerics(cell_size=0.3, tolerance=1e-6)


EDGY = '''
from typing import NamedTuple
import numpy as np
from vasowave.base.descriptions import Law, Parameter
from vasowave.pulse.model.walls import LinearWall

class Edgy(NamedTuple):
    """The linear wall, whose equations raise errors of three kinds out of its range of stiffness."""

    beta: float

    @staticmethod
    def law():
        beta = Parameter("mmHg", "β", "stiffness", "", 1.0, (0.01, 20.0))
        return Law("edgy", "edgy", "p = β (√(A/A₀) − 1)", "3", (beta,), "beta")

    pressure_at = staticmethod(LinearWall.pressure_at)
    ratio_at = staticmethod(LinearWall.ratio_at)
    slope_at = staticmethod(LinearWall.slope_at)

    @staticmethod
    def limits(beta):
        least, worst = np.min(beta), np.max(beta)
        if least < 27.0:  # a start in five
            raise ValueError("too soft")
        if worst > 70.0:
            raise OverflowError("too stiff") if worst < 140.0 else FloatingPointError("far too stiff")
        return LinearWall.limits(beta)
'''


@pytest.fixture(scope="module")
def mouse():
    return virtual_mouse()


@pytest.fixture
def edgy(tmp_path, monkeypatch):
    """Return the law in a file of its own: what is compiled of such a law is kept."""
    (tmp_path / "edgy_laws.py").write_text(EDGY, "utf-8")
    monkeypatch.chdir(tmp_path)
    return find_law("edgy_laws:Edgy")


@pytest.mark.parametrize("wall", LAWS)
def test_every_place_between_the_bounds_of_the_coordinates_has_parameters(wall, mouse):
    """A step beyond the pole of the tangent law has none in the logarithm of the strain."""
    network = control_network()
    space = parameter_space(wall, network, estimate_nominal(network, mouse), Blood())
    there = Coordinates(space, mouse.mean_pressure)
    low, high = there.bounds
    z = np.random.default_rng(1).uniform(low, high, (2000, len(low)))
    x = np.array([there.logarithms(one) for one in z])
    assert np.isfinite(x).all()
    slopes = np.array([there.slopes(one) for one in z[:200]])
    assert np.isfinite(slopes).all()


@pytest.mark.validation
@pytest.mark.parametrize("method", ["least-squares", "sqp"])
def test_a_law_that_raises_errors_beside_the_way_is_fitted_as_one_that_does_not(method, mouse, edgy):
    search = Search(starts=1, method=method)
    rough, linear = (calibrate(SMALL, mouse, w, search=search, numerics=FAST) for w in (edgy, "linear"))
    np.testing.assert_allclose(rough.parameters["value"], linear.parameters["value"], rtol=2e-3)


@pytest.mark.validation
def test_a_start_that_cannot_be_is_a_failed_start_with_its_reason(mouse, edgy):
    fit = calibrate(SMALL, mouse, edgy, search=Search(starts=6, seed=4, method="sqp"), numerics=FAST)
    failed = fit.starts[~np.isfinite(fit.starts["S [mmHg2]"])]
    assert 0 < len(failed) < 6
    assert failed["message"].str.contains("the start cannot be simulated: .*too (?:soft|stiff)").all()
    assert not failed["converged"].any()
    assert fit.rmse < 1.0


def test_a_law_of_which_no_start_can_be_is_an_error_with_the_reason(mouse):
    with pytest.raises(NumericalError, match=r"no start of the fit could be simulated.*ZeroDivisionError: by nothing"):
        calibrate(control_network(), mouse, Broken, search=Search(starts=2), numerics=FAST)
