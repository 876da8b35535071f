"""What a fit foretells of a change, against the change of the model that made the recording."""

import numpy as np
import pytest

import vasowave as vw
from vasowave.pulse.calibration import calibrate
from vasowave.pulse.model import with_parameters


def truth(seed):
    """A model, its waves and a noisy recording of them."""
    random, network, mouse = np.random.default_rng(seed), vw.control_network(), vw.virtual_mouse()
    outlets = vw.estimate_nominal(network, mouse).outlets.scaled(*np.exp(random.normal(0, 0.3, 3)))
    model = vw.Model(network, vw.LinearWall(random.uniform(30, 110)), outlets)
    waves = vw.simulate(model, mouse)
    inlet = waves.sel(vessel=network.name[network.root], station="inlet")
    smooth = np.convolve(np.tile(random.normal(size=512), 3), np.hanning(40), "same")[512:1024]
    noise = 0.15 * (smooth - smooth.mean()) / smooth.std()
    return model, inlet, vw.Recording(inlet.pressure.values + noise, mouse.flow, mouse.period)


def mean_and_pulse(model, flow, period):
    waves = vw.simulate(model, vw.Inflow(flow, period))
    pressure = waves.pressure.sel(vessel=model.network.name[model.network.root], station="inlet").values
    return pressure.mean(), np.ptp(pressure)


CHANGES = ({"R_T": 0.7}, {"beta": 1.6}, {"HR": 1.25})


def foretold_and_true(seed, change):
    """Return the table of a change that a fit foretells, and the change of mean and pulse of what it was fitted to."""
    model, inlet, recording = truth(seed)
    fit = calibrate(model.network, recording, search=vw.Search(starts=2))
    beds = dict.fromkeys(("r1", "r2"), change.get("R_T", 1.0))
    changed = with_parameters(model, {"beta": change.get("beta", 1.0) * float(np.mean(model.wall.beta)), **beds})
    before = mean_and_pulse(model, inlet.flow.values, recording.period)
    after = mean_and_pulse(changed, inlet.flow.values, recording.period / change.get("HR", 1.0))
    return vw.predict(fit, change, draws=12).table, dict(zip(("mPAP", "pPAP"), np.subtract(after, before), strict=True))


@pytest.mark.parametrize("change", CHANGES)
def test_the_change_is_that_of_the_model_that_made_the_recording(change):
    table, true = foretold_and_true(3, change)
    for name, difference in true.items():
        assert table.loc[name, "change_low"] <= difference <= table.loc[name, "change_high"]
        assert table.loc[name, "change"] == pytest.approx(difference, abs=0.05 * max(abs(difference), 1.0))


@pytest.mark.validation
def test_of_twenty_animals_the_intervals_hold_the_true_change_in_eighteen_or_more():
    held = []
    for number in range(20):
        table, true = foretold_and_true(100 + number, CHANGES[number % len(CHANGES)])
        held.append([table.loc[name, "change_low"] <= true[name] <= table.loc[name, "change_high"] for name in true])
    assert min(np.sum(held, axis=0)) >= 18, np.sum(held, axis=0)


def test_a_band_and_more_output_are_foretold_and_what_was_held_is_told():
    fit = calibrate(vw.control_network(), vw.virtual_mouse(), search=vw.Search(starts=1))
    banded = vw.predict(fit, {}, remodel=lambda model: vw.narrowed(model, "2", 0.7, 0.05), draws=4)
    assert banded.table.loc["sPAP", "after"] > banded.table.loc["sPAP", "before"]
    more = vw.predict(fit, {"CO": 1.3}, draws=4)
    assert more.table.loc["CO", "after"] == pytest.approx(1.3 * more.table.loc["CO", "before"])
    assert any("regulates" in text for text in more.assumptions)
    assert "CO × 1.3" in repr(more)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"bta": 2.0}, "did you mean 'beta'"),
        ({"beta": -1.0}, "positive factor"),
        ({"HR": np.nan}, "positive factor"),
        ({"R_T": 70.0}, "0.7 for 70 %"),
        ({"HR": 577.0}, "from 0.25 to 4"),
        ({"R_T": 1.0}, "nothing is changed"),
    ],
)
def test_what_cannot_be_changed_is_refused(change, message):
    fit = calibrate(vw.control_network(), vw.virtual_mouse(), search=vw.Search(starts=1))
    with pytest.raises(vw.errors.InputError, match=message):
        vw.predict(fit, change, draws=2)


def test_a_change_of_nothing_is_refused_with_what_can_be_changed():
    fit = calibrate(vw.control_network(), vw.virtual_mouse(), search=vw.Search(starts=1))
    with pytest.raises(vw.errors.InputError, match=r"nothing is changed; there are: beta, r1, r2, c1, R_T.*HR, CO"):
        vw.predict(fit, {}, draws=2)
    with pytest.raises(vw.errors.InputError, match="a fit is needed"):
        vw.predict(fit.model, {"R_T": 0.5})


TUBE = vw.Network(("1",), [-1], [0.4], [0.05])
SEARCH = vw.Search(starts=1, fixed={"r1": 1.0, "r2": 1.0, "c1": 1.0})


@pytest.mark.parametrize(
    ("numerics", "tolerance"),
    [(vw.Numerics(cycles_from_rest=3, steps_per_cycle=4096), 1e-12), (vw.Numerics(cell_size=0.2), 1e-6)],
)
def test_a_fit_with_other_numerics_foretells_its_own_unchanged_state(numerics, tolerance):
    fit = calibrate(TUBE, vw.virtual_mouse(), search=SEARCH, numerics=numerics)
    fitted = fit.simulation["pressure"].to_numpy()
    usual = vw.simulate(fit.model, vw.virtual_mouse())["pressure"].to_numpy()
    assert abs(usual - fitted).max() > 1e-4
    foretold = vw.predict(fit, {"beta": 1.5}, draws=0)
    assert abs(foretold.before["pressure"].to_numpy() - fitted).max() <= tolerance
    same = vw.attribute_change(fit.model, fit.model, (fit.recording, fit.recording), fit.numerics).table
    assert same.loc["mPAP", "before"] == pytest.approx(foretold.table.loc["mPAP", "before"], abs=tolerance)
    answer = vw.emulate(fit, factors={"beta": 1.1})({})["mPAP"].item()
    assert answer == pytest.approx(foretold.table.loc["mPAP", "before"], abs=1e-4)
