"""A recorder saves into the folder of a study that is open: what arrives whole becomes a row, once."""

import pytest

from lab_files import exported, recorded
from vasowave.base import InputError
from vasowave.study.entering import add_files, new_study, read_rows
from vasowave.workbench import Arrivals, Desk, Workplace, act, shown

TEXT = exported(recorded(1, mean=16.0))


class Clock:
    """A time that passes when it is told to."""

    now = 0.0

    def __call__(self):
        return self.now


@pytest.fixture
def watched(tmp_path):
    """A desk over a study of one animal, a clock, and what arrives there."""
    folder = tmp_path / "study"
    new_study(folder)
    (folder / "recordings" / "CTL_1.txt").write_text(exported(recorded(0, mean=14.0)), encoding="utf-8")
    add_files(folder, [folder / "recordings"])
    clock = Clock()
    return Desk(folder), clock, Arrivals(Desk(folder), clock)


def animals(desk):
    return [row["animal"] for row in read_rows(desk.table).rows]


def test_a_file_becomes_a_row_once_it_has_stayed_as_it_is_for_seconds(watched):
    desk, clock, arrivals = watched
    file = desk.folder / "recordings" / "day 2" / "HPH_1.txt"
    file.parent.mkdir()
    file.write_text(TEXT[: len(TEXT) // 2], encoding="utf-8")
    assert arrivals.ready() == []
    clock.now = 2.0
    file.write_text(TEXT, encoding="utf-8")  # the recorder goes on
    assert arrivals.ready() == []
    clock.now = 4.0
    assert arrivals.ready() == []
    clock.now = 6.0
    assert arrivals.ready() == [file.resolve()]
    assert [row["animal"] for row in arrivals.add().rows] == ["HPH_1"]
    assert animals(desk) == ["CTL_1", "HPH_1"]
    assert arrivals.add() is None


def test_what_was_there_at_first_or_taken_out_again_or_is_no_recording_does_not_come_back(watched):
    desk, clock, _ = watched
    for name in ("left.txt", ".hidden.txt"):
        (desk.folder / "recordings" / name).write_text(TEXT, encoding="utf-8")
    arrivals = Arrivals(desk, clock)
    for name in ("later.txt", "~later.txt", "notes.docx"):
        (desk.folder / "recordings" / name).write_text(TEXT, encoding="utf-8")
    arrivals.ready()
    clock.now = 10.0
    assert [file.name for file in arrivals.ready()] == ["later.txt"]
    arrivals.add()
    for name in ("left.txt", "CTL_1.txt"):
        (desk.folder / "recordings" / name).touch()  # as programs do that copy a folder to another machine
    desk.table.write_text(desk.table.read_text(encoding="utf-8").replace("recordings/later.txt", ""), encoding="utf-8")
    arrivals.ready()
    clock.now = 20.0
    assert arrivals.ready() == []
    assert shown(desk)["unlisted"] == ["recordings/later.txt", "recordings/left.txt"]


def test_a_file_that_was_refused_is_tried_again_when_it_has_changed_and_not_before(watched):
    desk, clock, arrivals = watched
    file = desk.folder / "recordings" / "HPH_4.txt"
    file.write_text(TEXT[:40], encoding="utf-8")
    arrivals.ready()
    clock.now = 10.0
    with pytest.raises(InputError, match="no recording among these files"):
        arrivals.add()
    clock.now = 20.0
    assert arrivals.ready() == []
    file.write_text(TEXT, encoding="utf-8")
    arrivals.ready()
    clock.now = 30.0
    assert [row["animal"] for row in arrivals.add().rows] == ["HPH_4"]


def test_where_no_study_is_nothing_arrives(tmp_path):
    clock = Clock()
    arrivals = Arrivals(Desk(tmp_path), clock)
    (tmp_path / "recordings").mkdir()
    (tmp_path / "recordings" / "HPH_5.txt").write_text(TEXT, encoding="utf-8")
    assert arrivals.ready() == []
    new_study(tmp_path)
    clock.now = 10.0
    assert arrivals.ready() == []


def test_pressure_and_flow_that_arrive_one_after_the_other_are_one_animal(watched):
    desk, clock, arrivals = watched
    lines = TEXT.splitlines()
    start = next(k for k, line in enumerate(lines) if line[:1].isdigit())
    time, *signals = zip(*(line.split("\t")[:3] for line in lines[start:]), strict=True)
    for word, title, signal in zip(("pressure", "flow"), ("pressure [mmHg]", "flow [ml/s]"), signals, strict=True):
        rows = "\n".join(map(",".join, zip(time, signal, strict=True)))
        (desk.folder / "recordings" / f"HPH_2 {word}.csv").write_text(f"time [s],{title}\n{rows}\n", encoding="utf-8")
        arrivals.ready()
        clock.now += 10.0
        if word == "pressure":
            with pytest.raises(InputError, match="no recording among these files"):
                arrivals.add()
    assert len(arrivals.add().rows) == 1
    new = read_rows(desk.table).rows[-1]
    assert (new["recording"], new["flow"]) == ("recordings/HPH_2 pressure.csv", "recordings/HPH_2 flow.csv")


def test_undo_takes_the_row_away_and_the_file_is_offered_again(watched):
    desk, clock, _ = watched
    workplace = Workplace.around(desk)._replace(arrivals=(arrivals := Arrivals(desk, clock)))
    (desk.folder / "recordings" / "HPH_3.txt").write_text(TEXT, encoding="utf-8")
    arrivals.ready()
    clock.now = 10.0
    assert act(workplace, {"do": "add-arrivals"})["animals"] == ["HPH_3"]
    assert act(workplace, {"do": "add-arrivals"}) == {"animals": [], "said": []}
    act(workplace, {"do": "undo"})
    assert (animals(desk), shown(desk)["unlisted"]) == (["CTL_1"], ["recordings/HPH_3.txt"])
    act(workplace, {"do": "add-files", "files": shown(desk)["unlisted"]})
    assert (animals(desk), shown(desk)["unlisted"]) == (["CTL_1", "HPH_3"], [])


def test_a_half_that_waits_is_read_again_for_the_other_half_of_its_name_alone(watched, monkeypatch):
    desk, clock, arrivals = watched
    folder, tried = desk.folder / "recordings", []
    monkeypatch.setattr(
        "vasowave.workbench.arrivals.add_files", lambda study, files: tried.append([file.name for file in files])
    )
    table = "time [s],{} [{}]\n" + "".join(f"{i * 0.001},{i % 100}\n" for i in range(110))
    for number, (name, unit) in enumerate((("a_pressure", "mmHg"), ("b_flow", "ml/s"), ("a_flow", "ml/s"))):
        (folder / f"{name}.csv").write_text(table.format(name[2:], unit))
        arrivals.ready()
        clock.now = 10.0 * (number + 1)
        arrivals.add()
    assert tried == [["a_pressure.csv"], ["b_flow.csv"], ["a_flow.csv", "a_pressure.csv"]]
