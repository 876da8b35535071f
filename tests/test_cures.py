"""Every finding that asks for something says what to do, in the words of the door at which it is met."""

import re
import shlex
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from typer.main import get_command
from typer.testing import CliRunner

import finding_codes as pages
import vasowave as vw
from vasowave.base import KINDS, Cure, SetCells, Severity, ShiftFlowZero, TurnFlow, argument, sentence
from vasowave.cli import Shell, app
from vasowave.cli.signatures import TYPED
from vasowave.pulse.network import write_network
from vasowave.study.entering import new_study
from vasowave.workbench import as_shown

OF_A_SHELL = re.compile(
    r"(?<![\w-])--\w|\bvasowave (add|fit|new|check|run|open|tidy|extract|look|report|centerlines)\b"
)
OF_PYTHON = re.compile(r"\bin Python\b|\bvw\.|\bvasowave\.\w|\w\(\w*=|\w\(\.\.\.|\bdef\b")


@pytest.fixture(scope="module")
def asking():
    pages.load_all()
    return {code: kind for code, kind in KINDS.items() if kind.severity is not Severity.NOTE}


class AnyValue(float):
    """A value of a finding that takes every format of a number, and of a text."""

    def __format__(self, form):
        return super().__format__(form) if form and form[-1] in "efg%d" else "1"


def made(kind):
    names = re.findall(r"\{(\w+)", "".join([kind.text, kind.remedy, *map(str, kind.cures)]))
    return kind(**{name: AnyValue(1.0) for name in names if name not in ("remedy", "animal", "file", "line", "vessel")})


def test_no_look_and_no_error_is_without_a_remedy(asking):
    assert len(asking) > 200
    assert [code for code, kind in asking.items() if not kind.remedy] == []


def test_each_remedy_stands_in_the_sentence_of_its_finding(asking):
    for kind in asking.values():
        finding = made(kind)
        if "itself" not in finding.remedy:
            assert finding.remedy[1:].rstrip(".") in sentence(finding), kind.code


def test_no_sentence_speaks_of_a_command_or_of_python(asking):
    sentences = {code: sentence(made(kind)) for code, kind in asking.items()}
    assert {code: text for code, text in sentences.items() if OF_A_SHELL.search(text) or OF_PYTHON.search(text)} == {}


def test_the_workbench_shows_every_cure_as_a_button_without_a_word_of_another_door(asking):
    for code, kind in asking.items():
        card = as_shown(made(kind), ["rat 1"], {"animal": "rat 1"})
        words = " ".join([card["text"], *(f"{one['label']} {one['changes']}" for one in card["remedies"])])
        assert not OF_A_SHELL.search(words), code
        assert not OF_PYTHON.search(words), code
        assert card["code"] == code
        for one in card["remedies"]:
            assert one["label"], code
            assert one["changes"], code
            assert one.keys() & {"acts", "open", "type", "desk"}, code


def test_a_command_of_every_cure_of_cells_and_images_is_typed_in_a_shell(asking):
    cures = [cure for kind in asking.values() for cure in made(kind).cures]
    assert len({type(cure) for cure in cures}) >= 9
    shell = Shell(Path("my study"), {"rat 1": {"recording": "recordings/1.txt", "flow gain [1]": "-1"}})
    for cure in cures:
        assert shell.command(cure, ["rat 1"]), cure


def test_options_that_are_printed_are_options_of_a_command_and_flags_take_no_value(asking):
    group = get_command(app)
    context = group.make_context("vasowave", ["check"])
    commands = (group.resolve_command(context, [name])[1] for name in group.commands)
    options = [one for command in commands for one in command.params if one.param_type_name == "option"]
    flags = {name: one.is_flag for one in options for name in (*one.opts, *one.secondary_opts)}
    printed = [word for kind in asking.values() for cure in made(kind).cures for word in
               shlex.split(Shell().command(cure)) if word.startswith("--")]  # fmt: skip
    assert len(printed) > 20
    for word in printed:
        option, value, _ = word.partition("=")
        assert option in flags, word
        assert not (flags[option] and value), word


def test_the_zero_of_a_flow_that_has_a_zero_and_a_gain_already_is_that_of_what_was_read():
    rows = {"rat 1": {"recording": "recordings/1.txt", "flow gain [1]": "-2", "flow zero [ml/s]": "0.3"}}
    command = Shell(Path("my study"), rows).command(ShiftFlowZero("0.1"), ["rat 1"])
    assert command == "vasowave add 'my study' 'my study/recordings/1.txt' --flow-zero=0.25"  # (q - 0.3)(-2) = 0.1
    before = TYPED.set(None)  # whatever commands ran here before
    assert Shell().command(ShiftFlowZero("0.1")) == ""  # nobody knows what was typed
    TYPED.reset(before)
    assert argument(ShiftFlowZero("0.1")).startswith("recording.calibrated(flow_zero=0.1), of a cycle calibration=")


def test_a_command_names_the_sheet_and_the_subject_whose_row_a_recording_is():
    cells = {"recording": "all.xlsx", "sheet": "B", "subject row": "CTL 1"}
    shell = Shell(Path("s"), {"rat 1": cells})
    command = shell.command(ShiftFlowZero("0.05"), ["rat 1"])
    assert command == "vasowave add s s/all.xlsx --flow-zero=0.05 --sheet=B --subject-row='CTL 1'"
    renamed = SetCells("Name the subject", (("subject row", "CTL 2"),))
    assert shell.command(renamed, ["rat 1"]) == "vasowave add s s/all.xlsx --subject-row='CTL 2' --sheet=B"


def test_a_row_that_is_not_mended_together_with_others_has_a_command_beside_theirs():
    rows = {f"rat {number}": {"recording": f"recordings/{number}.csv"} for number in range(1, 5)}
    rows["rat 4"] |= {"recording": "recordings/lab.xlsx", "sheet": "4"}
    cure = SetCells("Give the wedge pressure", (("wedge [mmHg]", "8"),))
    first, second = Shell(Path("s"), rows).below([cure], list(rows)).split("\n")[1:]
    assert first == "    vasowave add s s/recordings/1.csv s/recordings/2.csv s/recordings/3.csv --wedge=8"
    assert second == "    vasowave add s s/recordings/lab.xlsx --wedge=8 --sheet=4"


def test_every_field_of_a_cure_is_text_or_cells():
    for cure in Cure.__args__:
        assert {field.type for field in fields(cure)} <= {str, tuple[tuple[str, str], ...]}, cure


def test_a_command_of_one_recording_counts_the_zero_and_the_gain_that_were_typed():
    before = TYPED.set({"flow_gain": "-1", "flow_zero": "0.01"})
    try:
        assert Shell().command(ShiftFlowZero("0.04")) == "--flow-zero=-0.03"  # (q - 0.01)(-1) = 0.04
        assert Shell().command(TurnFlow()) == "--flow-gain=1"
    finally:
        TYPED.reset(before)


def test_the_shell_prints_the_command_below_a_finding_and_the_code_to_whom_asks(tmp_path):
    mouse = vw.virtual_mouse()
    rows = np.column_stack([mouse.time, mouse.pressure, mouse.flow + 0.05 * np.ptp(mouse.flow)])
    new_study(tmp_path / "s", ["CTL"])
    head = "time [s],pressure [mmHg],flow [ml/s]"
    np.savetxt(tmp_path / "s/a.csv", rows, "%.9g", ",", header=head, comments="")
    write_network(vw.control_network(), tmp_path / "s/lung.csv")
    (tmp_path / "s/animals.csv").write_text("animal,group,network,recording\nrat 1,CTL,lung.csv,a.csv\n", "utf-8")
    lines = CliRunner().invoke(app, ["-v", "check", str(tmp_path / "s")]).output.splitlines()
    (k,) = [k for k, line in enumerate(lines) if "[recording.flow-off-zero]" in line]
    command = lines[k + 1].strip()
    assert command.startswith(f"vasowave add {tmp_path / 's'} {tmp_path / 's/a.csv'} --flow-zero=0.04")
    done = CliRunner().invoke(app, shlex.split(command)[1:])
    assert done.exit_code == 0, done.output
    output = CliRunner().invoke(app, ["check", str(tmp_path / "s")]).output
    assert "the flow rests at" not in output
    assert not re.search(r"\[[a-z]+\.[a-z-]+\]", output)
