"""The command that says what a recording alone tells."""

import re

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

import vasowave as vw
from vasowave.base import InputError
from vasowave.catheter import Disturbances, synthetic_raw_recording
from vasowave.cli.app import app


def said(*words):
    result = CliRunner().invoke(app, ["indices", *map(str, words)])
    if result.exception and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result.output


def test_a_cycle_is_told_in_numbers_with_units_and_beats_as_a_table(tmp_path):
    mouse = vw.virtual_mouse()
    mouse.to_dataframe().to_csv(tmp_path / "cycle.csv")
    text = said(tmp_path / "cycle.csv")
    values = vw.cycle_indices(mouse).values
    for name, unit in (("SV", "ml"), ("power", "mW"), ("dp_dt_max", "mmHg/s")):
        (line,) = (line for line in text.splitlines() if line.split()[:1] == [name])
        assert line.split()[2] == unit
        assert float(line.split()[1]) == pytest.approx(values[name], rel=1e-3)
    words = ["indices", str(tmp_path / "cycle.csv"), "-o", str(tmp_path / "beats.csv")]
    result = CliRunner().invoke(app, words)
    assert "holds one averaged cycle" in result.output
    assert result.exit_code == 3


def test_beats_of_a_continuous_recording_are_a_row_each(tmp_path):
    raw = synthetic_raw_recording(vw.virtual_mouse(), np.random.default_rng(3), duration=4.0).raw
    time = np.arange(len(raw.pressure)) / raw.sampling_rate
    table = pd.DataFrame({"time [s]": time, "pressure [mmHg]": raw.pressure, "flow [ml/s]": raw.flow})
    table.to_csv(tmp_path / "raw.csv", index=False)
    text = said(tmp_path / "raw.csv", "--set", "averaging.beats=10", "-o", tmp_path / "beats.csv")
    assert "averaged cycle of 10 beats ± SD of single beats" in text
    beats = pd.read_csv(tmp_path / "beats.csv", index_col="start [s]")
    assert len(beats) == 10
    (line,) = (line for line in text.splitlines() if line.split()[:1] == ["SV"])
    said(tmp_path / "raw.csv", "--wedge", 8, "--set", "catheter=80,0.4", "-o", tmp_path / "corrected.csv")
    cycle = said(tmp_path / "raw.csv", "--wedge", 8, "--set", "catheter=80,0.4").splitlines()
    corrected = pd.read_csv(tmp_path / "corrected.csv")
    for name, unit in (("PVR", "mmHg s/ml"), ("RC", "s"), ("dp_dt_max", "mmHg/s")):  # of beats as of their cycle
        (value,) = (float(row.split()[1]) for row in cycle if row.split()[:1] == [name])
        assert corrected[f"{name} [{unit}]"].mean() == pytest.approx(value, rel=0.1)
    assert float(line.split()[3]) == pytest.approx(beats["SV [ml]"].std(ddof=1), rel=0.05)


def test_a_table_that_cannot_be_written_is_refused_before_anything_is_read(tmp_path):
    with pytest.raises(vw.errors.InputError, match=r"beats\.xyz"):
        said(tmp_path / "nothing.csv", "-o", tmp_path / "beats.xyz")


def test_an_option_of_one_value_that_is_typed_twice_is_refused_and_those_of_many_are_not(tmp_path):
    table = vw.virtual_mouse().to_dataframe().rename(columns=lambda name: name.partition(" [")[0])
    table.to_csv(tmp_path / "cycle.csv")
    file = tmp_path / "cycle.csv"
    assert "--wedge is given 2 times" in said(file, "--wedge", 3, "--wedge", 4)
    assert "--output is given 2 times" in said(file, "-o", "a.csv", "--output", "b.csv")
    with pytest.raises(InputError, match="the unit of flow is given twice; give it once"):
        said(file, "--unit", "flow=ml/s", "--unit", "flow=ml/min")
    assert "given 2 times" not in said(file, "--unit", "pressure=mmHg", "--unit", "flow=ml/s")


def test_pvr_says_that_it_counts_from_zero_and_what_it_is_over_whole_breaths(tmp_path):
    breaths = Disturbances(ventilation_pressure=3.0)
    raw = synthetic_raw_recording(vw.virtual_mouse(), np.random.default_rng(4), duration=5.0, disturbances=breaths).raw
    time = np.arange(len(raw.pressure)) / raw.sampling_rate
    signals = {"time [s]": time, "pressure [mmHg]": raw.pressure, "flow [ml/s]": raw.flow, "ECG [mV]": raw.ecg}
    pd.DataFrame(signals).to_csv(tmp_path / "raw.csv", index=False)
    text = " ".join(said(tmp_path / "raw.csv").split())
    assert "PVR and RC count from 0 mmHg" in text
    assert "--wedge=VALUE" in text
    text = " ".join(said(tmp_path / "raw.csv", "--wedge", 8).split())
    assert "count from 0 mmHg" not in text
    (stated,) = re.findall("if the breath does not move the wedge pressure, it is ([0-9.]+)", text)
    whole = said(tmp_path / "raw.csv", "--wedge", 8, "--set", "averaging.reject_ventilation=false")
    (line,) = (line for line in whole.splitlines() if line.split()[:1] == ["PVR"])
    assert float(stated) == pytest.approx(float(line.split()[1]), rel=0.01)
    assert "does not move the wedge" not in whole


def test_the_help_names_the_row_of_a_subject_and_nothing_of_a_ventricle():
    assert "--subject-row" in said("--help")
    assert "No such option" in said("a.csv", "--loops", "b.csv")
