"""The manuscript says what the pages of evidence say; `benchmarks/paper_numbers.py` writes its numbers."""

import json
import re

import paper_numbers

MANUSCRIPT = (paper_numbers.PAPER / "manuscript.md").read_text("utf-8")


def test_every_number_of_the_manuscript_is_that_of_its_page():
    assert paper_numbers.filled(MANUSCRIPT) == MANUSCRIPT
    assert {one["name"] for one in paper_numbers.MARKED.finditer(MANUSCRIPT)} == {*paper_numbers.SOURCES}
    kept = json.loads((paper_numbers.PAPER / "numbers.json").read_text("utf-8"))
    assert {name: one["value"] for name, one in kept.items()} == {name: paper_numbers.found(name) for name in kept}
    assert all(re.fullmatch("[0-9a-f]{7,}", one["commit"]) for one in kept.values())


def test_a_number_that_is_out_of_date_is_written_anew_and_keeps_its_unit():
    assert paper_numbers.filled("in 0.5<!-- false.this --> of") == "in 0.061<!-- false.this --> of"
    assert paper_numbers.filled("by 1.0 mmHg<!-- solver.adan -->") == "by 0.028 mmHg<!-- solver.adan -->"


def test_every_citation_has_its_reference_and_no_reference_is_idle():
    listed = re.findall(r"@\w+\{(\w+),", (paper_numbers.PAPER / "references.bib").read_text("utf-8"))
    assert {*re.findall(r"@(\w+\d{4})", MANUSCRIPT)} == {*listed}


def test_the_manuscript_has_the_length_that_the_journal_asks_for():
    assert 1000 < len(re.sub(r"\A---.*?---|<!--.*?-->", "", MANUSCRIPT, flags=re.DOTALL).split()) < 1800
