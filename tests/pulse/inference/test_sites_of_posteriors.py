"""Posteriors of an animal that was observed at two sites."""

import numpy as np
import pytest

import vasowave as vw
from vasowave.pulse.cycle import resample
from vasowave.pulse.inference import Sampling, problem_of
from vasowave.pulse.noise import fourier

NETWORK = vw.Network(("a", "b", "c"), [-1, 0, 0], [0.75, 0.55, 0.35], [0.047, 0.037, 0.026])
MOUSE = vw.virtual_mouse()
SITE = vw.Observation("flow", "b", 0.005, waveform=0.6 * MOUSE.flow, gain_sd=0.0)


def problem(**more):
    priors = vw.Priors(radius=0, length=0, length_scale_sd=0, k_sd=0)
    return problem_of(NETWORK, MOUSE, "linear", Sampling(priors=priors, **more))


def test_outputs_are_those_of_the_inlet_and_then_those_of_the_sites():
    one, both = problem(), problem(sites=(SITE,))
    point = np.zeros((1, len(one.unknowns.all)))
    alone, together = one.simulate(point)[0], both.simulate(point)[0]
    np.testing.assert_allclose(together[: one.samples], alone)
    scaled = both.sites.scales[0] * fourier(resample(SITE.waveform, one.samples))
    np.testing.assert_allclose(both.measured[one.samples :], scaled)
    near = both.linear(point)[0][one.samples :]
    there = together[one.samples :]
    assert there[0] == pytest.approx(near[0], rel=0.01)
    assert np.linalg.norm(there - near) < 0.15 * np.linalg.norm(near)  # 9 % are what is not linear in the waves
    assert one.key != both.key


def test_what_was_kept_of_one_site_is_not_taken_for_another():
    sites = [
        vw.Observation("flow", "b", 0.005, mean=0.08), vw.Observation("flow", "b", 5.0, mean=80.0),
        vw.Observation("velocity", "b", 0.005, mean=0.08), vw.Observation("pressure", "b", 0.5, systolic=20.0),
        vw.Observation("pressure", "b", 0.5, diastolic=20.0),
    ]  # fmt: skip
    assert len({problem(sites=(site,)).key for site in sites}) == len(sites)


def test_a_site_far_from_all_models_costs_likelihood_and_one_whose_error_is_endless_costs_none():
    point = np.zeros((1, len(problem().unknowns.all)))

    def gap(site):
        whole, alone = (problem(sites=sites, search=vw.Search(pressure_harmonics=8)) for sites in ((site,), ()))
        one = whole.discrepancy().log_likelihood(whole.measured - whole.simulate(point)[0])
        here = whole.measured.copy()
        here[alone.samples :] = whole.simulate(point)[0][alone.samples :]
        return one - whole.discrepancy().log_likelihood(here - whole.simulate(point)[0])

    far = vw.Observation("flow", "b", 0.005, waveform=3 * MOUSE.flow, gain_sd=0.0)
    vague = vw.Observation("flow", "b", 1e4, waveform=3 * MOUSE.flow, gain_sd=0.0)
    assert gap(far) < -20
    assert gap(vague) == pytest.approx(0, abs=0.01)


def test_the_mean_of_a_pressure_counts_as_little_as_its_zero_is_known():
    wave = MOUSE.pressure - 0.5
    sure, unsure = (problem(sites=(vw.Observation("pressure", "b", 0.05, waveform=wave, zero_sd=sd),)) for sd in (0, 1))
    apart = unsure.sites.covariance - sure.sites.covariance
    assert apart[0, 0] == pytest.approx(unsure.samples * unsure.sites.scales[0] ** 2)
    assert np.count_nonzero(apart) == 1
