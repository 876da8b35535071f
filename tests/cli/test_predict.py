"""Changes that are foretold of a stored fit, by the command and from Python."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

import vasowave as vw
from vasowave.cli.app import app
from vasowave.study.animal import posterior_result, to_bytes
from vasowave.study.folder import StudyFile
from vasowave.study.results.results import write_results
from vasowave.study.results.store import ResultStore

ERRORS = {"radius_scale_sd": 0.05, "length_scale_sd": 0.0, "k_sd": 0.0}
HELD = {"fixed": {"r1": 1.0, "r2": 1.0, "c1": 1.0}, "pressure_harmonics": 8}
COARSE = vw.Numerics(cell_size=0.2)


@pytest.fixture(scope="module")
def network():
    return vw.Network(("1",), [-1], [0.4], [0.05])


@pytest.fixture(scope="module")
def result(network):
    """An animal of one vessel, of which only the stiffness is unknown."""
    mouse = vw.Animal("mouse 6", "CTL", network, vw.virtual_mouse(), synthetic=True)
    return vw.analyze(mouse, vw.Settings(walls=("linear",), starts=1, numerics=COARSE, **HELD, **ERRORS))


@pytest.fixture
def folder(result, tmp_path):
    (tmp_path / "fit").mkdir()
    piece = ResultStore(tmp_path / "fit").keep("0" * 64, to_bytes(result.to_datatree()))
    write_results(tmp_path / "fit", {(result.name, result.group): piece}, [], StudyFile())
    return tmp_path / "fit"


def said(*words):
    done = CliRunner().invoke(app, ["predict", *map(str, words)])
    if done.exception and not isinstance(done.exception, SystemExit):
        raise done.exception
    return done.output


def test_the_command_foretells_what_python_does_with_units_table_and_picture(folder, result, network, tmp_path):
    text = said(folder, "--change", "R_T=0.7", "--change", "HR=1.2", "-o", tmp_path / "t.csv", "--plot",
                tmp_path / "t.svg")  # fmt: skip
    search = vw.Search(starts=1, **HELD)
    fit = vw.calibrate(network, vw.virtual_mouse(), search=search, numerics=COARSE)
    expected = vw.predict(fit, {"R_T": 0.7, "HR": 1.2}).table
    table = pd.read_csv(tmp_path / "t.csv", index_col="quantity")
    numbers = ["before", "after", "change", "change_low", "change_high"]
    pd.testing.assert_frame_equal(table[numbers], expected[numbers], rtol=1e-4, atol=1e-6, check_names=False)
    (line,) = (line for line in text.splitlines() if line.startswith("mPAP"))
    assert line.split()[-1] == "mmHg"
    assert "nothing regulates itself" in text
    picture = (tmp_path / "t.svg").read_text(encoding="utf-8")
    assert all(words in picture for words in ("pressure [mmHg]", "flow [ml/s]", "time [ms]", "before", "after"))


def test_no_change_is_refused_and_nothing_is_written(folder, tmp_path):
    with pytest.raises(vw.errors.InputError, match="there are: beta"):
        said(folder, "-o", tmp_path / "t.csv")
    with pytest.raises(vw.errors.InputError, match="beta=60"):
        said(folder, "--change", "R_T")
    assert not (tmp_path / "t.csv").exists()


def test_a_band_is_a_change(folder):
    text = said(folder, "--narrow", "1=0.5,0.05", "--draws", 0)
    (line,) = (line for line in text.splitlines() if line.startswith("mPAP"))
    assert float(line.split()[3]) > 0


@pytest.mark.validation
def test_a_posterior_that_is_stored_makes_the_intervals(result, network):
    drawn = vw.posterior(network, vw.virtual_mouse(), priors=vw.Priors(radius=0, **ERRORS), search=vw.Search(**HELD),
                         draws=40)  # fmt: skip
    law = replace(result.laws["linear"], posterior=posterior_result(drawn))
    stored = vw.stored_fit(replace(result, laws={"linear": law}))
    radii, stiffness = np.array([(model.network.radius[0], model.wall.beta[0]) for model, _ in stored.drawn]).T
    single = np.log(radii / (0.05 * drawn.draws("radius_scale")))
    assert single.std() == pytest.approx(0.05, rel=0.5)  # the image's error of each vessel
    speed = np.sqrt((stiffness + drawn.draws("mPAP")) / (2 * vw.Blood().inertia))  # of the linear law
    assert speed == pytest.approx(drawn.draws("wave_speed"), rel=1e-6)
    by_posterior = vw.predict(stored, {"beta": 1.5}, draws=40)
    assert any("posterior" in text for text in by_posterior.assumptions)
    changes = []
    for model, inflow in stored.drawn:
        stiffer = vw.Model(model.network, vw.LinearWall(1.5 * model.wall.beta), model.outlets, model.blood)
        pulses = [
            float(np.ptp(vw.simulate(end, inflow, stored.numerics).pressure.values[:, 0, 0]))
            for end in (model, stiffer)
        ]
        changes.append(pulses[1] - pulses[0])
    ends = np.quantile(changes, [0.025, 0.5, 0.975], method="weibull")
    row = by_posterior.table.loc["pPAP"]
    assert row[["change_low", "change", "change_high"]].to_numpy(float) == pytest.approx(ends, rel=1e-3)


def test_the_command_says_what_measurements_would_add_and_writes_it(folder, network, tmp_path):
    text = said(folder, "--measurements", "--site", "1", "--site", "1", "-o", tmp_path / "m.csv")
    search = vw.Search(starts=1, **HELD)
    fit = vw.calibrate(network, vw.virtual_mouse(), search=search, numerics=COARSE)
    expected = fit.expected_precision(["1"], priors=vw.Priors(**ERRORS)).table
    table = pd.read_csv(tmp_path / "m.csv", index_col="quantity")
    numbers = [*expected.columns[1:]]
    pd.testing.assert_frame_equal(table[numbers], expected[numbers], rtol=0.02, check_names=False, check_dtype=False)
    (line,) = (line for line in text.splitlines() if line.startswith("beta"))
    assert line.split()[-1] == f"{expected.loc['beta', 'all of them']:.2f}"
    with pytest.raises(vw.errors.InputError, match="leave --change"):
        said(folder, "--measurements", "--change", "R_T=0.7")
    with pytest.raises(vw.errors.InputError, match="no vessel '9'"):
        said(folder, "--measurements", "--site", "9")
    with pytest.raises(vw.errors.InputError, match="give --measurements"):
        said(folder, "--change", "R_T=0.7", "--site", "1")


@pytest.mark.parametrize("viscous", [None, pytest.param(True, marks=pytest.mark.validation)])
def test_a_fit_foretells_with_the_harmonics_walls_and_cells_that_it_was_made_with(network, viscous):
    settings = {"search": vw.Search(starts=1, **HELD, viscous=viscous), "numerics": COARSE}
    fit = vw.calibrate(network, vw.virtual_mouse(), **settings)
    values = fit.parameters["value"]
    expected = vw.expected_precision(network, vw.virtual_mouse(), start=values, **settings).table
    assert ("wall_viscosity" in expected.index) == bool(viscous)
    pd.testing.assert_frame_equal(fit.expected_precision().table, expected, rtol=1e-6)


@pytest.mark.validation
def test_a_stored_fit_is_asked_within_the_intervals_of_its_posterior(result, network):
    posterior = posterior_result(
        vw.posterior(network, vw.virtual_mouse(), draws=100, search=vw.Search(**HELD), priors=vw.Priors(**ERRORS))
    )
    stored = vw.stored_fit(replace(result, laws={"linear": replace(result.laws["linear"], posterior=posterior)}))
    asked = stored.sensitivity(samples=64)
    low, high = (float(posterior.table[f"interval_{end}"].sel(quantity="beta")) for end in ("low", "high"))
    reach = stored.parameters.loc["beta", "value"] * np.array([0.5, 2.0])
    assert asked.box.loc["beta", ["low", "high"]].tolist() == pytest.approx(np.clip([low, high], *reach), rel=0.01)
    assert len(asked.figure().axes) == 5
