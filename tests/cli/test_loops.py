"""The command on loops of pressure and volume."""

import pandas as pd
import pytest
from numpy.random import default_rng
from typer.testing import CliRunner

import vasowave as vw
from made_ventricle import made_ventricles
from vasowave.cli.app import app


def said(*words):
    result = CliRunner().invoke(app, ["loops", *map(str, words)])
    if result.exception and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result.output


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    (made,) = made_ventricles(default_rng(4), ("cosine",), ("mouse",), drift=0.0, breaths=0.0)
    path = tmp_path_factory.mktemp("loops") / "occlusion.csv"
    table = {"time [s]": made.time, "LVP [mmHg]": made.pressure, "Volume": 1000 * made.volume}
    pd.DataFrame(table).to_csv(path, index=False)
    return path


def test_numbers_beats_and_figure_are_written_as_they_are_told(file, tmp_path):
    places = tmp_path / "n.csv", tmp_path / "b.csv", tmp_path / "f.svg"
    text = said(file, "--unit", "volume=ul", "-o", places[0], "--beats", places[1], "--plot", places[2])
    numbers = pd.read_csv(places[0], index_col="quantity")
    for name, row in numbers.iterrows():
        (line,) = (line for line in text.splitlines() if line.split()[:1] == [name])
        assert float(line.split()[1]) == pytest.approx(row["value"], rel=1e-3)
    assert {"E_es", "V_0", "PRSW", "E_a", "coupling"} <= set(numbers.index)
    beats = pd.read_csv(places[1])
    assert beats["SV [ml]"][beats["state"] != "left out"].between(0.001, 0.1).all()
    drawing = places[2].read_text("utf-8")
    assert "volume [µl]" in drawing
    assert "pressure [mmHg]" in drawing


def test_what_is_typed_wrongly_is_refused_before_anything_is_read(file, tmp_path):
    for words, complaint in (
        (("--family", "3"), "write two times"),
        (("--unit", "flow=ul"), "write pressure=… or volume=…"),
        (("-o", tmp_path / "n.txt"), "the name of this file ends in .csv"),
    ):
        with pytest.raises(vw.errors.InputError, match=complaint):
            said(file, *words)


def test_a_figure_is_drawn_in_an_axes_that_is_given(file):
    from matplotlib.figure import Figure

    function = vw.pressure_volume(vw.read_loops(file, volume_unit="ul"))
    ax = Figure().subplots()
    assert function.plot(ax) is ax
    assert len(ax.lines) == len(set(function.family) | set(function.steady)) + 3


def test_a_delay_that_is_told_is_typed_and_then_told_no_more(file, tmp_path):
    table = pd.read_csv(file)
    late = table["Volume"].shift(12).bfill()  # 6 ms
    pd.DataFrame({"time [s]": table["time [s]"], "LVP [mmHg]": table["LVP [mmHg]"]}).to_csv(tmp_path / "p.csv")
    pd.DataFrame({"time [s]": table["time [s]"], "LVV [ul]": late}).to_csv(tmp_path / "v.csv", index=False)
    text = said(tmp_path / "p.csv", tmp_path / "v.csv")
    (typed,) = (word for word in text.split() if word.startswith("--volume-delay="))
    assert float(typed.partition("=")[2]) == pytest.approx(0.006, abs=0.0012)
    assert "--volume-delay" not in said(tmp_path / "p.csv", tmp_path / "v.csv", typed)


def test_the_figure_without_a_family_says_what_its_marks_are(file):
    from matplotlib.figure import Figure

    steady = vw.pressure_volume(vw.read_loops(file, volume_unit="ul", end=0.8))
    assert not steady.family
    legend = steady.plot(Figure().subplots()).get_legend()
    assert [text.get_text() for text in legend.get_texts()] == ["end of systole", "end of diastole"]
