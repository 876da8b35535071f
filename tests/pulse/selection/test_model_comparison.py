import numpy as np
import pytest
import xarray as xr
from scipy.stats import multivariate_normal

from approval import approve, tree
from vasowave.base import InputError
from vasowave.pulse import noise, selection
from vasowave.pulse.selection import averaged_draws

T, N = 0.11, 64
TIME = np.arange(N) * T / N
D = {"linear": 4, "tangent": 5}


def drawn(covariance, count, seed):
    return np.random.default_rng(seed).multivariate_normal(np.zeros(len(covariance)), covariance, count)


def two_series(seed=5):
    return dict(zip(D, drawn(0.25 * noise.matern32(TIME, 0.01), 2, seed)))


def test_the_fitted_kernel_has_the_greatest_likelihood_of_a_grid_and_is_near_the_truth():
    residuals = drawn(0.25 * noise.matern32(TIME, 0.01), 60, 3)
    fitted, values = noise.fit_kernel(noise.KERNELS["Matern 3/2"], residuals, T, np.random.default_rng(0))
    assert values["length [s]"] == pytest.approx(0.01, rel=0.05)
    assert values["amplitude [mmHg2]"] == pytest.approx(0.25, rel=0.15)

    def joint(sigma):
        return multivariate_normal(cov=noise.regularize(sigma)[0]).logpdf(residuals).sum()

    for length in values["length [s]"] * np.array([0.97, 1.03]):
        assert joint(fitted) > joint(values["amplitude [mmHg2]"] * noise.matern32(TIME, length))
    assert joint(fitted) > joint(1.03 * fitted)
    assert joint(fitted) > joint(0.97 * fitted)


def compared(residuals, **how):
    return selection.compare_residuals(residuals, D, T, selection.Comparing(**how)).to_dataframe()


def test_the_table_has_the_scores_of_eq_21_to_23_best_first():
    residuals = two_series()
    table = compared(residuals, covariances=("Matern 3/2", "circulant"))
    assert len(table) == 4
    process = noise.fit_noise("Matern 3/2", np.stack(list(residuals.values())), T, rng=np.random.default_rng(0))
    for row in table[table["covariance"] == "Matern 3/2"].itertuples():
        logL = multivariate_normal(cov=process.covariance).logpdf(residuals[row.wall])
        D_ = D[row.wall]
        assert pytest.approx(-2 * logL + D_ * np.log(N)) == row.BIC
        assert pytest.approx(-2 * logL + 2 * D_ * N / (N - D_ - 1)) == row.AICc
    for _, scores in table.groupby("covariance")["AICc"]:
        assert scores.is_monotonic_increasing


def test_approved_the_scores_under_each_kind_of_covariance():
    few, kinds = two_series(), ("circulant", "independent", "Matern 3/2")
    how = selection.Comparing(kinds, starts=1)
    found = selection.compare_residuals({wall: series[::2] for wall, series in few.items()}, D, T, how)
    told = (f"{row.wall}, {row.covariance}: {row.loglik:.3f} {row.AICc:.3f} {row.BIC:.3f} {row.AICc_verdict} "
            f"{row.BIC_verdict} {row.discarded}" for row in found.to_dataframe().itertuples())  # fmt: skip
    approve("selection", [*tree(xr.DataTree(found.drop_vars("hyperparameters"))), *told], 2e-3, 1e-3)


def test_another_unit_of_pressure_changes_no_difference():
    residuals, how = two_series(), {"covariances": ("neural network", "Matern 3/2", "circulant")}
    plain = compared(residuals, **how)
    scaled = compared({k: 0.1333 * r for k, r in residuals.items()}, **how)
    np.testing.assert_allclose(scaled["AICc_difference"], plain["AICc_difference"], atol=1e-3)
    np.testing.assert_allclose(scaled["AICc"] - plain["AICc"], 2 * N * np.log(0.1333), atol=1e-3)


def test_equal_residuals_prefer_fewer_parameters_by_less_than_can_be_decided():
    r = two_series()["linear"]
    table = compared({"tangent": r, "linear": r}, covariances=("circulant",))
    assert table["wall"].tolist() == ["linear", "tangent"]
    assert set(table["AICc_verdict"]) | set(table["BIC_verdict"]) == {"undecided"}
    assert table["BIC_difference"].max() == pytest.approx(np.log(N))


def test_the_best_of_three_models_is_preferred_only_if_the_runner_up_is_far_behind():
    scores = {"linear": 100.0, "power": 101.0, "tangent": 130.0}
    assert [verdict for _, _, verdict in selection.verdicts(scores)] == ["undecided", "undecided", "worse"]
    assert [v for _, _, v in selection.verdicts(scores | {"power": 110.0})] == ["preferred", "worse", "worse"]
    assert selection.verdicts({"linear": 100.0}) == [("linear", 0.0, "undecided")]


@pytest.mark.parametrize(
    ("residuals", "words"),
    [
        ({"linear": np.ones(N)}, "two models"),
        ({"linear": np.ones(N), "tangent": np.zeros(N)}, "tangent"),
        ({"linear": np.ones(N), "tangent": np.ones(N - 1)}, "shape"),
        ({"linear": np.ones(N), "other": np.ones(N)}, "n_parameters"),
    ],
)
def test_residuals_that_cannot_be_compared_are_refused(residuals, words):
    with pytest.raises(InputError, match=words):
        selection.compare_residuals(residuals, D, T)


def test_draws_of_laws_are_joined_by_their_weights():
    found = averaged_draws([np.full(10, 1.0), np.full(1000, 4.0)], np.array([0.6, 0.4]))
    assert (found.low, found.value, found.high) == pytest.approx((1.0, 1.0, 4.0))
    spread = averaged_draws([np.exp([0.0, 2.0]), np.exp([3.0, 3.0])], np.array([0.5, 0.5]))
    assert spread.between == pytest.approx(1.0 / (1.0 + 0.5))  # of logarithms: between the laws, and within the first


def test_an_unknown_noise_model_is_named_with_the_known_ones():
    with pytest.raises(InputError, match=r"Matern 7/2.*circulant"):
        compared(two_series(), covariances=("Matern 7/2",))
