"""What commands make of the words that are typed, and what they say, without computing anything."""

import os
import resource
from importlib import import_module
from types import SimpleNamespace
from unittest import mock

import pandas as pd
import pytest

from vasowave import __main__ as main_module
from vasowave import cli
from vasowave.cli import extract, fit, models, options, progress, simulate, study, watching
from vasowave.errors import InputError, VasowaveError, VasowaveWarning
from vasowave.network.network import Network
from vasowave.settings import Setting

app_module = import_module("vasowave.cli.app")  # in the package itself this name is the program


@pytest.fixture(autouse=True)
def environment_of_its_own():
    """Put back what a program sets for all that it starts."""
    with mock.patch.dict(os.environ):
        yield


@pytest.mark.parametrize(("count", "words"), [(0, "0 rows"), (1, "1 row"), (2, "2 rows")])
def test_things_are_counted(count, words):
    assert study._counted(count, "row") == words


@pytest.mark.parametrize(
    ("default", "shown"),
    [
        (None, False),
        ({}, False),
        (["a", "b"], "a,b"),
        ((1, 2), "1,2"),
        (0.50, "0.5"),
        (True, "true"),
        ("Word", "word"),
        (3, "3"),
    ],
)
def test_defaults_are_shown_as_they_are_typed(default, shown):
    assert options._shown(default) == shown


def test_words_of_options_become_lists_pairs_and_single_values():
    of_list = Setting(tuple[str, ...], (), "")
    assert options._value(of_list, "a, b") == ["a", "b"]
    assert options._value(Setting(str, "", ""), "a, b") == "a, b"
    assert options._value(Setting(dict, {}, ""), ["beta=10:400", " r1 = 2 "]) == {"beta": ["10", "400"], "r1": " 2 "}
    assert options._is_list(tuple[float, float] | None)
    assert not options._is_list(float | None)
    assert options.flag("paper_bounds") == "--paper-bounds"


def test_cells_of_a_row_are_taken_out_of_the_options():
    given = {"period": " 0.1 ", "unit": ["flow=ml/min", "pressure = kPa"], "channel": ["ecg=II"], "starts": "3"}
    assert options.row_cells(given) == {
        "period [s]": "0.1", "flow unit": "ml/min", "pressure unit": "kPa", "ecg channel": "II"
    }  # fmt: skip
    assert given == {"starts": "3"}
    for wrong in ("flwo=x", "flow", "flow="):
        with pytest.raises(InputError, match=rf"--unit {wrong}: write pressure=… or flow=…"):
            options.row_cells({"unit": [wrong]})
    with pytest.raises(InputError, match="did you mean 'flow'"):
        options.row_cells({"unit": ["flwo=x"]})
    with pytest.raises(InputError, match="--unit ecg=mV"):
        options.row_cells({"unit": ["ecg=mV"]})


def test_a_problem_of_options_is_named_by_its_option():
    given = options.GivenOptions("options", {"calibration": {"starts": "x"}})
    assert given.place(("calibration", "starts")).part == "--starts"
    assert given.place(()).part == "options"
    assert given.place(("calibration",)).part == "--calibration"


@pytest.mark.parametrize(("text", "values"), [("1:2:3", [1.0, 1.5, 2.0]), ("4, 5", [4.0, 5.0]), ("7", [7.0])])
def test_values_to_vary_are_ranges_or_lists(text, values):
    assert simulate._numbers("beta", text) == values


@pytest.mark.parametrize("text", ["1:2", "1:2:x", "a", ""])
def test_what_is_no_range_is_told_how_to_write_one(text):
    with pytest.raises(InputError, match=f"beta={text}: write one number, one,other or from:to:count"):
        simulate._numbers("beta", text)


def test_names_are_given_once_with_a_number():
    assert simulate._pairs(["a= 1", "b =2.5"]) == {"a": 1.0, "b": 2.5}
    with pytest.raises(InputError, match="'a': write NAME=VALUE, for example beta=60"):
        simulate._pairs(["b=1", "a"])
    with pytest.raises(InputError, match="'a' is given twice; name it once"):
        simulate._pairs(["a=1", "b=2", "a=3"])
    with pytest.raises(InputError, match="a=1,2: write one number"):
        simulate._pairs(["a=1,2"])


def narrowed(monkeypatch, *texts):
    seen = []
    monkeypatch.setattr(
        "vasowave.model.losses.narrowed", lambda model, *given, **more: seen.append((*given, more["stiffer"])) or model
    )
    models.narrowed_model("model", texts)
    return seen


def test_narrowings_are_typed_by_vessel_share_and_length(monkeypatch):
    assert narrowed(monkeypatch, "2=0.8,0.05", "a=b=0.5,0.1,20") == [("2", 0.8, 0.05, 1.0), ("a=b", 0.5, 0.1, 20.0)]
    for wrong in ("2=0.8", "=0.8,0.05", "2=0.8,0.05,1,2", "2=x,1", "2"):
        with pytest.raises(InputError, match=f"--narrow {wrong}: write VESSEL=SHARE,CM"):
            narrowed(monkeypatch, wrong)


def test_places_that_bring_their_model_are_folders_and_openbfs_files(tmp_path):
    assert models.brings_its_model(tmp_path)
    assert models.brings_its_model(tmp_path / "x.YML")
    assert not models.brings_its_model(tmp_path / "x.csv")
    numerics = models.numerics_from(0.2, None)
    assert numerics.cell_size == 0.2
    assert models.numerics_from(None, None) == type(numerics)()
    with pytest.raises(InputError, match=r"unknown friction 'poisseuille' \(did you mean 'poiseuille'\?\); there are:"):
        models.model_from(tmp_path, [], None, "", ("", ""), "poisseuille")
    with pytest.raises(InputError, match="leave the recording out"):
        models.model_from(tmp_path, [tmp_path], None, "", ("", ""), "")
    with pytest.raises(InputError, match="leave --bed out"):
        models.model_from(tmp_path, [], None, "", ("", "windkessel"), "")
    with pytest.raises(InputError, match="openBF's wall is the linear one"):
        models._openbf(tmp_path / "x.yaml", "tangent")


def test_lengths_are_numbers_of_cm_or_units():
    assert extract._length_unit("0.0036") == 0.0036
    assert extract._length_unit("mm") == 0.1
    one = Network(("a", "b"), [-1, 0], [0.3, 0.2], [0.05, 0.04])
    other = Network(("x", "y"), [-1, 0], [0.4, 0.1], [0.06, 0.03])
    assert extract._pair_lines(one, other, {1: 1, 0: 0}) == [
        "first,second,length_first [cm],length_second [cm],radius_first [cm],radius_second [cm]",
        "a,x,0.3,0.4,0.05,0.06", "b,y,0.2,0.1,0.04,0.03",
    ]  # fmt: skip


def test_stages_are_lines_where_there_is_no_terminal(capsys):
    with extract._stages() as say:
        say("reading")
    assert capsys.readouterr().err == "reading …\n"


def test_a_posterior_is_told_in_columns_and_by_its_diagnostics(capsys):
    summary = pd.DataFrame(
        {"median": [1.23456, 80.0], "interval_low": [1.0, 70.0], "interval_high": [1.5, 91.26], "prior_low": [0.5, 1.0],
         "prior_high": [2.0, 999.0], "unit": ["1", "mmHg s/ml"]}, index=["r1", "R_T"],
    )  # fmt: skip
    diagnostics = SimpleNamespace(trusted=True, k_hat=0.333, effective=120.4, draws=400, simulations=900, harmonics=9,
                                  log_evidence=-12.345, log_evidence_error=0.067)  # fmt: skip
    fit._say(SimpleNamespace(summary=summary, diagnostics=diagnostics, findings=["late"]))
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].split() == ["median", "95", "%", "interval", "prior", "95", "%", "unit"]
    assert lines[1].split() == ["r1", "1.235", "[1,", "1.5]", "[0.5,", "2]"]
    assert lines[2].split() == ["R_T", "80", "[70,", "91.3]", "[1,", "999]", "mmHg", "s/ml"]
    assert lines[3] == (
        "The sampling succeeded: Pareto k 0.33, 120 of 400 draws effective, 900 simulations, 9 harmonics compared, ln "
        "evidence -12.35 ± 0.07"
    )
    assert lines[4] == "note: late"


def test_a_folder_of_a_fit_brings_all_and_what_is_left_is_named(tmp_path):
    with pytest.raises(InputError, match=r"leave out r.csv, --paper-bounds, --bed$"):
        fit._known(tmp_path, ["r.csv"], "", ("", "windkessel"), {"paper_bounds": True})
    with pytest.raises(InputError, match=r"leave out --bed$"):
        fit._known(tmp_path, [], "", ("", "windkessel"), {})


def test_the_study_of_a_command_is_the_first_place_or_this_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    made = tmp_path / "study"
    made.mkdir()
    (made / "study.yaml").write_text("")
    (tmp_path / "a.csv").write_text("")
    assert study._study_here(made, [tmp_path / "a.csv"]) == (made, [tmp_path / "a.csv"])
    assert study._study_here(made / "study.yaml", [made]) == (made / "study.yaml", [made])
    with pytest.raises(InputError, match="which files"):
        study._study_here(made, [])
    with pytest.raises(InputError, match=r"a.csv is no study; name the study's folder before the files"):
        study._study_here(tmp_path / "a.csv", [tmp_path / "a.csv"])
    (tmp_path / "study.yaml").write_text("")
    here, files = study._study_here(tmp_path / "a.csv", [made])
    assert (str(here), files) == (".", [tmp_path / "a.csv", made])
    assert study._typed(tmp_path / "my study") == f"'{tmp_path}/my study'"


def test_long_words_are_wrapped_on_a_terminal_alone(monkeypatch, capsys):
    class Terminal:
        def __init__(self, stderr):
            self.is_terminal = terminal

    monkeypatch.setattr(progress, "Console", Terminal)
    monkeypatch.setattr(progress, "terminal_width", lambda: 25)
    terminal = True
    progress.tell("one two three four five six")
    assert capsys.readouterr().out == "one two three four five\n  six\n"
    terminal = False
    progress.tell("one two three four five six", err=True)
    assert capsys.readouterr().err == "one two three four five six\n"
    monkeypatch.setattr(progress, "terminal_width", lambda: 5)
    terminal = True
    progress.tell("one two three four five")
    assert capsys.readouterr().out == "one two three four\n  five\n"


def test_the_expected_time_is_told_in_whole_minutes_and_at_least_one(monkeypatch, capsys):
    settings = SimpleNamespace(
        calibration=SimpleNamespace(walls=("linear", "tangent"), starts=20), design=SimpleNamespace(subject=None)
    )  # fmt: skip
    monkeypatch.setattr("vasowave.study.overview.overview_lines", lambda read, width: ["table"])
    monkeypatch.setattr("vasowave.runtime.threads.cores", lambda: 2)

    def told(seconds, subject=None):
        settings.design.subject = subject
        monkeypatch.setattr("vasowave.study.overview.expected_seconds", lambda *given: seconds)
        progress.show_read([1, 2, 3], settings)
        return capsys.readouterr().out.splitlines()

    assert told(80.0) == [
        "table", "Animals 3; wall laws linear, tangent; 20 starts of each fit: roughly 1 min to compute here (2 "
        "cores), less"
        " where results are kept.",
    ]  # fmt: skip
    assert "Recordings 3;" in told(100.0, "mouse")[1]
    assert "roughly 2 min" in told(100.0)[1]
    assert "roughly 1 min" in told(1.0)[1]


def test_memory_is_told_in_megabytes(monkeypatch):
    monkeypatch.setattr(resource, "getrusage", lambda who: SimpleNamespace(ru_maxrss=3 * 1024))
    monkeypatch.setattr(app_module.sys, "platform", "linux")
    assert app_module._memory() == ", 3 MB at most"
    monkeypatch.setattr(app_module.sys, "platform", "darwin")
    assert app_module._memory() == ", 0 MB at most"


@pytest.mark.parametrize(
    ("error", "status", "said"),
    [
        (InputError("wrong"), 1, "Error: wrong\n"), (VasowaveError("odd"), 3, "Error: odd\n"),
        (MemoryError(), 3, "Error: out of memory; what had finished is kept; give this program more of it and run again"
                           "\n"),
        (SystemExit(130), 130, "Interrupted; nothing half-written was left.\n"), (SystemExit(2), 2, ""),
    ],
)  # fmt: skip
def test_a_program_ends_with_a_sentence_and_a_status(monkeypatch, capsys, error, status, said):
    def app():
        raise error

    monkeypatch.setattr(cli, "app", app)
    monkeypatch.setattr(cli.warnings, "showwarning", None)
    monkeypatch.setattr(cli.sys, "unraisablehook", None)
    with pytest.raises(SystemExit) as left:
        cli.run()
    assert left.value.code == status
    assert capsys.readouterr().err == said


def test_our_warnings_are_lines_and_what_nobody_foresaw_is_raised(monkeypatch, capsys):
    def app():
        cli.warnings.showwarning("ours", VasowaveWarning, "f", 1)
        cli.warnings.showwarning("theirs", UserWarning, "f", 1)
        raise KeyError("x")

    monkeypatch.setattr(cli, "app", app)
    monkeypatch.setattr(cli.warnings, "showwarning", None)
    monkeypatch.setattr(cli.sys, "unraisablehook", None)
    with pytest.raises(KeyError):
        cli.run()
    assert capsys.readouterr().err == "Warning: ours\n"


def test_the_program_itself_ends_at_an_interrupt_and_at_a_file_that_steers_the_compiler(monkeypatch, tmp_path):
    def interrupted():
        raise KeyboardInterrupt

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(main_module, "leave_folder", lambda: None)
    monkeypatch.setattr("vasowave.cli.run", interrupted)
    with pytest.raises(SystemExit) as left:
        main_module.main()
    assert left.value.code == 130
    (tmp_path / ".numba_config.yaml").write_text("")
    with pytest.raises(SystemExit, match="would change how the solver is compiled; remove it"):
        main_module.main()


def test_the_folder_of_the_command_is_no_place_of_modules(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(main_module.sys, "path", ["", str(tmp_path), str(tmp_path / "other")])
    monkeypatch.delenv("PYTHONSAFEPATH", raising=False)
    main_module.leave_folder()
    assert main_module.sys.path == [str(tmp_path / "other")]
    assert main_module.os.environ["PYTHONSAFEPATH"] == "1"


def test_stages_of_an_animal_are_words():
    assert watching._stage({"linear": (4, 4), "tangent": (4, 4)}) == "tangent wall fitted, going on"
    assert watching._stage({"linear": (3, 4)}) == "linear wall, 3 of 4 searches"
    assert watching._stage({"linear, posterior": (30, 0)}) == "linear, posterior, 30 simulations"
