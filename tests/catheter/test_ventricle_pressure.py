"""Files of the pressure in a ventricle."""

import numpy as np
import pytest

from vasowave.base import InputError
from vasowave.catheter.read import read_ventricle
from vasowave.pulse.cycle import VentricularPressure

PERIOD = 0.11


def pressure(time):
    share = (time % PERIOD) / PERIOD
    return 3 + 27 * np.where(share < 0.5, np.sin(np.pi * share / 0.5) ** 2, 0.0)


def written(path, time, values, header="time [s],pressure [mmHg]"):
    rows = "\n".join(f"{a:.5f},{b:.5f}" for a, b in zip(time, values, strict=True))
    path.write_text(f"{header}\n{rows}\n", encoding="utf-8")
    return path


def test_one_cycle_with_its_time_is_read_as_it_stands(tmp_path):
    time = np.arange(110) / 1000
    found = read_ventricle(written(tmp_path / "rv.csv", time, pressure(time)))
    assert found.period == pytest.approx(PERIOD)
    assert found.beats == 1
    assert np.allclose(found.pressure, pressure(time), atol=1e-5)


def test_units_are_converted_and_a_column_of_the_ventricle_is_found(tmp_path):
    time = np.arange(110) / 1000
    file = written(tmp_path / "rv.csv", 1000 * time, pressure(time) * 0.13332236842, "time [ms],RVP [kPa]")
    assert np.allclose(read_ventricle(file).pressure, pressure(time), atol=1e-3)
    assert read_ventricle(file).period == pytest.approx(PERIOD)


def test_beats_are_averaged_from_upstroke_to_upstroke(tmp_path):
    rng, time = np.random.default_rng(2), np.arange(2000) / 1000
    file = written(tmp_path / "rv.csv", time, pressure(time) + 0.3 * rng.standard_normal(2000))
    found = read_ventricle(file)
    assert found.period == pytest.approx(PERIOD, rel=0.01)
    assert 14 <= found.beats <= 18
    true = pressure(np.arange(512) / 512 * PERIOD)
    shifted = min(np.sqrt(np.mean((np.roll(found.pressure, k) - true) ** 2)) for k in range(512))
    assert shifted < 0.6


def test_two_beats_of_which_neither_is_usual_are_named_with_their_lengths(tmp_path):
    beats = [pressure(np.arange(count) / count * PERIOD) for count in (100, 190, 100)]
    values = np.concatenate(beats)
    with pytest.raises(
        InputError, match=r"its beats last 0\.11\d to 0\.1[78]\d? s, none of them about as long as usual"
    ):
        read_ventricle(written(tmp_path / "rv.csv", np.arange(len(values)) / 1000, values))


def test_a_file_without_time_takes_the_period_of_the_recording(tmp_path):
    file = tmp_path / "rv.txt"
    file.write_text("\n".join(f"{value:.4f}" for value in pressure(np.arange(110) / 1000)), encoding="utf-8")
    assert read_ventricle(file, PERIOD).period == PERIOD
    with pytest.raises(InputError, match="no column of time"):
        read_ventricle(file)


@pytest.mark.parametrize(
    ("values", "period", "words"),
    [
        (np.zeros(10), 0.1, "32 samples"),
        (np.zeros(64), 0.1, "hardly|changes by 0"),
        (np.full(64, np.nan), 0.1, "sample 1 is not a finite number"),
        (np.arange(64.0), 0.0, "positive"),
    ],
)
def test_a_pressure_that_cannot_be_says_why(values, period, words):
    with pytest.raises(InputError, match=words):
        VentricularPressure(values, period)


def test_two_columns_without_a_name_for_one_are_refused(tmp_path):
    file = tmp_path / "rv.csv"
    file.write_text("time [s],a,b\n" + "\n".join(f"{k / 1000},1,2" for k in range(40)), encoding="utf-8")
    with pytest.raises(InputError, match="not one alone has a unit"):
        read_ventricle(file)


def test_titles_of_another_language_are_known_by_their_units(tmp_path):
    time = np.arange(2000) / 1000
    file = tmp_path / "rv.csv"
    rows = "\n".join(f"{1000 * a:.1f};{b * 0.13332236842:.5f}".replace(".", ",") for a, b in zip(time, pressure(time)))
    file.write_text(f"Zeit [ms];RV-Druck [kPa]\n{rows}\n", encoding="cp1252")
    found = read_ventricle(file)
    assert found.period == pytest.approx(PERIOD, rel=0.01)
    assert found.beats > 14
    assert found.pressure.max() == pytest.approx(30.0, abs=0.1)


def test_beats_without_their_time_are_not_taken_for_one_cycle(tmp_path):
    file = tmp_path / "rv.txt"
    file.write_text("\n".join(f"{value:.4f}" for value in pressure(np.arange(990) / 1000)), encoding="utf-8")
    with pytest.raises(InputError, match="9 beats and no column of time"):
        read_ventricle(file, PERIOD)
