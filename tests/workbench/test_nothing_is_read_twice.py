"""What was computed from files is shown again without computing, and anew as soon as anything that decides changes."""

import json
import os
import re
import shutil
import time

import pytest
from served import served

from vasowave.study.results import read_results
from vasowave.workbench import Desk, checked


@pytest.fixture
def study(kept_study, tmp_path):
    """A study of two animals that is this test's own."""
    folder = shutil.copytree(kept_study, tmp_path / "study")
    lines = (folder / "animals.csv").read_text("utf-8").splitlines(keepends=True)
    named = [line for line in lines if not re.match("mouse_[ch][13]", line)]
    (folder / "animals.csv").write_text("".join(named), "utf-8")
    return folder


def pressures(desk):
    return {name: float(cells[7]) for name, cells in checked(desk)["read"].items()}


def rewritten(file, change):
    """Write a file anew with as many bytes, and give it the time that it had."""
    about, text = file.stat(), file.read_text("utf-8")
    new = change(text)
    assert len(new) == len(text)
    assert new != text
    file.write_text(new, "utf-8")
    os.utime(file, ns=(about.st_atime_ns, about.st_mtime_ns))
    assert file.stat().st_size == about.st_size


def higher(text):
    """Return a recording of the same length whose pressure is 10 mmHg higher, which begins with the same digits."""
    lines = text.splitlines(keepends=True)
    at = next(i for i, line in enumerate(lines) if line[:1].isdigit() and line.count("\t") >= 2)
    for i in range(at, len(lines)):
        cells = lines[i].split("\t")
        if len(cells) > 2 and cells[1][:1] in "123" and cells[1][2:3] == ".":
            cells[1] = str(int(cells[1][0]) + 1) + cells[1][1:]
        lines[i] = "\t".join(cells)
    return "".join(lines)


def cost(look, *arguments):
    """Return the time of the processor that a look takes, s."""
    begun = time.process_time()
    look(*arguments)
    return time.process_time() - begun


def test_a_second_look_costs_nothing_and_a_recording_that_changed_is_seen(study):
    desk = Desk(study)
    before, second = checked(desk), cost(checked, Desk(study))
    (study / "study.yaml").write_text((study / "study.yaml").read_text("utf-8") + "# the same\n", "utf-8")
    assert checked(desk) == before
    rewritten(study / "recordings" / "hypoxic" / "mouse_h2.txt", higher)
    single = cost(checked, desk)
    assert second < 0.4 * single
    after = checked(desk)
    assert after["read"]["mouse_c2"] == before["read"]["mouse_c2"]
    assert pressures(desk)["mouse_h2"] == pytest.approx(float(before["read"]["mouse_h2"][7]) + 10.0, abs=0.11)


def test_a_setting_and_a_cell_are_seen_and_what_is_undone_is_as_before(study):
    with served(study) as page:
        before = page.get("check")
        page.act("set-cells", animal="mouse_c2", cells={"zero [mmHg]": "2"})
        page.act("set-setting", key="averaging.beats", value="12")
        assert page.get("check")["read"]["mouse_h2"][5] == "12/" + before["read"]["mouse_h2"][5].partition("/")[2]
        page.act("undo")
        shifted = page.get("check")["read"]
        assert float(shifted["mouse_c2"][7]) == pytest.approx(float(before["read"]["mouse_c2"][7]) - 2.0, abs=0.11)
        assert shifted["mouse_h2"] == before["read"]["mouse_h2"]
        page.act("undo")
        assert page.get("check") == before


def test_a_file_that_cannot_be_averaged_is_tried_again(study):
    desk, file = Desk(study), study / "recordings" / "control" / "mouse_c2.txt"
    content = file.read_text("utf-8")
    file.write_text("\n".join(content.splitlines()[:30]), "utf-8")
    assert any(problem["error"] and "mouse_c2" in problem["animals"] for problem in checked(desk)["problems"])
    file.write_text(content, "utf-8")
    assert "mouse_c2" in checked(desk)["read"]


def test_a_figure_is_drawn_once_and_not_after_the_file_of_its_animal_has_changed(ran):
    for file in ran.rglob("*.*"):
        os.utime(file, (1e9, 1e9))  # old files, whose times tell whether they changed
    with served(ran) as page:

        def figure(**wish):
            status, _, content = page.raw("POST", f"{page.root}figure", json.dumps({"animal": "CTL 0"} | wish).encode())
            return status, content

        status, drawing = figure()
        assert status == 200
        assert cost(figure) < 0.1
        assert figure() == (status, drawing)
        assert figure(width=100)[1] != drawing
        stored = read_results(ran)
        (ran / "results" / stored.file_of("CTL 0")).unlink()
        shutil.copy(ran / "results" / stored.file_of("CTL 1"), ran / "results" / stored.file_of("CTL 0"))
        assert figure()[0] == 400  # the file holds another animal, which nothing that was remembered hides
