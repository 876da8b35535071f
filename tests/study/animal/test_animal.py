"""One animal as one result: what stands in it, in which unit, and in its file."""

import hashlib
import re
import warnings
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from made_fit import PARAMETERS, made_fit, made_recording
from vasowave.base import InputError, VasowaveWarning, texts
from vasowave.catheter import synthetic_raw_recording
from vasowave.pulse import QUANTITIES
from vasowave.pulse.analysis import compliance
from vasowave.pulse.cycle import Recording
from vasowave.pulse.examples import control_network, virtual_mouse
from vasowave.pulse.model import Numerics, Windkessel, find_law
from vasowave.pulse.network import Network
from vasowave.study.animal import (
    Animal,
    Settings,
    analyze,
    derived_of,
    errors_of,
    flow_noise,
    quantities_of,
    read_result,
    stored_inflow,
    write_result,
)

GROUPS = {
    "network", "recording", "beats", "nominal",
    "measured/waves", "measured/impedance", "measured/quantities",
    *(f"{wall}/{part}" for wall in ("linear", "tangent")
      for part in ("calibration", "simulation", "waves", "impedance", "tree", "quantities")),
}  # fmt: skip


@pytest.fixture(scope="module")
def result():
    """Return the result of a synthetic raw recording, with fits made from formulas instead of searches."""
    raw = synthetic_raw_recording(made_recording(), np.random.default_rng(3), duration=8.0).raw
    with pytest.warns(match="the flow rests at"):  # as this wave does
        animal = Animal.from_raw("m 1", "CTL", control_network(), raw, synthetic=True)
    return analyzed(animal)


def analyzed(animal):
    def fit(network, recording, wall, **more):
        warnings.warn(f"a warning of the {wall} fit", VasowaveWarning, stacklevel=2)
        return made_fit(wall)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("vasowave.study.animal.pipeline.calibrate", fit)
        return analyze(animal, Settings(starts=1, model_selection=False))


def test_the_tree_has_the_groups_that_reports_are_made_from(result):
    leaves = {part.path.strip("/") for part in result.to_datatree().subtree if part.has_data}
    assert leaves == GROUPS
    assert result.name == "m 1"
    assert result.synthetic


def test_every_number_of_the_tree_has_a_unit(result):
    for part in result.to_datatree().subtree:
        if part.name == "calibration":  # its tables hold several units in one column; the column 'unit' names them
            continue
        for name, variable in part.variables.items():
            if variable.dtype.kind == "f":
                assert variable.attrs.get("units"), f"{part.path}/{name}"


def test_every_quantity_is_one_that_is_explained_and_its_interval_holds_it(result):
    for source in ("measured", "linear", "tangent"):
        found = result.sources[source].quantities
        known = QUANTITIES if source == "measured" else quantities_of(find_law(source), Windkessel)
        assert set(found.data_vars) <= set(known)
        for name, value in found.data_vars.items():
            assert value.attrs["units"] == known[name].unit
            if "interval_low" in value.attrs:
                assert value.attrs["interval_low"] < float(value) < value.attrs["interval_high"]
        assert ("interval_low" in found["R_T"].attrs) == (source != "measured")


def test_a_tree_survives_its_file_unchanged(result, tmp_path):
    write_result(result, tmp_path / "m.nc")
    back = read_result(tmp_path / "m.nc")
    assert back.to_datatree().identical(result.to_datatree())
    assert [path.name for path in tmp_path.iterdir()] == ["m.nc"]
    assert back.settings["starts"] == 1


def test_the_file_is_what_xarray_writes_and_reads(result, tmp_path):
    import xarray as xr

    write_result(result, tmp_path / "ours.nc")
    result.to_datatree().to_netcdf(tmp_path / "theirs.nc")
    with xr.open_datatree(tmp_path / "ours.nc", decode_timedelta=False) as opened:
        for group in opened.subtree:
            for variable in group.variables.values():
                variable.load()
        assert opened.identical(result.to_datatree())
    assert read_result(tmp_path / "theirs.nc").to_datatree().identical(result.to_datatree())


def test_a_byte_that_changed_is_noticed_before_anything_is_read(result, tmp_path):
    path = tmp_path / "m.nc"
    write_result(result, path)
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    assert read_result(path, digest).name == result.name
    damaged = bytearray(path.read_bytes())
    damaged[len(damaged) // 2] ^= 1
    path.write_bytes(damaged)
    with pytest.raises(InputError, match=r"m\.nc: damaged or changed"):
        read_result(path, digest)


@pytest.mark.parametrize("content", [None, b"", b"no netCDF", b"\x89HDF\r\n\x1a\n cut short"])
def test_a_file_that_is_none_of_ours_is_refused_in_words(tmp_path, content):
    path = tmp_path / "m.nc"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError, match=r"m\.nc"):
        read_result(path)


def test_another_netcdf_file_is_refused(tmp_path):
    import xarray as xr

    xr.Dataset({"x": 1.0}, attrs={"title": "rain"}).to_netcdf(tmp_path / "m.nc")
    with pytest.raises(InputError, match="its title is not"):
        read_result(tmp_path / "m.nc")


def test_warnings_and_notes_of_every_step_stand_in_the_tree_once(result):
    notes = texts(result.findings)
    assert "a warning of the linear fit" in notes
    assert "a warning of the tangent fit" in notes
    assert any(note.startswith("tangent wall: The data do not determine r1") for note in notes)
    assert any("synthetic" in note for note in notes)
    assert len(set(notes)) == len(notes)


def test_measured_waves_add_up_to_pressure_and_flow(result):
    waves, recording = result.measured.waves, result.recording
    total = waves["p_plus"] + waves["p_minus"] - float(waves["p_plus"][0])
    np.testing.assert_allclose(total, recording["pressure"], atol=1e-10)
    np.testing.assert_allclose(
        waves["q_plus"] + waves["q_minus"] - float(waves["q_plus"][0]), recording["flow"], atol=1e-12
    )
    assert float(waves["normalized_time"][-1]) == pytest.approx(1 - 1 / len(waves["time"]))


def test_the_beats_are_listed_with_their_fate(result):
    beats = result.beats
    assert int(beats["kept"].sum()) == 20
    assert all(reason == "" for reason in beats["reason"].values[beats["kept"].values == 1])
    np.testing.assert_allclose(beats["onset"][:-1] + beats["length"][:-1], beats["onset"][1:], atol=1e-9)
    assert beats.sizes["trace_time"] == 12000  # 6 s at 2000/s


def test_compliance_is_taken_at_the_diastolic_pressure_of_each_vessel(result):
    fit = made_fit("linear")
    diastolic = fit.simulation["pressure"].sel(station="middle").min("time").values
    expected = 2 * fit.model.area0 * fit.model.network.length / 57.3 * (1 + diastolic / 57.3)
    np.testing.assert_allclose(result.laws["linear"].vessels["compliance"], expected, rtol=1e-12)
    assert float(result.laws["linear"].quantities["C_v_plain"]) == pytest.approx(expected.sum())
    assert float(result.laws["linear"].quantities["C_v"]) == pytest.approx(
        compliance(fit.model, diastolic).network_published
    )


def test_resistance_and_compliance_of_the_beds_follow_from_the_factors(result):
    quantities, factors = result.laws["linear"].quantities, PARAMETERS["linear"]
    nominal = made_fit("linear").nominal
    R_T = nominal.total_resistance * (0.2 * factors["r1"] + 0.8 * factors["r2"])
    assert float(quantities["R_T"]) == pytest.approx(R_T)
    a = 0.2 * factors["r1"] * nominal.total_resistance / R_T
    assert float(quantities["a"]) == pytest.approx(a)
    C_p = (1 - a) * factors["c1"] * nominal.time_constant / nominal.total_resistance
    assert float(quantities["C_p"]) == pytest.approx(C_p)
    assert float(quantities["tau"]) == pytest.approx(R_T * float(quantities["C_T"]))


def test_the_error_of_a_ratio_is_small_where_its_parts_go_together():
    fit = made_fit("tangent")
    diastolic = np.full(len(fit.model.network), 8.0)
    errors = errors_of(fit, lambda values: derived_of(fit, values, diastolic))
    # Both errors are 0.3 and their correlation is 0.3: the variance of the ratio is 2 · 0.09 · (1 - 0.3).
    assert errors["p1_over_gamma"][0] == pytest.approx(np.sqrt(2 * 0.09 * 0.7), rel=1e-6)
    assert errors["p1"][0] == pytest.approx(0.3, rel=1e-6)
    assert errors["p1"][1] == pytest.approx(1.959964 * 0.3, rel=1e-6)


def test_flow_noise_is_told_by_the_scatter_of_the_beats():
    rng = np.random.default_rng(5)
    raw = synthetic_raw_recording(made_recording(), rng, duration=8.0).raw
    with pytest.warns(match="the flow rests at"):  # as this wave does
        animal = Animal.from_raw("m", "CTL", control_network(), raw)
    white = 0.005  # ml/s, the noise of the synthetic flow at 2000 samples/s
    samples = 2000 * made_recording().period
    expected = white * np.sqrt(4 / (samples * 20))  # an amplitude's noise, mean of 20 beats
    # Beats also vary in strength; the scatter of 20 is known within a few percent.
    assert 0.95 * expected < flow_noise(animal.recording, animal.beats) < 8 * expected


def test_flow_noise_of_an_averaged_cycle_is_its_highest_harmonics():
    t = np.arange(256) / 256
    flow = 0.2 + 0.3 * np.sin(2 * np.pi * t) + 0.004 * np.sin(2 * np.pi * 40 * t)
    recording = Recording(15 + flow, flow, 0.11)
    assert flow_noise(recording, None) == pytest.approx(0.004)


def test_wrong_settings_are_refused_with_what_there_is():
    with pytest.raises(InputError, match="did you mean 'linear'"):
        Settings(walls=("linaer",))
    with pytest.raises(InputError, match="no parameter 'betta'"):
        Settings(bounds={"betta": (1.0, 2.0)})
    for walls, words in ((("linear", "linear"), "linear, linear: choose"), ((), "nothing: choose")):
        with pytest.raises(InputError, match=f"{words} at least one, each once"):
            Settings(walls=walls)
    with pytest.raises(InputError, match="starts: 0 is too small; at least 1"):
        Settings(starts=0)


def test_a_bound_reaches_only_the_law_that_has_the_parameter():
    settings = Settings(bounds={"beta": (10.0, 90.0), "r1": (0.1, 2.0)}, fixed={"gamma": 2.0})
    assert set(settings.search("linear").bounds) == {"beta", "r1"}
    assert set(settings.search("tangent").bounds) == {"r1"}
    assert settings.search("linear").fixed == {}
    assert settings.search("tangent").fixed == {"gamma": 2.0}


def test_an_animal_without_a_name_is_refused():
    with pytest.raises(InputError, match="without a group"):
        Animal("m", " ", control_network(), made_recording())


def test_an_interrupted_fit_ends_the_fits_and_keeps_those_before_it():
    class Interrupted(dict):
        """Kept searches whose second law is interrupted before it begins."""

        def searches(self, wall, starts):
            if wall == "tangent":
                raise KeyboardInterrupt
            return self

        def find(self, stage, start):
            return None

        def keep(self, stage, start, end):
            self[stage, start] = end

    network = Network(("1", "2", "3"), [-1, 0, 0], [0.41, 0.45, 0.37], [0.047, 0.026, 0.037])
    animal = Animal("m", "CTL", network, virtual_mouse(), synthetic=True)
    settings = Settings(walls=("linear", "tangent", "power"), starts=1, numerics=Numerics(cell_size=0.3))
    kept = Interrupted()
    result = analyze(animal, settings, kept=kept)
    assert (list(result.laws), result.interrupted) == (["linear"], True)
    assert kept
    with pytest.raises(KeyboardInterrupt):  # nothing is there that could be kept
        analyze(animal, replace(settings, walls=("tangent", "linear")), kept=kept)


def test_what_enters_a_stored_fit_is_the_flow_that_was_measured_or_what_a_pressure_let_in(result):
    flow, law = result.recording["flow"].values, result.laws["linear"]
    assert np.array_equal(stored_inflow(result, "linear").flow, flow)
    entered = SimpleNamespace(
        compared="flow", calibration=law.calibration, simulated=lambda name, vessel: 1.5 * law.simulated(name, vessel)
    )
    let_in = stored_inflow(SimpleNamespace(laws={"linear": entered}, recording=result.recording, root=result.root))
    np.testing.assert_allclose(let_in.flow, 1.5 * law.simulated("flow", result.root).values)
    assert let_in.period == result.recording.attrs["period"]


def test_a_file_over_which_hdf5_hangs_is_refused(result, tmp_path):
    """A gap of no size in a heap of texts: the library steps over it for ever."""
    write_result(result, tmp_path / "m 1.nc")
    content = bytearray((tmp_path / "m 1.nc").read_bytes())
    for collection in re.finditer(b"GCOL\x01", bytes(content)):
        start = collection.start()
        place, end = start + 16, start + int.from_bytes(content[start + 8 : start + 16], "little")
        while place + 16 <= end and any(content[place : place + 2]):  # the number of an object; the gap has none
            place += 16 + -(-int.from_bytes(content[place + 8 : place + 16], "little") // 8) * 8
        if place + 16 <= end:
            content[place + 8 : place + 16] = bytes(8)
    (tmp_path / "m 1.nc").write_bytes(content)
    with pytest.raises(InputError, match="damaged"):
        read_result(tmp_path / "m 1.nc")
