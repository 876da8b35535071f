"""What a user of a notebook types works on every value, or says what to type instead."""

import numpy as np
import pandas as pd
import pytest

import vasowave as vw
from vasowave.catheter import synthetic_raw_recording


@pytest.fixture(scope="module")
def network():
    return vw.Network(("MPA", "LPA", "RPA"), [-1, 0, 0], [0.4, 0.4, 0.5], [0.05, 0.035, 0.04])


@pytest.fixture(scope="module")
def mouse():
    return vw.virtual_mouse()


@pytest.fixture(scope="module")
def raw(mouse):
    return synthetic_raw_recording(mouse, np.random.default_rng(3), duration=6.0).raw


@pytest.fixture(scope="module")
def fit(network, mouse):
    return vw.calibrate(network, mouse, starts=1)


def test_a_network_draws_itself_and_becomes_a_table_that_is_its_file(network, tmp_path):
    assert len(network.plot().texts) >= len(network)
    table = network.to_dataframe()
    assert list(table.index) == list(network.name)
    assert table["length [cm]"].sum() == network.length.sum()
    table.reset_index(names="name").to_csv(tmp_path / "lung.csv", index=False)
    again = vw.read_network(tmp_path / "lung.csv")
    assert again.name == network.name
    assert np.array_equal(again.parent, network.parent)
    assert np.array_equal(again.radius, network.radius)


def test_a_cycle_draws_itself_and_becomes_labelled_data(mouse):
    pressure, flow = mouse.plot()
    assert pressure.lines[0].get_ydata()[:-1] == pytest.approx(mouse.pressure)
    assert flow.get_xlabel() == "time [s]"
    assert flow.get_xlim() == (0.0, mouse.period)
    dataset, table = mouse.to_dataset(), mouse.to_dataframe()
    assert dataset["pressure"].attrs["units"] == "mmHg"
    assert np.array_equal(dataset["pressure"], mouse.pressure)
    assert table["pressure [mmHg]"].mean() == pytest.approx(mouse.mean_pressure, rel=1e-12)
    assert table["flow [ml/s]"].mean() == pytest.approx(mouse.cardiac_output, rel=1e-12)


def test_a_raw_recording_draws_a_stretch_and_averages_its_beats(raw):
    axes = raw.plot(slice(2, 3))
    assert len(axes) == 3
    assert axes[0].get_xlim() == (2.0, 3.0)
    shown = axes[0].lines[0].get_ydata()
    inside = raw.pressure[(raw.time >= 2) & (raw.time <= 3)]
    assert (shown.min(), shown.max()) == (inside.min(), inside.max())
    average = raw.average(10, samples=128)
    assert np.array_equal(average.recording.pressure, vw.average_beats(raw, 10, samples=128).recording.pressure)
    assert average.findings == average.recording.notes
    bands = [band.get_paths()[0].vertices[:, 1] for band in average.plot()[0].collections]
    assert bands[0].max() == pytest.approx((average.recording.pressure + average.pressure_sd).max())


def test_an_average_serves_as_a_cycle_and_a_slip_among_keywords_is_named(network, mouse, fit, raw):
    average = raw.average(10)
    assert vw.calibrate(network, average, starts=1, pressure_harmonics=8).recording is average.recording
    named = vw.calibrate(network, mouse, search=vw.Search(starts=1))
    assert fit.parameters["value"].equals(named.parameters["value"])
    with pytest.raises(vw.errors.InputError, match=r"no setting 'start'.*'starts'"):
        vw.calibrate(network, mouse, start=4)


def test_a_fit_sums_itself_up_stores_itself_and_simulates(fit, mouse, tmp_path):
    import xarray as xr

    table = fit.summary()
    assert table.loc["R_T", "value"] == pytest.approx(fit.total_resistance)
    assert table.loc["wave_speed", "low"] < table.loc["wave_speed", "value"]
    assert table.loc["beta", "value"] == pytest.approx(fit.parameters.loc["beta", "value"])
    with pd.option_context("display.width", 80, "display.max_columns", 0):
        title, *_ = str(table).split("\n")
    assert title.split() == ["value", "low", "high", "unit"]  # on a terminal, too
    stored = xr.open_datatree(fit.to_netcdf(tmp_path / "fit.nc"))
    assert float(stored["linear/quantities/R_T"]) == table.loc["R_T", "value"]
    stored.close()
    again = fit.model.simulate(mouse)
    first = again["pressure"].sel(vessel=fit.model.network.name[0], station="inlet")
    assert abs(float(first.mean()) - mouse.mean_pressure) < 1.0


@pytest.mark.validation
def test_a_fit_is_sampled_with_what_it_held_held(mouse):
    trunk = vw.Network(("trunk",), [-1], [0.4], [0.045])
    few = mouse.resampled(64)  # few harmonics, which a posterior costs
    held = vw.calibrate(trunk, few, starts=1, fixed={"c1": 1.0, "r1": 1.0})
    drawn = held.sample(draws=40, priors=vw.Priors(radius=0, length=0, flow_gain_sd=0))  # a gain would mend the model
    assert "c1" not in drawn.summary.index
    assert drawn.to_datatree()["posterior"].sizes["draw"] > 0
    low, high = drawn.summary.loc["R_T", ["interval_low", "interval_high"]]
    assert low < held.total_resistance < high


@pytest.mark.parametrize("door", [vw.calibrate, vw.posterior])
def test_what_is_not_a_cycle_or_a_network_is_said_in_words(door, network, mouse, raw):
    with pytest.raises(vw.errors.InputError, match=r"raw\.average\(\)"):
        door(network, raw)
    with pytest.raises(vw.errors.InputError, match=r"'lung\.csv' is the name of a file; read it first"):
        door("lung.csv", mouse)
    with pytest.raises(vw.errors.InputError, match="ndarray was given where a Recording is needed"):
        door(network, mouse.pressure)
