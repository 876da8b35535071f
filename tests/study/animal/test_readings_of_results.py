"""Readings of a stored result by arithmetic: residuals, the cycle from its foot, answers, impedance."""

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from made_cohort import bare_law, bare_result
from made_fit import made_recording
from vasowave.base import InputError
from vasowave.pulse.cycle import Recording
from vasowave.study.animal import datasets, reading, signals


def test_the_autocorrelation_of_a_residual_is_that_of_its_cycle():
    r = np.array([1.0, -2.0, 0.5, 3.0, 1.0, -1.0])
    centered = r - r.mean()
    expected = [centered @ np.roll(centered, lag) / (centered @ centered) for lag in range(4)]
    assert reading.autocorrelation(r) == pytest.approx(expected)
    with pytest.raises(InputError, match="the residuals do not vary"):
        reading.autocorrelation(np.ones(5))
    calibration = xr.Dataset({"pressure_residual": ("time", r)})
    result = bare_result(
        recording=xr.Dataset(attrs={"period": 0.12}), laws={"linear": bare_law("linear", calibration=calibration)}
    )
    rho = reading.residual_autocorrelation(result, "linear")
    assert rho["lag"].values == pytest.approx([0, 0.02, 0.04, 0.06])
    assert rho.attrs["white_noise"] == pytest.approx(1.959964 / np.sqrt(6))


def test_a_cycle_is_turned_to_the_foot_of_its_pressure_and_closed():
    cycle = made_recording()
    recording = datasets.recording_dataset(cycle)
    result = bare_result(recording=recording)
    foot = reading.cycle_foot(cycle.pressure)
    share, pressure = reading.from_foot(result, "pressure")
    assert len(share) == 129
    assert share[0] == pytest.approx((0 - foot * 128) % 1 / 128, abs=1e-9)
    assert share[-1] == pytest.approx(share[0] + 1)
    assert pressure[0] == pressure[-1]
    first = int(np.ceil(foot * 128 - 1e-9)) % 128
    assert pressure[:-1] == pytest.approx(np.roll(cycle.pressure, -first))
    assert reading.from_foot(result, "flow")[1][:-1] == pytest.approx(np.roll(cycle.flow, -first))


def test_a_posteriors_answers_are_its_quantiles_and_others_stay_those_of_the_fit():
    draws = np.arange(1.0, 1000)[np.newaxis]
    posterior = SimpleNamespace(
        groups={"posterior": xr.Dataset({"R_T": (("chain", "draw"), draws)})}, draws=lambda name: draws
    )
    fitted = xr.Dataset({"R_T": ((), 5.0, {"units": "x", "interval_low": 0.0}), "S": 7.0})
    law = bare_law("linear", quantities=fitted, posterior=posterior)
    answer = law.answers["R_T"]
    assert (float(answer), answer.attrs["interval_low"], answer.attrs["interval_high"]) == (500.0, 25.0, 975.0)
    assert answer.attrs["units"] == "x"
    assert float(law.answers["S"]) == 7.0
    assert law.origin == "posterior under the linear wall"
    plain = bare_law("linear", quantities=fitted)
    assert float(plain.answers["R_T"]) == 5.0
    assert plain.origin == "linear wall"
    assert plain.compared == "pressure"
    assert bare_law("x", calibration=xr.Dataset(attrs={"enters": "pressure"})).compared == "flow"
    assert bare_law("x").stiffness == "stiffness"


@pytest.mark.parametrize(("samples", "asked", "last"), [(33, 50, 16), (32, 50, 15), (200, 12, 12)])
def test_an_impedance_has_the_harmonics_that_are_asked_for_or_all_that_so_many_samples_tell(samples, asked, last):
    pressure, flow = np.random.default_rng(1).uniform(0.1, 1.0, (2, samples))  # which has all harmonics
    recording = Recording(15 + pressure, flow, 0.11)
    found = signals.impedance_dataset(signals.Station(recording, 0.007, 300.0, "mean pressure"), asked, 0.0)
    assert found["harmonic"].values.tolist() == list(range(last + 1))
