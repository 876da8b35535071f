"""From the files a lab has to a study that runs: `new`, `add`, and nothing left to mend."""

import csv
import shlex
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from vasowave.base import InputError, ShiftFlowZero
from vasowave.catheter import Disturbances, labchart_text, synthetic_raw_recording
from vasowave.cli import Shell, app
from vasowave.pulse.cycle import Recording
from vasowave.pulse.examples import control_network, virtual_mouse
from vasowave.pulse.network import write_network
from vasowave.study.entering import add_files, check_study, new_study, read_rows, told_network

QUIET = Disturbances(pressure_drift=0.0)


def exported(number, mean, *, ecg=True):
    """Return LabChart's text of 12 s in which the pressure has this mean, in mmHg."""
    mouse = virtual_mouse()
    cycle = Recording(mouse.pressure + mean - mouse.pressure.mean(), mouse.flow, mouse.period)
    made = synthetic_raw_recording(
        cycle, np.random.default_rng(number), duration=12.0, sampling_rate=1000.0, disturbances=QUIET, ecg=ecg,
    )  # fmt: skip
    return labchart_text(made.raw)


def with_decimal_commas_and_a_short_block(text):
    """Return an export of two blocks, the second long, with decimal commas."""
    head, body = text.split("UnitName", 1)
    first = head + "UnitName" + "\n".join(body.split("\n")[:1500])
    return (first + "\n" + text).replace(".", ",")


def without_ecg(text):
    """Return the export with its last channel left out."""
    lines = text.replace("\tECG", "").replace("\tmV", "").replace("\t10 mV", "").split("\n")
    return "\n".join("\t".join(line.split("\t")[:3]) if line[:1].isdigit() else line for line in lines)


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    """Return a folder of four exports in two groups, and a network from a spreadsheet."""
    folder = tmp_path_factory.mktemp("lab")
    for name in ("normoxia", "hypoxia"):
        (folder / name).mkdir()
    texts = {
        "normoxia/M11.txt": exported(1, 14.2),
        "normoxia/M12.txt": exported(2, 15.3),
        "normoxia/M13.txt": without_ecg(exported(3, 13.6, ecg=False)),
        "hypoxia/M21.txt": with_decimal_commas_and_a_short_block(exported(4, 27.9)),
    }
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="cp1252", errors="replace")
    network = control_network()
    rows = [
        f"{name};{network.name[parent] if parent >= 0 else ''};{10 * length:.4f};{10 * radius:.4f}".replace(".", ",")
        for name, parent, length, radius in zip(network.name, network.parent, network.length, network.radius)
    ]
    (folder / "lung.csv").write_text("\ufeffName;Parent;Length (mm);Radius (mm)\n" + "\n".join(rows), encoding="utf-8")
    return folder


def test_a_recording_that_stands_in_the_table_is_not_added_twice_and_the_table_keeps_its_rows(lab, tmp_path):
    study = tmp_path / "s"
    CliRunner().invoke(app, ["new", str(study), "--groups", "normoxia,hypoxia"])
    add_files(study, [lab / "normoxia", lab / "lung.csv"])
    before = (study / "animals.csv").read_text("utf-8")
    again = add_files(study, [lab / "normoxia" / "M11.txt", lab / "hypoxia" / "M21.txt"])
    assert any("1 of these recordings are in the table already" in one for one in again.said)
    after = (study / "animals.csv").read_text("utf-8")
    assert after.startswith(before.rstrip("\n"))
    rows = list(csv.DictReader(line for line in after.splitlines() if not line.startswith("#")))
    assert [row["animal"] for row in rows] == ["M11", "M12", "M13", "M21"]
    assert rows[3]["network"] == rows[0]["network"]  # the only one the study has


def test_pressure_and_flow_in_files_of_their_own_are_one_animal(tmp_path):
    mouse, study = virtual_mouse(), tmp_path / "s"
    CliRunner().invoke(app, ["new", str(study)])
    place = study / "recordings" / "CTL"
    place.mkdir()
    np.savetxt(place / "p_C6.dat", mouse.pressure)
    np.savetxt(place / "q_C6.dat", mouse.flow)
    np.savetxt(place / "p_C7.dat", mouse.pressure)
    write_network(control_network(), study / "networks" / "ctl.csv")
    added = add_files(study, [place], cells={"period [s]": "0.11"})
    assert [(row["animal"], row["group"], row["kind"], row["network"]) for row in added.rows] == [
        ("C6", "CTL", "cycle", "networks/ctl.csv")
    ]
    assert [(row["recording"], row["flow"]) for row in added.rows] == [
        ("recordings/CTL/p_C6.dat", "recordings/CTL/q_C6.dat")
    ]
    assert any("p_C7.dat" in one and "flow is not among these" in one for one in added.refused)


def test_subjects_of_one_table_are_animals_of_their_own(tmp_path):
    """Each is added by its name; the same bytes are another animal's, and the samples are no columns of a study."""
    turn = 2 * np.pi * np.arange(64) / 64
    titles = ["subject", "heart rate", *(f"p_{i} [mmHg]" for i in range(64)), *(f"q_{i} [ml/s]" for i in range(64))]
    rows = [[name, 500, *(mean + 4 * np.sin(turn)), *(0.18 + 0.16 * np.sin(turn + 0.4))]
            for name, mean in (("CTL 1", 14.0), ("HPH 1", 22.0))]  # fmt: skip
    (tmp_path / "all.csv").write_text("\n".join(",".join(map(str, row)) for row in (titles, *rows)) + "\n")
    write_network(control_network(), tmp_path / "tree.csv")
    study = new_study(tmp_path / "study")[0].parent
    for name in ("ctl 1", "HPH 1", "CTL 1", "hph 1"):
        add_files(study, [tmp_path / "all.csv"], network=tmp_path / "tree.csv", cells={"subject row": name})
    lines = (study / "animals.csv").read_text().splitlines()
    added = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    assert [(row["animal"], row["group"], row["subject row"]) for row in added] == [
        ("CTL 1", "CTL", "CTL 1"), ("HPH 1", "HPH", "HPH 1")
    ]  # fmt: skip
    assert not [title for title in added[0] if title.startswith(("p_", "q_"))]
    checked = check_study(study)
    assert not [problem for problem in checked.problems if problem.error]
    assert [animal.mean_pressure for animal in checked.read] == pytest.approx([14.0, 22.0])
    with pytest.raises(InputError, match="no row of 'HPH 7'"):
        add_files(study, [tmp_path / "all.csv"], cells={"subject row": "HPH 7"})
    rows = {row["animal"]: row for row in read_rows(study / "animals.csv").rows}
    command = Shell(study, rows).command(ShiftFlowZero("0.05"), ["CTL 1"])
    assert "--subject-row='CTL 1'" in command
    done = CliRunner().invoke(app, shlex.split(command)[1:])
    assert done.exit_code == 0, done.output
    zeros = [row.get("flow zero [ml/s]") for row in read_rows(study / "animals.csv").rows]
    assert zeros == ["0.05", ""]


def test_files_of_a_type_that_nothing_reads_are_named(lab, tmp_path):
    for name in ("old.numbers", "notes.md"):
        (tmp_path / name).write_text("x", encoding="utf-8")
    (tmp_path / "M1.txt").write_bytes((lab / "normoxia" / "M11.txt").read_bytes())
    new_study(tmp_path / "study")
    said = add_files(tmp_path / "study", [tmp_path / "M1.txt", tmp_path]).said
    assert [text for text in said if text.startswith("passed over")] == [
        "passed over, for no reader has their type (save as .xlsx or CSV): old.numbers"
    ]


def test_the_phases_of_a_gated_flow_may_be_numbered_beside_it(tmp_path):
    mouse = virtual_mouse()
    time = mouse.period * np.arange(25) / 25
    flow = np.interp(time, mouse.time, mouse.flow)
    rows = [f"{i + 1},{1e3 * t:.2f},{q:.5f}" for i, (t, q) in enumerate(zip(time, flow, strict=True))]
    (tmp_path / "m_flow.csv").write_text("\n".join(["Phase,Trigger delay [ms],PA flow [ml/s]", *rows, ""]), "utf-8")
    rows = [f"{t:.6f},{p:.4f}" for t, p in zip(mouse.time, mouse.pressure, strict=True)]
    (tmp_path / "m_pressure.csv").write_text("\n".join(["time [s],pressure [mmHg]", *rows, ""]), "utf-8")
    new_study(tmp_path / "study")
    added = add_files(tmp_path / "study", sorted(tmp_path.glob("m_*.csv")))
    assert [row["animal"] for row in added.rows] == ["m"]
    assert not added.refused


def test_what_nothing_tells_is_said_and_left_empty_and_what_is_no_recording_is_named(lab, tmp_path):
    study = tmp_path / "s"
    CliRunner().invoke(app, ["new", str(study)])
    (tmp_path / "notes.txt").write_text("weights of the mice\n", "utf-8")
    added = add_files(study, [lab / "normoxia" / "M11.txt", tmp_path / "notes.txt"])
    assert added.rows[0]["group"] == ""
    assert any("neither name nor folder tells the group" in one and "M11" in one for one in added.said)
    assert any("there is no network" in one for one in added.said)
    assert [one for one in added.refused if "notes.txt" in one] == list(added.refused)
    assert added.refused
    nothing = CliRunner().invoke(app, ["add", str(study), str(tmp_path / "notes.txt")])
    assert nothing.exit_code != 0
    assert "no recording among these files" in str(nothing.exception)


def test_a_study_of_one_group_has_all_in_it_but_what_a_name_says_is_another(lab, tmp_path):
    study = tmp_path / "s"
    CliRunner().invoke(app, ["new", str(study), "--groups", "treated"])
    file = tmp_path / "M7.txt"
    file.write_bytes((lab / "normoxia" / "M11.txt").read_bytes())
    added = add_files(study, [file])
    assert [row["group"] for row in added.rows] == ["treated"]
    assert any("treated, the only group of the study" in sentence for sentence in added.said)
    assert [row["group"] for row in add_files(study, [lab / "normoxia" / "M12.txt"]).rows] == [""]
    CliRunner().invoke(app, ["new", str(tmp_path / "controls"), "--groups", "CTL"])
    assert [row["group"] for row in add_files(tmp_path / "controls", [file]).rows] == [""]


def test_networks_that_come_later_go_to_the_animals_that_wait_for_them(lab, tmp_path):
    """By an animal's name or its group, then to all where there is one; an animal keeps the network that it has."""
    study = tmp_path / "s"
    new_study(study)
    add_files(study, [lab / "normoxia", lab / "hypoxia"], groups="normoxia,hypoxia")
    files = [tmp_path / name for name in ("M11.csv", "hypoxia.csv", "lung.csv")]
    for file in files:
        file.write_text((lab / "lung.csv").read_text("utf-8"), "utf-8")
    by_name = add_files(study, files[:2])
    assert not by_name.rows
    assert by_name.updated == ("M11", "M21")
    assert any("M12, M13" in sentence for sentence in by_name.said)
    assert add_files(study, files[2:]).updated == ("M12", "M13")
    networks = {row["animal"]: row["network"].rpartition("/")[2] for row in read_rows(study / "animals.csv").rows}
    assert networks == {"M11": "M11.csv", "M12": "lung.csv", "M13": "lung.csv", "M21": "hypoxia.csv"}
    with pytest.raises(InputError, match="no recording among these files, and every animal has a network"):
        add_files(study, files[2:])
    refused = CliRunner().invoke(app, ["add", str(study), str(files[2])]).exception
    assert Shell().command(refused.cures[0]) == f"--network={files[2]}"
    again = add_files(study, [lab / "normoxia" / "M11.txt"], network=files[2])
    assert (again.updated, read_rows(study / "animals.csv").rows[0]["network"].rpartition("/")[2]) == (
        ("M11",),
        "lung.csv",
    )


def test_the_network_of_an_animal_that_comes_along_is_not_given_to_others(lab, tmp_path):
    study = tmp_path / "s"
    new_study(study)
    add_files(study, [lab / "normoxia", lab / "hypoxia"], groups="normoxia,hypoxia")
    recording, network = tmp_path / "M77.txt", tmp_path / "M77.csv"
    recording.write_text(exported(77, 15.0), "cp1252", errors="replace")
    network.write_text((lab / "lung.csv").read_text("utf-8"), "utf-8")
    add_files(study, [recording, network], group="normoxia")
    networks = {row["animal"]: row["network"] for row in read_rows(study / "animals.csv").rows}
    assert [animal for animal, file in networks.items() if file] == ["M77"]


def test_files_beside_a_recording_are_found_from_where_they_were_typed(lab, tmp_path, monkeypatch):
    """As recordings and networks are, whose names the table holds as seen from the study."""
    monkeypatch.chdir(tmp_path)
    study = new_study(tmp_path / "a study")[0].parent
    (tmp_path / "Vorhof links.csv").write_text("time [s],pressure [mmHg]\n" + "".join(
        f"{i / 1000:.3f},{7 + np.sin(2 * np.pi * i / 110):.4f}\n" for i in range(110)), "utf-8")  # fmt: skip
    one = min(lab.rglob("*.txt"))
    added = add_files(study, [one], group="CTL", cells={"wedge wave": "Vorhof links.csv"})
    (name,) = {row["wedge wave"] for row in added.rows}
    assert (study / name).samefile(tmp_path / "Vorhof links.csv")


def test_files_without_a_unit_are_named_and_one_command_mends_all(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    study, cycle = new_study(tmp_path / "s")[0].parent, virtual_mouse()
    Path("lab").mkdir()
    write_network(control_network(), Path("lab/lung.csv"))
    for n in range(5):
        rows = np.column_stack([cycle.time, (1 + 0.1 * n) * cycle.pressure, cycle.flow])
        np.savetxt(f"lab/CTL {n}.csv", rows, "%.9g", ",", header="time [s],pressure,flow [ml/s]", comments="")
    add_files(study, [Path("lab")], group="CTL")
    printed = CliRunner().invoke(app, ["check", "s"], env={"COLUMNS": "400"}).output
    assert "CTL 1, CTL 2, CTL 3 and CTL 4" in printed
    command = next(line for line in printed.splitlines() if line.lstrip().startswith("vasowave add"))
    assert CliRunner().invoke(app, shlex.split(command)[1:]).exit_code == 0
    assert not [problem for problem in check_study(study).problems if problem.error]


def test_one_cause_is_one_error_with_all_its_lines(tmp_path):
    study = tmp_path / "s"
    CliRunner().invoke(app, ["new", str(study)])
    write_network(control_network(), study / "networks" / "ctl.csv")
    for i in range(6):
        (study / "recordings" / f"{i}.txt").write_text(
            exported(i, 15.0)
            .replace("ChannelTitle=\tPAP", "ChannelTitle=\tCh1")
            .replace("UnitName=\tmmHg", "UnitName=\t*")
        )
    rows = [f"m{i},CTR,networks/ctl.csv,recordings/{i}.txt" for i in range(6)]
    (study / "animals.csv").write_text("\n".join(["animal,group,network,recording", *rows, ""]), "utf-8")
    errors = [problem for problem in check_study(study).problems if problem.error]
    assert len(errors) == 1
    assert "'CTR' is not a group" in str(errors[0])
    assert "the same in lines 3, 4, 5, 6, 7" in str(errors[0])
    text = "\n".join(["animal,group,network,recording", *rows, ""]).replace("CTR", "CTL")
    (study / "animals.csv").write_text(text, "utf-8")
    errors = [problem for problem in check_study(study).problems if problem.error]
    assert len(errors) == 1
    assert "no channel says that it holds pressure" in str(errors[0])
    added = add_files(study, [study / "recordings"])
    assert added.rows == ()


def test_a_channel_whose_unit_leaves_one_answer_needs_no_naming(tmp_path):
    study = tmp_path / "s"
    CliRunner().invoke(app, ["new", str(study)])
    write_network(control_network(), study / "networks" / "ctl.csv")
    text = exported(1, 15.0).replace("\tPAP\tFlow", "\tChannel 1\tTransonic")
    (study / "recordings" / "CTL-1.txt").write_text(text, "utf-8")
    added = add_files(study, [study / "recordings"])
    assert added.rows[0]["pressure channel"] == "Channel 1"
    assert added.rows[0]["flow channel"] == "Transonic"
    assert not [problem for problem in check_study(study).problems if problem.error]


@pytest.mark.parametrize("name", ["$\\x$", "a" * 61, "=cmd|x", "a/b"])
def test_a_name_that_no_file_figure_or_spreadsheet_takes_is_refused_before_anything_is_computed(tmp_path, name):
    study = tmp_path / "s"
    refused = CliRunner().invoke(app, ["new", str(study), "--groups", f"CTL,{name}"])
    assert refused.exit_code != 0
    assert not study.exists()


def test_a_letter_that_unicode_writes_in_two_ways_is_one_name(tmp_path):
    study = tmp_path / "s"
    CliRunner().invoke(app, ["new", str(study), "--groups", "\u212b,B"])
    write_network(control_network(), study / "n.csv")
    (study / "1.txt").write_text(exported(1, 15.0), "utf-8")
    (study / "animals.csv").write_text("animal,group,network,recording\nA\u030a 1,\u00c5,n.csv,1.txt\n", "utf-8")
    problems, read, *_ = check_study(study)
    assert [(one.animal, one.group) for one in read] == [("\u00c5 1", "\u00c5")]
    assert not [problem for problem in problems if problem.error]


def test_a_network_is_not_taken_for_all_beside_one_that_cannot_be_read_and_a_kept_one_is_told(lab, tmp_path):
    study, nets = tmp_path / "s", tmp_path / "nets"
    nets.mkdir()
    sound = (lab / "lung.csv").read_bytes()
    (nets / "loop.csv").write_bytes(sound)
    (nets / "normoxia.csv").write_text("Vessel;leaves;L (mm)\nMPA;;4,1\nLPA;MPA;4,5\nRPA;MPA;3,7\n")
    CliRunner().invoke(app, ["new", str(study), "--groups", "normoxia,hypoxia"])
    added = add_files(study, [lab / "normoxia" / "M11.txt", nets])
    assert [row["network"] for row in added.rows] == [""]
    assert any("some files could not be read: M11" in one for one in added.said)
    add_files(study, [lab / "normoxia" / "M11.txt", nets / "loop.csv"])
    (nets / "normoxia.csv").write_bytes(sound)
    again = add_files(study, [lab / "normoxia" / "M11.txt", nets])
    assert any("M11: the table keeps ../nets/loop.csv (not ../nets/normoxia.csv)" in one for one in again.said)


@pytest.mark.parametrize(
    ("cells", "why"),
    [
        ({"pressure unit": "bar"}, "pressure unit: 'bar' is not a unit of pressure"),
        ({"start [s]": "four"}, r"start \[s\]: 'four' is not a number"),
        ({"start [s]": "12", "end [s]": "3"}, "from 12 to 3 s ends before it begins"),
    ],
)
def test_a_cell_that_no_animal_can_have_is_not_written_into_the_table(tmp_path, cells, why):
    assert CliRunner().invoke(app, ["new", str(tmp_path / "study")]).exit_code == 0
    before = (tmp_path / "study" / "animals.csv").read_bytes()
    (tmp_path / "a.txt").write_text("no recording")
    with pytest.raises(InputError, match=why):
        add_files(tmp_path / "study", [tmp_path / "a.txt"], cells=cells)
    assert (tmp_path / "study" / "animals.csv").read_bytes() == before


def test_a_table_of_vessels_with_other_titles_is_no_recording_and_serves_nobody(tmp_path):
    """A lung that is called like another group is not given to animals whose own lung was not understood."""
    folder = tmp_path / "lab"
    (folder / "Kontrolle").mkdir(parents=True)
    (folder / "Hypoxie").mkdir()
    (folder / "lung Kontrolle.csv").write_text("Gefäß;Länge [mm];Radius [µm]\n1;4,1;470\n", encoding="utf-8")
    new_study(tmp_path / "s")
    with pytest.raises(InputError, match="looks like a table of vessels") as said:
        add_files(tmp_path / "s", [folder])
    assert "gefäß, länge, radius" in str(said.value)
    marks = {"Kontrolle": ("Kontrolle",), "Hypoxie": ("Hypoxie",)}
    only = [folder / "lung Hypoxie.csv"]
    assert told_network("mouse 1", "Kontrolle", marks, only, folder) is None
    assert told_network("mouse 2", "Hypoxie", marks, only, folder) == only[0]
    assert told_network("mouse 1", "Kontrolle", marks, [folder / "lung.csv"], folder) == folder / "lung.csv"
