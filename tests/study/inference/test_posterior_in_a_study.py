"""The posterior of whole animals: a virtual one whose truth is known, and measured mouse C6 against a direct search."""

import numpy as np
import pytest
from scipy.stats import ks_2samp

from vasowave.catheter.read import read_recording
from vasowave.pulse.calibration import Search
from vasowave.pulse.examples import control_network, virtual_mouse
from vasowave.pulse.inference import (
    Priors,
    Sampling,
    climb,
    log_prior,
    posterior,
    problem_of,
)
from vasowave.pulse.model import Numerics

SHAPE_ONLY = Priors(radius_scale_sd=0, length_scale_sd=0, k_sd=0, flow_gain_sd=0, taper_sd=0)
"""Parameters alone are drawn; the vessels' own errors are part of the likelihood."""


@pytest.fixture(scope="module")
def found():
    coarse, few = Numerics(cell_size=0.4, samples=128), Search(pressure_harmonics=16)
    return posterior(control_network(), virtual_mouse(), draws=100, numerics=coarse, search=few)


@pytest.mark.weekly
def test_the_posterior_of_mouse_c6_is_that_of_a_direct_search(shared):
    """emcee with every step simulated: no emulator, no weights; some 6 400 simulations."""
    emcee = pytest.importorskip("emcee")
    folder = shared / "mouse-c6"
    mouse = read_recording(folder / "pC6_1024.dat", folder / "qC6_1024.dat", period=0.11)
    found = posterior(control_network(), mouse, priors=SHAPE_ONLY)
    assert found.diagnostics.trusted
    problem = problem_of(control_network(), mouse, "linear", Sampling(priors=SHAPE_ONLY))
    climbed = climb(problem.simulate, problem.measured, problem.discrepancy(), np.zeros(4))
    noise = problem.discrepancy(problem.vessels(climbed.middle))

    def density(points):
        outputs = problem.simulate(points)
        values = np.full(len(points), -np.inf)
        good = np.isfinite(outputs).all(axis=1)
        values[good] = noise.log_likelihood(problem.measured - outputs[good]) + log_prior(points[good])
        return values

    direct = emcee.EnsembleSampler(32, 4, density, vectorize=True)
    direct.random_state = np.random.RandomState(1).get_state()
    begin = climbed.middle + np.random.default_rng(2).standard_normal((32, 4)) @ climbed.root.T
    direct.run_mcmc(begin, 200)
    chain = direct.get_chain(discard=60, thin=35, flat=True)  # about one autocorrelation time apart
    for i, name in enumerate(problem.unknowns.all):
        theirs = problem.unknowns.all[name].value(chain[:, i])
        ours = np.unique(found.draws(name))
        assert ks_2samp(ours, theirs).pvalue > 0.01, name
