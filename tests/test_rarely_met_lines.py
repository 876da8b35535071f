"""Lines that only a rare mistake, or one door alone, runs: what they refuse, what they say, what they assume."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

import vasowave as vw
from vasowave.calibration.generalized import objective_of
from vasowave.cli import fit as cli_fit
from vasowave.cli.progress import tell, terminal_width
from vasowave.cohort.designed import occasions_apart
from vasowave.errors import InputError
from vasowave.figures import fitted
from vasowave.inference import rounds
from vasowave.inference.mixture import Component
from vasowave.inference.result import Posterior
from vasowave.study import physiology
from vasowave.study.adding import _settings
from vasowave.workbench.cohorts import Cohorts
from vasowave.workbench.explorer import _file
from vasowave.workbench.running import Runs


def test_what_is_assumed_where_nothing_is_said():
    priors = vw.Priors()
    assert (priors.radius, priors.length, priors.taper, priors.taper_scale, priors.wedge) == (0.05, 0.05, 0.3, 0.1, 0.0)
    assert priors.discrepancy == (0.03, 0.7)
    assert dict(priors.parameters) == {}
    for name in ("radius", "length", "taper", "taper_scale"):
        assert getattr(vw.Priors(**{name: 2.0}), name) == 2.0
        assert getattr(vw.Priors(**{name: 0.0}), name) == 0.0
        with pytest.raises(InputError):
            vw.Priors(**{name: 2.01})
        with pytest.raises(InputError):
            vw.Priors(**{name: -0.01})
    assert vw.Priors(discrepancy=(0.2, 0.0)).discrepancy == (0.2, 0.0)
    for pair in ((0.0, 0.7), (0.21, 0.7), (0.03, 2.01)):
        with pytest.raises(InputError):
            vw.Priors(discrepancy=pair)
    with pytest.raises(InputError):
        vw.Priors(wedge=-0.1)


def test_a_component_taught_more_has_had_one_round_more(monkeypatch):
    told = []

    def learned(target, points, outputs, walkers, before):
        told.append((points, outputs, walkers, before))
        return "new"

    monkeypatch.setattr(rounds, "_learned", learned)
    old = Component("old", np.ones((2, 1)), np.ones((2, 3)), np.zeros((4, 1)), (), 3)
    found = rounds.taught(None, old, np.full((1, 1), 5.0), np.full((1, 3), 7.0))
    assert (found.surrogate, found.rounds, len(found.points), len(found.outputs)) == ("new", 4, 3, 3)
    assert (found.points[-1, 0], found.outputs[-1, 0]) == (5.0, 7.0)
    assert found.walkers is old.walkers
    assert told[0][2].tolist() == [[5.0]]
    assert told[0][3] == "old"


def test_only_parameters_of_the_wall_can_be_held():
    table = pd.DataFrame({"value": [1.0, 2.0]}, index=["R1", "C1"])
    with pytest.raises(InputError, match="the linear wall has no parameter 'c9'; it has: R1, C1"):
        objective_of(SimpleNamespace(parameters=table, wall="linear"), {"R1": 1.0, "c9": 2.0}, None, 1)


def test_without_values_or_subjects_nothing_tells_how_far_apart_occasions_are():
    assert occasions_apart(SimpleNamespace(design=SimpleNamespace(subject=("a", "a"))), None) == 0.0
    assert occasions_apart(SimpleNamespace(design=SimpleNamespace(subject=())), "values") == 0.0


def test_rows_are_not_added_to_a_workbook_nor_under_a_broken_study_file(tmp_path):
    study = tmp_path / "study.yaml"
    study.write_text("animals: Mice.XLSX\n")
    with pytest.raises(InputError, match=r"Mice\.XLSX: rows are added to CSV only; save it as CSV"):
        _settings(study)
    study.write_text("animals: mice.csv\n")
    assert _settings(study).animals == "mice.csv"
    study.write_text("no such key: 1\n")
    with pytest.raises(InputError, match="mend the study file first"):
        _settings(study)


def test_a_warning_is_given_for_every_number_that_is_no_bloods(monkeypatch):
    told = []
    monkeypatch.setattr(physiology, "warn", lambda one, stacklevel: told.append((one, stacklevel)))
    monkeypatch.setattr(physiology, "blood_findings", lambda blood: [blood, "second"])
    physiology.tell_blood("first")
    assert told == [("first", 3), ("second", 3)]


def test_what_the_pages_ask_for_in_vain_is_called_by_its_first_eighty_letters():
    with pytest.raises(InputError) as caught:
        _file(SimpleNamespace(stored=dict), "b" * 99)
    assert str(caught.value) == f"there is no result of '{'b' * 80}'"
    cohort = SimpleNamespace(symbols={})
    groups = []

    def gathered(results, group):
        groups.append(group)
        return cohort

    for results, group in (([], None), ([SimpleNamespace(group="CTL"), SimpleNamespace(group="PH")], "CTL")):
        stored = SimpleNamespace(in_order=lambda whole, results=results: results, gathered=gathered)
        with pytest.raises(InputError) as caught:
            Cohorts().means(SimpleNamespace(stored=lambda stored=stored: stored), "c" * 99)
        assert str(caught.value) == f"no animal has a quantity '{'c' * 80}'"
        assert groups.pop() == group


def test_a_second_run_is_refused_by_who_runs_the_first(monkeypatch):
    monkeypatch.setattr(Runs, "runner", lambda self, desk: "process 7 on a")
    running = Runs()
    assert running.program is None
    assert running.stops_with_us is False
    with pytest.raises(InputError, match="the study is being run by process 7 on a already"):
        running.start(None)


SUMMARY = pd.DataFrame(
    {
        "median": [1.23456, 20.0],
        "interval_low": [1.0, 10.0],
        "interval_high": [1.5678, 40.0],
        "prior_low": [0.1, 5.0],
        "prior_high": [9.8765, 50.0],
        "unit": ["1", "mmHg s/ml"],
    },
    index=["c1", "R1"],
)


def test_a_posterior_is_shown_in_one_line_and_as_a_card():
    one = Posterior("linear", None, SUMMARY, SimpleNamespace(k_hat=0.456), None)
    assert repr(one) == "Posterior(linear wall: c1 1.235 [1, 1.57], R1 20 [10, 40]; Pareto k 0.46)"
    page = one._repr_html_()
    assert "Posterior, linear wall" in page
    assert "R1 [mmHg s/ml]" in page
    assert "c1 [" not in page
    assert "1.235 [1, 1.57]" in page


@pytest.mark.parametrize(
    ("trusted", "words"), [(True, "The sampling succeeded"), (False, "Do not believe these numbers")]
)
def test_a_posterior_is_printed_with_names_and_units_to_the_left(capsys, monkeypatch, trusted, words):
    said = []
    monkeypatch.setattr("vasowave.cli.progress.tell", said.append)
    diagnostics = SimpleNamespace(
        trusted=trusted, k_hat=0.456, effective=99.6, draws=400, simulations=77, harmonics=9, log_evidence=-12.345,
        log_evidence_error=0.126,
    )  # fmt: skip
    cli_fit._say(SimpleNamespace(summary=SUMMARY, diagnostics=diagnostics, findings=("odd",)))
    lines = capsys.readouterr().out.splitlines()
    assert [line.split() for line in lines[1:]] == [
        ["c1", "1.235", "[1,", "1.57]", "[0.1,", "9.88]"],
        ["R1", "20", "[10,", "40]", "[5,", "50]", "mmHg", "s/ml"],
    ]
    assert lines[0].index("unit") == lines[2].index("mmHg")
    assert lines[1].startswith("c1")
    assert lines[0].index("median") + 6 == lines[1].index("1.235") + 5 == lines[2].index("20") + 2
    assert said == [
        f"{words}: Pareto k 0.46, 100 of 400 draws effective, 77 simulations, 9 harmonics compared, "
        "ln evidence -12.35 ± 0.13",
        "note: odd",
    ]


def test_the_letters_beside_the_axes_are_one_point_smaller(monkeypatch):
    seen = []

    class Plots:
        def __init__(self, result, color, *, shaded):
            self.how = (result, color, shaded)

        def waves(self, ax):
            import matplotlib

            names = ("font.size", "axes.labelsize", "axes.titlesize", "legend.fontsize", "xtick.labelsize",
                     "ytick.labelsize")  # fmt: skip
            seen.append((self.how, [matplotlib.rcParams[name] for name in names]))

    monkeypatch.setattr(fitted, "FitPlots", Plots)
    monkeypatch.setattr(fitted, "PANELS", ("waves",))
    monkeypatch.setattr(fitted, "as_file", lambda figure, kind: (figure.get_size_inches() * 25.4, kind))
    size, kind = fitted.figure_bytes("fit", ["waves"], "svg", width=120.0, height=60.0, font=9.0, color="#112233")
    assert kind == "svg"
    assert size == pytest.approx([120.0, 60.0])
    fitted.figure_bytes("fit", ["waves"], "svg", width=120.0, height=60.0, font=9.0)
    letters = [9.0, 9.0, 9.0, 8.0, 8.0, 8.0]
    assert seen == [(("fit", "#112233", False), letters), (("fit", fitted.CTL, True), letters)]


@pytest.mark.parametrize("width", [10, 20, 24])
def test_no_word_is_broken_on_a_terminal(capsys, monkeypatch, width):
    asked = []

    def console(stderr):
        asked.append(stderr)
        return SimpleNamespace(is_terminal=width != 24)

    monkeypatch.setattr("vasowave.cli.progress.Console", console)
    monkeypatch.setattr("vasowave.cli.progress.terminal_width", lambda: width)
    text = "one two-three four-five six/" + "x" * 30 + " seven"
    tell(text)
    found = capsys.readouterr()
    broken = "one two-three\n  four-five\n  six/" + "x" * 30 + "\n  seven\n"
    assert (found.out, found.err) == (text + "\n" if width == 24 else broken, "")
    tell(text, err=True)
    assert capsys.readouterr().err == found.out
    assert asked == [False, True]


def test_a_terminal_without_a_width_has_eighty_columns(monkeypatch):
    monkeypatch.setattr("shutil.get_terminal_size", lambda fallback: SimpleNamespace(columns=fallback[0] + 3))
    assert terminal_width() == 83
