"""The posterior of whole animals: a virtual one whose truth is known, and measured mouse C6 against a direct search."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from made_fit import made_fit
from small_tree import SMALL
from vasowave.base import InputError
from vasowave.pulse.calibration import Search
from vasowave.pulse.cycle import resample
from vasowave.pulse.examples import TRUTH, control_network, virtual_mouse
from vasowave.pulse.inference import (
    SOURCES,
    Priors,
    Unknown,
    meanings,
    posterior,
    zero_unseen,
)
from vasowave.pulse.model import Numerics

SHAPE_ONLY = Priors(radius_scale_sd=0, length_scale_sd=0, k_sd=0, flow_gain_sd=0, taper_sd=0)
"""Parameters alone are drawn; the vessels' own errors are part of the likelihood."""
COARSE, FEW = Numerics(cell_size=0.4, samples=128), Search(pressure_harmonics=16)


@pytest.fixture(scope="module")
def found():
    return posterior(control_network(), virtual_mouse(), draws=100, numerics=COARSE, search=FEW)


def test_intervals_of_a_virtual_mouse_hold_the_truth(found):
    table = found.summary
    for name in ("beta", "R_T", "a"):
        assert table.loc[name, "interval_low"] < TRUTH[name] < table.loc[name, "interval_high"]


def test_what_geometry_leaves_open_is_said_to_come_from_the_image(found):
    assert found.summary.loc["wave_speed", "image"] > 0.5
    (mostly,) = [one for one in found.findings if one.code == "posterior.mostly-image"]
    assert "wave_speed" in dict(mostly.values)["names"]


def test_a_scale_of_all_lengths_that_the_data_do_not_see_keeps_its_prior(found):
    row = found.summary.loc["length_scale"]
    assert row["contraction"] < 0.6  # 0.2 on average of eleven seeds, scattering by 0.15 as a hundred draws do
    assert row["median"] == pytest.approx(1.0, abs=0.03)
    assert found.summary.loc["R_T", "contraction"] > 0.95  # the data see that one


def test_shares_add_up_for_every_quantity(found):
    shares = found.summary[[*SOURCES]].dropna()
    assert shares.sum(axis=1).to_numpy() == pytest.approx(1.0)
    assert list(found.summary.index.difference(shares.index)) == ["discrepancy"]


def test_predictions_go_through_the_measured_pressure(found):
    predicted, measured = found.data["posterior_predictive"]["simulated"], found.data["observed_data"]["pressure"]
    assert predicted.dims == ("chain", "draw", "time")
    distance = (predicted.mean(("chain", "draw")) - measured).to_numpy()
    assert np.sqrt(np.mean(distance**2)) < 0.5  # noise of 0.15 mmHg, and a free mean
    beyond = resample(virtual_mouse(noise=0.0).pressure, len(distance)) - measured.to_numpy()
    assert np.corrcoef(distance, beyond)[0, 1] > 0.5  # what the model leaves is the noise, not its mirror image


def test_predicted_recordings_scatter_by_more_than_the_simulations_and_hold_the_measured_one(found):
    predicted = found.data["posterior_predictive"]
    again, simulated = (predicted[name].to_numpy()[0] for name in ("pressure", "simulated"))
    assert np.all(again.std(axis=0) > simulated.std(axis=0))
    low, high = np.quantile(again, (0.005, 0.995), axis=0)
    measured = found.data["observed_data"]["pressure"].to_numpy()
    assert np.mean((low < measured) & (measured < high)) > 0.95


def test_the_measured_mean_has_the_error_of_its_zero_and_the_model_its_waves(found):
    mouse, table = virtual_mouse(), found.summary
    low, middle, high = table.loc["mPAP", ["interval_low", "median", "interval_high"]]
    assert (high - low) / 2 == pytest.approx(1.96 * 0.5, rel=0.25)  # of a hundred draws
    assert middle == pytest.approx(mouse.mean_pressure, abs=0.2)
    assert table.loc["mPAP", "calibration"] > 0.95  # nothing else tells of it, but the priors of the beds, hardly
    assert np.log(found.draws("CO")).std() == pytest.approx(0.05, rel=0.25)  # as probes are usually wrong
    assert table.loc["CO", "probe"] > 0.9  # priors of the beds tell of it, too
    np.testing.assert_allclose(found.draws("PVR"), found.draws("mPAP") / found.draws("CO"))
    assert 0 < table.loc["I_R", "interval_low"] < table.loc["I_R", "interval_high"] < 1
    # τ is R_T C_T, of which the beds have most
    assert np.corrcoef(found.draws("tau"), found.draws("R_T") * found.draws("C_p"))[0, 1] > 0.5


def test_arviz_reads_the_file(found, tmp_path):
    arviz = pytest.importorskip("arviz_base")
    tree = arviz.convert_to_datatree(str(found.to_netcdf(tmp_path / "draws.nc")))
    assert {"prior", "sample_stats", "posterior_predictive", "observed_data"} <= set(tree.children)
    assert tree["posterior"]["beta"].attrs["units"] == "mmHg"
    beta = arviz.extract(tree, var_names="beta")  # its own stacking of chains and draws
    assert sorted(beta.to_numpy()) == sorted(found.draws("beta"))
    assert arviz.extract(tree, group="prior", var_names="beta").sizes["sample"] > 100


def test_an_averaged_cycle_is_said_not_to_show_its_zero(found):
    mouse = virtual_mouse()
    said = [str(one) for one in found.findings if one.code == "posterior.zero-unseen"]
    assert len(said) == 1
    assert "within 1 mmHg" in said[0]  # two SD of the default
    share = (mouse.mean_pressure + 1) / mouse.mean_pressure - 1  # of a resistance, at the same flow
    assert f"moves R_T by {100 * share:.0f} %" in said[0]
    looked_at = replace(mouse, pressure_error=np.full(17, 0.01))  # as of beats, whose drift is looked at
    assert zero_unseen(looked_at, 0.5) == []


def test_a_posterior_shows_itself_and_how_far_it_may_be_trusted(found):
    assert repr(found).startswith("Posterior(linear wall: beta")
    assert f"Pareto k {found.diagnostics.k_hat:.2f}" in repr(found)


@pytest.mark.validation
def test_a_run_goes_on_from_its_file_with_the_same_result(tmp_path):
    path, counts = tmp_path / "kept.npz", []

    def stop_after_two_batches(count):
        counts.append(count)
        if len(counts) == 3:
            raise KeyboardInterrupt

    priors = replace(SHAPE_ONLY, radius=0, length=0)
    given = {"priors": priors, "draws": 40, "path": path, "numerics": COARSE, "search": FEW}
    network, mouse = SMALL, virtual_mouse()
    with pytest.raises(KeyboardInterrupt):
        posterior(network, mouse, progress=stop_after_two_batches, **given)
    first = posterior(network, mouse, **given)
    second = posterior(network, mouse, **given)
    assert np.array_equal(first.draws("beta"), second.draws("beta"))
    assert first.diagnostics == second.diagnostics


@pytest.mark.parametrize(
    ("asked", "words"), [({"fit": made_fit("linear")}, "not of tangent"), ({"draws": 10}, "at least 40")]
)
def test_a_fit_of_another_law_and_too_few_draws_are_refused(asked, words):
    with pytest.raises(InputError, match=words):
        posterior(control_network(), virtual_mouse(), "tangent", **asked)


def test_posterior_and_prior_are_the_same_only_where_middle_and_width_agree():
    """As in a rat's study: the interval is as wide as that of the assumption, the middle 1.4 SD away."""
    rows = {"alike": (0.05, 0.1), "shifted": (0.05, 1.4), "wider": (-0.5, 0.0), "narrowed": (0.8, 1.0)}
    summary = pd.DataFrame(
        {"interval_low": 0.9, "interval_high": 1.1, "prior_low": 0.9, "contraction": [one for one, _ in rows.values()]}
        | dict.fromkeys(SOURCES, 0.3),
        index=list(rows),
    )
    scores = pd.Series({name: score for name, (_, score) in rows.items()})
    unknowns = dict.fromkeys(rows, Unknown("1", "a factor", 1.0, 0.05, True, "image"))
    contradicted = meanings(summary, scores.replace(1.0, -2.1), unknowns)
    assert [one.code for one in contradicted][2:] == ["posterior.prior-conflict"]
    silent, moved = meanings(summary, scores, unknowns)
    assert str(silent).startswith("The recording says nothing about alike: posterior and prior are the same")
    assert str(moved) == (
        "The recording does not narrow what is known of shifted and wider, but posterior and prior are not the same: "
        "the middle of shifted lies 1.4 SD of the prior above its center and the interval of wider is wider than that "
        "of the prior."
    )
