"""Settings and cells that are written into the two files of a study, from the shell: comments and order stay."""

import shlex

import pytest
from typer.testing import CliRunner

from vasowave.base import InputError, RemoveAnimal, SetCells, SetSetting
from vasowave.cli import Shell, app
from vasowave.study.entering import new_study, read_rows, set_values

TABLE = "# of the winter\nanimal,group,network,recording,sex\nrat 1,CTL,n.csv,r1.csv,f\nrat 2,HPH,n.csv,r2.csv,m\n"


@pytest.fixture
def study(tmp_path):
    new_study(tmp_path / "my study")
    (tmp_path / "my study" / "animals.csv").write_text(TABLE, "utf-8")
    return tmp_path / "my study"


def typed(*words):
    return CliRunner().invoke(app, ["set", *map(str, words)])


def test_settings_change_and_every_other_line_stays(study):
    before = (study / "study.yaml").read_text("utf-8").split("\n")
    said = typed(study, "averaging.reject_ventilation=false", "species=rat")
    assert said.exit_code == 0
    after = (study / "study.yaml").read_text("utf-8").split("\n")
    assert [line for line in before if line not in after] == ["species: mouse", "  reject_ventilation: true"]
    assert {line.strip() for line in after if line not in before} == {"reject_ventilation: false", "species: rat"}


def test_cells_of_several_animals_change_by_a_title_with_or_without_its_unit(study):
    set_values(study, {"wedge": "8", "sex": "", "flow zero [ml/s]": "0.1"}, ["rat 1", "rat 2"])
    table = read_rows(study / "animals.csv")
    assert [(row["wedge [mmHg]"], row["sex"], row["flow zero [ml/s]"]) for row in table.rows] == [("8", "", "0.1")] * 2
    assert table.comments == ("# of the winter",)


def test_an_animal_is_taken_out_by_the_command_of_its_cure(study):
    command = Shell(study).command(RemoveAnimal(), ["rat 1"])
    assert typed(*shlex.split(command)[2:]).exit_code == 0
    assert (study / "animals.csv").read_text("utf-8") == TABLE.replace("rat 1,CTL,n.csv,r1.csv,f\n", "")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["averging.x=3"], "did you mean 'averaging'"),
        (["species=cow"], "'cow' is not known; choose from: mouse"),
        (["species"], "write KEY=VALUE"),
        (["species="], "write KEY=VALUE"),
        ([], "write KEY=VALUE"),
        (["--animal", "rat 3", "--remove"], "no animal 'rat 3'"),
        (["--animal", "rat 1", "--remove", "sex=m"], "--remove alone"),
        (["report.quantities=[VALUE]"], "VALUE stands for what you know"),
        (["species=rat", "species=dog"], "given twice"),
        (["calibration.bounds.beta=3"], "calibration.bounds={beta: 3}"),
        (["wege=8", "--animal", "rat 1"], "no column 'wege' .did you mean 'wedge'"),
        (["wedge=high", "--animal", "rat 1"], "'high' is not a number"),
        (["wedge=8", "--animal", "rat 3"], "no animal 'rat 3' in animals.csv .did you mean 'rat"),
        (["animal=rat 2", "--animal", "rat 1"], "an animal has a name that no other has"),
        (["wedge=8", "--animal", "rat 1", "--animal", "rat 3"], "no animal 'rat 3'"),
    ],
)
def test_what_cannot_be_is_refused_and_nothing_is_written(study, words, message):
    before = [(study / name).read_bytes() for name in ("study.yaml", "animals.csv")]
    refused = typed(study, *words)
    assert isinstance(refused.exception, InputError)
    with pytest.raises(InputError, match=message):
        raise refused.exception
    assert [(study / name).read_bytes() for name in ("study.yaml", "animals.csv")] == before


def test_an_error_that_stood_in_the_file_is_told_from_one_of_the_command(study):
    file = study / "study.yaml"
    file.write_text(f"{file.read_text('utf-8')}speceis: rat\n", "utf-8")
    with pytest.raises(InputError, match=r"nothing was written.*'speceis'.*had an error before"):
        set_values(study, {"calibration.starts": "3"})
    file.write_text(file.read_text("utf-8").replace("speceis: rat\n", "").replace("species: mouse", "species: muose"))
    set_values(study, {"species": "mouse"})
    with pytest.raises(InputError, match=r"nothing was written.*'strats'") as refused:
        set_values(study, {"calibration.strats": "3"})
    assert "before" not in str(refused.value)


@pytest.mark.parametrize(
    ("cure", "file", "line"),
    [
        (SetSetting("Average over the breath", "averaging.reject_ventilation", "false"), "study.yaml",
         "  reject_ventilation: false"),
        (SetSetting("Name the question", "report.quantities", "[mPAP, PVR]"), "study.yaml",
         "  quantities: [mPAP, PVR]"),
        (SetCells("It is another rat", (("animal", "rat 3"), ("sex", "m"))), "animals.csv",
         "rat 3,CTL,n.csv,r1.csv,m"),
    ],
)  # fmt: skip
def test_the_command_of_a_cure_that_no_option_of_add_does_mends_it(study, cure, file, line):
    command = Shell(study, {row["animal"]: row for row in read_rows(study / "animals.csv").rows}).command(
        cure, ["rat 1"]
    )
    program, verb, *words = shlex.split(command)
    assert (program, verb, typed(*words).exit_code) == ("vasowave", "set", 0)
    assert line in (study / file).read_text("utf-8").split("\n")
