"""Many starts: those that are not followed would have ended where the best one did, and other valleys are seen."""

from types import SimpleNamespace

import numpy as np
import pytest

from vasowave.calibration import starts as starting
from vasowave.calibration.compared import compared_part
from vasowave.calibration.objective import Objective
from vasowave.calibration.parameters import parameter_space
from vasowave.calibration.search import ROUGH, SearchEnd, _Jacobians, _trust_region, search
from vasowave.datasets import control_network, virtual_mouse
from vasowave.model.blood import Blood
from vasowave.model.nominal import estimate_nominal
from vasowave.solver import Numerics


def valley(residuals, x):
    """What `_joined` asks of an objective, and where its search ended."""
    here = np.array([x])
    step = np.array([1e-6])

    def jacobian(x):
        return ((residuals(x + step) - residuals(x - step)) / 2e-6)[:, np.newaxis]

    found = SearchEnd(here, float(np.sum(residuals(here) ** 2)), 5, True, "", residual=residuals(here))
    return SimpleNamespace(jacobian=jacobian), found


def test_a_start_joins_the_best_where_a_straight_line_leads_there_and_not_from_another_valley():
    """S = (x² - 1)² + (0.3 (x - 1))² has one valley at x = 1 and a higher one near x = -1."""

    def residuals(x):
        return np.array([x[0] ** 2 - 1.0, 0.3 * (x[0] - 1.0)])

    objectives, found = zip(*(valley(residuals, x) for x in (1.0, 1.1, -0.95)), strict=True)
    joined = starting._joined(objectives[0], dict(enumerate(found)), 0)
    assert list(joined) == [1]
    assert joined[1].joined
    assert joined[1].converged
    assert "need not be followed" in joined[1].message


@pytest.mark.parametrize("name", ["linear", pytest.param("tangent", marks=pytest.mark.validation)])
def test_starts_that_are_not_followed_would_have_ended_at_the_same_optimum(name, monkeypatch):
    monkeypatch.setattr(starting, "screened", lambda space, compared, starts: (list(starts), list(range(len(starts)))))
    network, mouse = control_network(), virtual_mouse()
    space = parameter_space(name, network, estimate_nominal(network, mouse), Blood(), {}, {}, False)
    compared = compared_part(mouse, "signal")
    numerics = Numerics(samples=64, tolerance=1e-6)
    points = starting.starting_points(space, 3, seed=1)
    found, stopped = starting.search_all(space, compared, numerics, points, "least-squares")
    assert not stopped
    best = min(one.S for one in found)
    followed = 0
    for point, one in zip(points, found, strict=True):
        objective = Objective(space, compared, numerics, 1, starting.threading.Event())
        end = search(objective, point, "least-squares", ROUGH)
        assert best <= (1 + starting.SAME) * end.S
        if one.joined:
            followed += 1
            assert one.simulations < end.simulations
            assert end.S == pytest.approx(best, rel=starting.SAME, abs=1e-6 * len(compared.measured))
    assert followed > 0


def test_a_start_far_above_the_best_is_left_and_says_so():
    network, mouse = control_network(), virtual_mouse()
    fixed = {"beta": 400.0}  # much too stiff: whatever the outlets are, S stays high
    space = parameter_space("linear", network, estimate_nominal(network, mouse), Blood(), {}, fixed, False)
    objective = Objective(
        space, compared_part(mouse, "signal"), Numerics(samples=64, tolerance=1e-6), 1, starting.threading.Event()
    )
    x = np.log(space.nominal[space.free])
    left = search(objective, x, "least-squares", ROUGH, enough=1e-3)
    assert left.message.startswith("far above the best optimum")
    assert not left.converged
    assert left.S == pytest.approx(float(np.sum(objective.residuals(left.x) ** 2)))


def test_a_search_goes_the_way_of_one_that_simulates_every_jacobian_and_leaves_out_the_last():
    """Residuals of a curved valley (Rosenbrock's, with a part that cannot vanish); SciPy alone asks for one more."""
    from scipy.optimize import least_squares

    asked = []

    def residuals(x):
        return np.array([10.0 * (x[1] - x[0] ** 2), 1.0 - x[0], 0.5 + 0.1 * x[0]])

    def jacobian(x):
        asked.append(x)
        return np.array([[-20.0 * x[0], 10.0], [-1.0, 0.0], [0.1, 0.0]])

    bounds = np.full(2, -5.0), np.full(2, 5.0)
    for tolerance in (1e-2, 1e-8):
        limits = {"ftol": tolerance, "xtol": tolerance, "gtol": tolerance}
        alone = least_squares(residuals, [-1.2, 1.0], jacobian, bounds=bounds, **limits)
        asked.clear()
        found = _trust_region(_Jacobians(residuals, jacobian, tolerance, np.inf), np.array([-1.2, 1.0]), bounds)
        assert np.array_equal(found.x, alone.x)
        assert (found.nfev, len(asked)) == (alone.nfev, alone.njev - 1)
