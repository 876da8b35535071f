"""What is told of a run while it goes on, on a terminal and as lines of JSON."""

import io
import json

import pytest
from rich.console import Console

from vasowave.cli import watching
from vasowave.cli.progress import time_left
from vasowave.study.running import Progress


def step(name, done, count=3, what="computed", left=None, message=""):
    return Progress(name=name, what=what, done=done, count=count, left=left, message=message)


@pytest.fixture
def rows():
    console = Console(file=io.StringIO(), width=200)
    return watching.ProgressRows(console, watching._bars(console, 3))


def lines(rows):
    return rows.console.file.getvalue().splitlines()


def test_a_finished_animal_is_a_line_with_what_is_left(rows):
    rows.step(step("a", 1, left=89.4))
    rows.step(step("b", 2, what="failed", left=90.0, message="no beats"))
    rows.step(step("c", 3, left=0.0))
    assert lines(rows) == [
        "1 of 3: a computed (about 89 s left)",
        "2 of 3: b FAILED: no beats (about 2 min left)",
        "3 of 3: c computed",
    ]
    assert rows.idle == "writing the results"
    assert rows.bars.tasks[0].completed == 3


def test_searches_make_a_row_for_every_animal_until_it_is_finished(rows):
    rows.searches({"a": {"linear": (4, 4), "tangent": (1, 4)}, "b": {"linear, posterior": (7, 0)}})
    assert rows.doing() == "a: tangent wall, 1 of 4 searches; b: linear, posterior, 7 simulations"
    bar = next(task for task in rows.bars.tasks if task.description == "a")
    assert (bar.completed, bar.total) == (5, 8)
    assert rows.bars.tasks[0].fields["left"] == ""
    rows.step(step("a", 1))
    assert [task.description for task in rows.bars.tasks] == ["animals", "b"]
    assert rows.doing() == "b: linear, posterior, 7 simulations"
    rows.searches({"a": {"linear": (4, 4)}, "b": {"linear": (4, 4)}})
    assert rows.doing() == "b: linear wall fitted, going on"
    assert rows.bars.tasks[0].fields["left"] == ""
    assert [task.description for task in rows.bars.tasks] == ["animals", "b"]


def test_lines_of_json_tell_every_animal_and_each_search_once(capsys):
    told = watching.JsonLines()
    told.step(step("a", 1, left=12.34, message="ok"))
    told.searches({"b": {"linear": (1, 4), f"linear{watching.POSTERIOR}": (30, 0)}})
    told.searches({"b": {"linear": (1, 4), f"linear{watching.POSTERIOR}": (31, 0)}})
    found = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert found == [
        {"event": "animal", "animal": "a", "what": "computed", "done": 1, "count": 3, "left_s": 12.3, "message": "ok"},
        {"event": "searches", "animal": "b", "wall": "linear", "done": 1, "count": 4},
        {"event": "simulations", "animal": "b", "wall": "linear", "done": 30},
        {"event": "simulations", "animal": "b", "wall": "linear", "done": 31},
    ]


@pytest.mark.parametrize(
    ("seconds", "words"),
    [(89, "89 s"), (90, "2 min"), (5399, "90 min"), (5400, "2 h"), (129_599, "36 h"), (172_800, "2 days")],
)
def test_the_time_that_is_left_is_said_in_the_unit_that_fits(seconds, words):
    assert time_left(seconds) == f"about {words} left"
