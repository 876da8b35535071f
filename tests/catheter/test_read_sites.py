"""Tables of sites and the waveforms that they name."""

import numpy as np
import pytest

import vasowave as vw
from vasowave.base import InputError


def written(folder, text, **files):
    for name, content in files.items():
        (folder / f"{name}.csv").write_text(content)
    (folder / "sites.csv").write_text(text)
    return folder / "sites.csv"


def test_numbers_and_waveforms_are_read_in_the_unit_of_the_table(tmp_path):
    t = np.arange(41) / 400
    rows = "\n".join(f"{a:.4f},{1 + np.sin(2 * np.pi * a / 0.1):.6f}" for a in t)  # the last repeats the first
    path = written(
        tmp_path,
        "quantity,vessel,place [mm],file,mean,unit,error,zero sd,gain sd\n"
        "pressure,LPA,2,wave.csv,,kPa,0.01,0.1,\nflow,RPA,,,80,ul/s,8,,0.1\n",
        wave=f"time [s],pressure [kPa]\n{rows}\n",
    )
    one, other = vw.read_sites(path)
    assert (one.quantity, one.vessel, one.cm, len(one.waveform)) == ("pressure", "LPA", 0.2, 40)
    assert one.period == pytest.approx(0.1)
    assert one.waveform.mean() == pytest.approx(7.50062, rel=1e-5)
    assert (one.error, one.zero_sd) == (pytest.approx(0.0750062, rel=1e-5), pytest.approx(0.750062, rel=1e-5))
    assert (other.place, other.mean, other.error, other.gain) == (0.5, pytest.approx(0.08), pytest.approx(0.008), 0.1)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("quantity,vessel,unit,error,men\nflow,a,ml/s,1,2\n", "unknown column 'men' .did you mean 'mean'"),
        ("quantity,vessel,unit\nflow,a,ml/s\n", "no column 'error'"),
        ("quantity,vessel,unit,error,mean\nflw,a,ml/s,1,2\n", "line 2: 'flw' cannot be observed"),
        ("quantity,vessel,unit,error,mean\nflow,a,mmHg,1,2\n", "line 2: 'mmHg' is not a unit of flow"),
        ("quantity,vessel,unit,error,mean\nflow,a,ml/s,x,2\n", "line 2: column 'error': 'x' is not a number"),
        ("quantity,vessel,unit,error,mean\nflow,a,ml/s,,2\n", "line 2: the cell 'error' is empty"),
        ("quantity,vessel,unit,error,mean\nflow,a,,1,2\n", "line 2: the cell 'unit' is empty"),
        ("quantity,vessel,unit,error,file\nflow,a,ml/s,1,no.csv\n", "line 2: there is no file"),
        ("quantity,vessel,unit,error,file\nflow,a,ul/s,1,wave.csv\n", "its header says ml/s, the table of sites says"),
        ("quantity,vessel,unit,error\nflow,a,ml/s,1\n", "give a waveform, or at least one of mean"),
        ("quantity,vessel,place,unit,error,mean\nflow,a,1.5,ml/s,1,2\n", "lies outside the vessel"),
        (
            "quantity,vessel,place,unit,error,mean\nflow,a,,ml/s,1,2\nflow,b,,ml/s,1,2\nFlow,a,0.5,ml/s,3,2\n",
            "line 4: the same values of the same place stand in line 2 already",
        ),
    ],
)
def test_what_is_wrong_is_named_with_its_line(tmp_path, text, message):
    wave = "\n".join(["flow [ml/s]", *map(str, np.sin(np.arange(64) / 10))])
    with pytest.raises(InputError, match=message):
        vw.read_sites(written(tmp_path, text, wave=wave + "\n"))


@pytest.mark.parametrize(
    ("given", "why"),
    [
        ({"mean": 1.0, "systolic": 0.5}, "must rise in this order"),
        ({"systolic": 20.0, "diastolic": 20.0}, "must rise in this order"),
        ({"diastolic": 1.0, "mean": 0.9}, "must rise in this order"),
        ({"mean": 0.0}, "says nothing of its size"),
        ({"waveform": np.full(64, 0.1)}, "the same number throughout"),
        ({}, "give a waveform, or at least one of"),
        ({"mean": 1.0, "waveform": np.sin(np.arange(64))}, "give a waveform, or at least one of"),
        ({"mean": 1.0, "error": None}, "error is None"),
        ({"mean": 1.0, "error": "a"}, "error is 'a'"),
        ({"mean": 1.0, "error": 0.0}, "error 0 is not valid"),
        ({"mean": 1.0, "place": "x"}, "place is 'x'"),
        ({"mean": 1.0, "place": 1.01}, r"place 1\.01 lies outside"),
        ({"mean": 1.0, "place": -0.01}, r"place -0\.01 lies outside"),
        ({"mean": 1.0, "cm": -0.1}, r"-0\.1 cm lies before the vessel"),
        ({"mean": 1.0, "cm": 0.1, "place": 0.5}, "give one of them"),
        ({"mean": 1.0, "gain_sd": "x"}, "gain_sd is 'x'"),
        ({"mean": 1.0, "gain_sd": 2.01}, r"gain_sd 2\.01 is not valid"),
        ({"mean": 1.0, "zero_sd": -0.1}, r"zero_sd -0\.1 is not valid"),
        ({"quantity": "diameter", "diastolic": -0.1, "systolic": 0.2}, "is no vessel's"),
        ({"quantity": "presure", "mean": 1.0}, r"cannot be observed \(did you mean 'pressure'\?\)"),
    ],
)
def test_what_cannot_be_observed_is_refused(given, why):
    with pytest.raises(InputError, match=why):
        vw.Observation(**({"quantity": "flow", "vessel": "b", "error": 0.1} | given))


def test_one_place_says_the_unit_and_a_gain_may_be_in_percent(tmp_path):
    head = "quantity,vessel,mean,unit,error"
    (tmp_path / "sites.csv").write_text("quantity,vessel,mean [ul/s],unit,error\nflow,b,80,ml/s,1\n")
    with pytest.raises(InputError, match=r"column 'mean \[ul/s\]': the column 'unit' says the unit"):
        vw.read_sites(tmp_path / "sites.csv")
    (tmp_path / "sites.csv").write_text(f"{head},gain sd [%]\nflow,b,80,ul/s,1,7\n")
    assert vw.read_sites(tmp_path / "sites.csv")[0].gain_sd == pytest.approx(0.07)


def test_a_waveform_that_rests_at_both_ends_keeps_its_last_sample_and_so_its_period(tmp_path):
    t = np.arange(40) / 400
    values = np.where((t > 0.02) & (t < 0.06), np.sin(np.pi * (t - 0.02) / 0.04), 0.0)  # a flow with a long diastole
    rows = "\n".join(f"{a:.4f},{q:.6f}" for a, q in zip(t, values, strict=True))
    path = written(tmp_path, "quantity,vessel,file,unit,error\nflow,RPA,wave.csv,ml/s,0.01\n",
                   wave=f"time [s],flow [ml/s]\n{rows}\n")  # fmt: skip
    (one,) = vw.read_sites(path)
    assert len(one.waveform) == 40
    assert one.period == pytest.approx(0.1)


def test_two_measurements_of_one_place_are_two(tmp_path):
    path = written(tmp_path, "quantity,vessel,place,unit,error,mean\nflow,a,0.5,ml/s,1,2\nflow,a,0.5,ml/s,1,2.1\n")
    assert [one.mean for one in vw.read_sites(path)] == [2.0, 2.1]
