"""Models drawn from the errors of a fit: as wide as these say, together as these say, inside the bounds."""

import numpy as np
import pytest
import xarray as xr

import vasowave as vw
from vasowave.pulse.examples import control_network
from vasowave.pulse.model import windkessels
from vasowave.workbench import models_around, parameters_of, total_of

NAMES = ("beta", "r1", "r2", "c1")


@pytest.fixture(scope="module")
def model():
    network = control_network()
    return vw.Model(network, vw.LinearWall(57.0), windkessels(network, 76.0, 0.11, a=0.12))


def a_fit(errors, at_bound=(), room=1e3):
    """Return what a fit says: values 57, 0.5, 1.1, 0.9 with relative errors and one positive definite correlation."""
    value = np.array([57.0, 0.5, 1.1, 0.9])
    root = np.array([[1.0, 0, 0, 0], [0.5, 1, 0, 0], [-0.6, 0.3, 1, 0], [0.2, -0.7, 0.4, 1]])
    correlation = root @ root.T
    scale = np.sqrt(np.diag(correlation))
    return xr.Dataset(
        {
            "value": ("parameter", value),
            "lower": ("parameter", value / room),
            "upper": ("parameter", value * room),
            "standard_error_correlated": ("parameter", value * np.asarray(errors)),
            "at_bound": ("parameter", np.isin(NAMES, at_bound)),
            "correlation": (("free_parameter", "of"), correlation / np.outer(scale, scale)),
        },
        coords={"parameter": list(NAMES), "free_parameter": list(NAMES)},
    )


def factors(drawn, model):
    """Return the logarithms by which wall and beds of models differ from the first."""

    def parts(one):
        beds = one.outlets
        return np.array([np.ravel(value)[0] for value in (one.wall.beta, beds.R1, beds.R2, beds.C)])

    return np.array([np.log(parts(one) / parts(model)) for one in drawn])


def test_distances_of_the_models_in_the_errors_metric_are_those_of_independent_normals(model):
    """Whatever root of the covariance is taken, z' z is what C⁻¹ measures."""
    errors = np.array([0.1, 0.2, 0.05, 0.15])
    fit = a_fit(errors)
    moved = factors(models_around(model, fit), model)
    covariance = fit["correlation"].values * np.outer(errors, errors)
    distances = np.einsum("di,ij,dj->d", moved, np.linalg.inv(covariance), moved)
    normal = np.random.default_rng(0).standard_normal((40, 4))
    np.testing.assert_allclose(distances, (normal**2).sum(axis=1), rtol=1e-8)


def test_a_parameter_at_its_bound_stays_there_and_the_others_are_drawn_given_that(model):
    """The conditional covariance is the inverse of a part of the precision, which the program does not use."""
    errors = np.array([0.1, 0.2, 0.05, 0.15])
    fit = a_fit(errors, at_bound=("r2",))
    moved = factors(models_around(model, fit), model)
    assert not moved[:, 2].any()
    loose = [0, 1, 3]
    precision = np.linalg.inv(fit["correlation"].values * np.outer(errors, errors))[np.ix_(loose, loose)]
    distances = np.einsum("di,ij,dj->d", moved[:, loose], precision, moved[:, loose])
    normal = np.random.default_rng(0).standard_normal((40, 3))
    np.testing.assert_allclose(distances, (normal**2).sum(axis=1), rtol=1e-8)


def test_models_stay_between_the_bounds_and_unknown_errors_draw_none(model):
    moved = factors(models_around(model, a_fit([0.5, 0.5, 0.5, 0.5], room=1.2)), model)
    assert moved.max() == pytest.approx(np.log(1.2))
    assert moved.min() == pytest.approx(-np.log(1.2))
    assert models_around(model, a_fit([0.1, np.nan, 0.1, 0.1])) == []
    assert models_around(model, a_fit([0.1] * 4, at_bound=NAMES)) == []
    assert models_around(model, a_fit([0.1] * 4).drop_vars("correlation")) == []


def test_what_sliders_show_of_beds_is_what_these_were_made_of(model):
    shown = parameters_of(model)
    assert shown == pytest.approx({"beta": 57.0, "R_T": 76.0, "a": 0.12, "tau": 0.11})
    assert total_of(model.outlets, "tau") == pytest.approx(0.11)
