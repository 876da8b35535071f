"""The page of evidence says what is on record, and its commands are there; `benchmarks/evidence.py` runs them."""

import shlex
from pathlib import Path

import pytest

import evidence

ROOT = Path(__file__).parents[1]
ROWS = evidence.rows()


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.claim[:40])
def test_a_result_stands_on_the_page_that_it_names(row):
    assert evidence.missing(row.result, (ROOT / "docs" / row.record).read_text("utf-8")) == []


def test_every_row_is_read_and_its_program_exists():
    text = evidence.PAGE.read_text("utf-8")
    assert len(ROWS) == sum(line.count(" | ") == 5 for line in text.splitlines()) - text.count("| claim |")
    words = [shlex.split(row.command) for row in ROWS if row.command not in ("–", "vasowave demo")]
    assert {line[0] for line in words} == {"python", "pytest"}
    programs = [word for line in words for word in line if word.endswith(".py")]
    assert [name for name in programs if not (ROOT / name).is_file()] == []


def test_a_result_that_no_line_holds_is_missed():
    text = "| a | 28 | of 40 |\n| b | 0.05 |\n"
    assert evidence.missing("28 of 40, 0.05", text) == []
    assert evidence.missing("28 of 41; 0.05", text) == ["28 of 41"]
    assert evidence.missing("0.05 of 40", text) == ["0.05 of 40"]
