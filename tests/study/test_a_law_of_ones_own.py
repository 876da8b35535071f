"""The law that the documentation prints goes all the way, from a study to its report, and from there to exports."""

import re
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from small_study import SETTINGS, make_study_in
from typer.testing import CliRunner

import vasowave as vw
from own_laws import printed_law
from vasowave.base import InputError
from vasowave.pulse.calibration import ParameterLimits, parameter_space
from vasowave.pulse.inference import Unknowns, posterior
from vasowave.pulse.model import Numerics, estimate_nominal, find_law, identity, law_files, parameter_names
from vasowave.study.animal import pipeline, stored_law, stored_recording
from vasowave.study.report import write_report

NAME, STORED = "our_laws:ExponentialWall", "exponential"
COARSE = Numerics(cell_size=0.3, samples=64)


@pytest.fixture(scope="module")
def study(tmp_path_factory, mice) -> Path:
    """Return a study of one animal that was run with the printed law, whose file lies beside study.yaml."""
    settings = SETTINGS.replace("[linear]", f"[{NAME}]").replace("starts: 2", "starts: 1\n  pressure_harmonics: 8") + (
        "inference: posterior\ngroups: [CTL]\n"
    )
    folder = make_study_in(tmp_path_factory.mktemp("own") / "study", mice[:1], settings)
    (folder / "our_laws.py").write_text(printed_law(), "utf-8")
    vw.trust_study(folder)
    with pytest.MonkeyPatch.context() as patch, ThreadPoolExecutor(1) as here:
        patch.setattr(pipeline, "posterior", partial(posterior, draws=40))
        done = vw.run_study(vw.read_study(folder), executor=here)
    assert done.failures == ()
    return folder


@pytest.fixture(scope="module")
def result(study):
    return vw.read_results(study)["mouse 0"]


def test_a_law_and_its_parameters_are_stored_under_names_that_meet_no_others(result):
    law = result.laws["exponential"]
    calibration, drawn = law.calibration, law.posterior.groups["posterior"]
    assert re.fullmatch(r"our_laws@[0-9a-f]{16}:ExponentialWall", calibration.attrs["law"])
    names = [str(one) for one in calibration["parameter"].values]
    assert names == ["exponential.k", "exponential.m", "r1", "r2", "c1"]
    assert list(drawn.data_vars)[:2] == ["exponential.k", "exponential.m"]
    assert np.ptp(drawn["exponential.k"].values) > 0 < np.ptp(drawn["k"].values)
    assert drawn["exponential.k"].attrs["units"] == "mmHg"
    assert drawn["k"].attrs["units"] == "1"  # the exponent of a stiffness that falls along the tree


def test_a_stored_model_is_the_fitted_one_and_gives_its_waves_again(result):
    model = vw.stored_model(result)
    law = type(model.wall)
    assert all(stored_law(result, one) == (STORED, law) for one in ("", STORED, NAME, identity(law), law))
    calibration = result.laws["exponential"].calibration
    fitted = dict(zip(calibration["parameter"].values, calibration["value"].values))
    assert [float(value[0]) for value in model.wall] == [fitted[name] for name in parameter_names(law)]
    again = vw.simulate(model, stored_recording(result), Numerics(cell_size=0.3, samples=256, tolerance=1e-7))
    stored = result.laws["exponential"].simulation["pressure"]
    every = np.fft.rfft(again["pressure"].values[:, 0, 0])[:8] / 256
    kept = np.fft.rfft(stored.values[:, 0, 0])[:8] / stored.sizes["time"]
    assert np.abs(every - kept).max() < 0.01  # mmHg; the steps differ


def test_a_stored_law_is_swept_and_exported(result, tmp_path):
    model, cycle = vw.stored_model(result), stored_recording(result)
    k, m = (float(value[0]) for value in model.wall)
    found = vw.sweep(model, cycle, {"exponential.k": [k, 2 * k]}, COARSE)
    assert (found["failure"] == "").all()
    pulse = found["pulse_pressure"].sel(vessel="1").values
    assert pulse[1] != pytest.approx(pulse[0], rel=1e-3)
    with pytest.raises(InputError, match=r"this model has no parameter 'k'.*exponential\.k"):
        vw.sweep(model, cycle, {"k": [1.0]}, COARSE)
    for program in ("matlab", "openbf", "svzerod", "tables", "paraview"):
        vw.export_model(model, cycle, program, tmp_path / program, numerics=COARSE)
    header, first = (tmp_path / "tables/parameters.csv").read_text("utf-8").splitlines()[:2]
    assert header.startswith("vessel,exponential.k [mmHg],exponential.m [1],R1 [mmHg s/ml]")
    assert [float(one) for one in first.split(",")[1:3]] == [k, m]


def test_commands_take_a_stored_law_by_its_name(study, tmp_path, monkeypatch):
    from vasowave.cli import simulate  # noqa: F401  registers its commands
    from vasowave.cli.app import app

    monkeypatch.chdir(tmp_path)
    asked = ["--animal", "mouse 0", "--wall", STORED, "--cell-size", "0.3", "--set", "exponential.m=3"]
    done = CliRunner().invoke(app, ["simulate", str(study), *asked, "-o", "waves.nc"])
    assert done.exit_code == 0, done.output
    assert "ExponentialWall(k" in done.output
    assert Path("waves.nc").is_file()


def test_results_are_read_without_the_law_and_a_sentence_says_what_cannot_be_done(
    study, tmp_path, monkeypatch, undrawn
):
    away = (study / "our_laws.py").rename(tmp_path / "elsewhere.py")
    monkeypatch.setattr(law_files, "_known", {})
    try:
        results = vw.read_results(study)
        page = write_report(results.in_order(), tmp_path / "report")
        assert "p = k (exp(m (A/A₀ − 1)) − 1)" in page.with_name("supplement.html").read_text("utf-8")
        with pytest.raises(InputError, match=r"our_laws\.py, as it was when it was used, is not here"):
            vw.stored_model(results["mouse 0"])
        (study / "our_laws.py").write_text(printed_law() + "# changed\n", "utf-8")
        with pytest.raises(InputError, match=r"our_laws\.py, as it was when it was used, is not here"):
            vw.stored_model(vw.read_results(study)["mouse 0"])
    finally:
        away.rename(study / "our_laws.py")
    assert type(vw.stored_model(vw.read_results(study)["mouse 0"]).wall).__name__ == "ExponentialWall"


def test_fields_named_as_other_numbers_of_a_model_are_not_confused_with_them(tmp_path, monkeypatch, mice):
    text = printed_law().replace("ExponentialWall", "Clashing").replace('Law("exponential"', 'Law("clashing"')
    text = re.sub(r"(?<![\"\w])k(?![\w\"])", "r1", text)
    text = re.sub(r"(?<![\"\w])m(?![\w\"])", "c1", text)
    (tmp_path / "clashing_laws.py").write_text(text, "utf-8")
    monkeypatch.chdir(tmp_path)
    law, network = find_law("clashing_laws:Clashing"), vw.control_network()
    assert law._fields == ("r1", "c1")
    nominal = estimate_nominal(network, mice[0])
    fixed = {"clashing.r1": 20.0, "r1": 1.25}
    space = parameter_space(law, network, nominal, vw.Blood(), ParameterLimits(fixed=fixed))
    assert space.free_names == ("clashing.c1", "r2", "c1")
    unknowns = Unknowns(space, nominal, vw.Priors(parameters={"clashing.c1": (3.0, 0.2), "c1": (0.5, 0.1)}), mice[0])
    for model in (space.model(space.nominal), unknowns.model(np.zeros(len(unknowns.all)))):
        assert model.wall.r1[0] == 20.0
        assert model.outlets.R1[0] == pytest.approx(1.25 * nominal.outlets.R1[0])
    assert model.wall.c1[0] == pytest.approx(3.0)
    assert model.outlets.C[0] == pytest.approx(0.5 * nominal.outlets.C[0])


def test_two_laws_of_one_name_are_refused(tmp_path, monkeypatch):
    for place in ("one", "other"):
        (tmp_path / f"{place}.py").write_text(printed_law(), "utf-8")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match="two of these wall laws have one name"):
        vw.Settings(walls=("one:ExponentialWall", "other:ExponentialWall"))
