"""A pressure behind the beds that changes over the cycle: against the linear model, as a cause alone, and in fits."""

import numpy as np
import pytest

import vasowave as vw
from vasowave.base import InputError
from vasowave.catheter.read import read_wedge
from vasowave.pulse.model import Numerics
from vasowave.study.folder import StudyFile
from vasowave.study.results import load_animal
from vasowave.study.running import one_row

NETWORK, MOUSE = vw.control_network(), vw.virtual_mouse()
BEDS = vw.estimate_nominal(NETWORK, MOUSE).outlets
T = np.arange(64) / 64
WAVE = 2.0 * np.sin(2 * np.pi * T + 0.3) + 0.7 * np.cos(6 * np.pi * T)  # mmHg


def test_a_program_that_knows_no_such_wave_is_not_given_the_model(tmp_path):
    model = vw.Model(NETWORK, vw.LinearWall(60.0), BEDS, outlet_pulsation=WAVE)
    with pytest.raises(InputError, match="no pressure behind its outlets that changes over the cycle"):
        vw.export_model(model, MOUSE.inflow, "svzerod", tmp_path / "out", numerics=Numerics(samples=64, cell_size=0.5))


@pytest.mark.parametrize(
    ("wave", "message"),
    [(15 * WAVE, "falls to -.* mmHg; correct its zero"), (3 * T, "the cycle of the pressure behind the beds does not")],
)
def test_a_wave_that_no_atrium_makes_is_refused(tmp_path, wave, message):
    with pytest.raises(InputError, match=message):
        read_wedge(written(tmp_path / "la.csv", MOUSE.period, wave), MOUSE.period)


def written(path, period, wave=WAVE):
    rows = [f"{t * period:.9f};{(8 + p) / 7.50062:.9f}" for t, p in zip(T, wave, strict=True)]
    path.write_text("\n".join(["Zeit [s];LAP [kPa]", *rows, ""]), "utf-8")
    return path


def test_a_table_of_the_wave_gives_its_mean_and_its_pulsation_and_must_last_one_cycle(tmp_path):
    found = read_wedge(written(tmp_path / "la.csv", MOUSE.period), MOUSE.period)
    assert found.mean == pytest.approx(8.0 + WAVE.mean(), abs=1e-4)
    np.testing.assert_allclose(found.pulsation, WAVE - WAVE.mean(), atol=1e-4)
    with pytest.raises(InputError, match=r"la\.csv: its cycle lasts 0\.22514 s and that of the recording"):
        read_wedge(written(tmp_path / "la.csv", 2 * MOUSE.period), MOUSE.period)


@pytest.mark.parametrize(("cells", "mean"), [({}, 8.0 + WAVE.mean()), ({"wedge [mmHg]": "6.5"}, 6.5)])
def test_an_animal_has_the_wave_of_its_column_and_the_mean_that_is_given(tmp_path, cells, mean):
    vw.write_network(NETWORK, tmp_path / "lung.csv")
    columns = [MOUSE.time, MOUSE.pressure, np.interp(MOUSE.time, np.arange(len(MOUSE.flow)) * MOUSE.period /
               len(MOUSE.flow), MOUSE.flow)]  # fmt: skip
    np.savetxt(tmp_path / "cycle.csv", np.stack(columns, axis=1), delimiter=",", comments="",
               header="time [s],pressure [mmHg],flow [ml/s]")  # fmt: skip
    written(tmp_path / "la.csv", MOUSE.period)
    given = {"wedge wave": str(tmp_path / "la.csv"), **cells}
    row = one_row(tmp_path / "lung.csv", [tmp_path / "cycle.csv"], "m", "CTL", given)
    recording = load_animal(row, StudyFile(), tmp_path).recording
    assert recording.wedge_pressure == pytest.approx(mean, abs=1e-4)
    assert np.ptp(recording.wedge_pulsation) == pytest.approx(np.ptp(WAVE), abs=1e-3)
    codes = {one.code for one in recording.notes}
    assert {"recording.wedge", "recording.wedge-wave"} <= codes
    assert ("recording.wedge-differs" in codes) is bool(cells)
