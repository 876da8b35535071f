"""A supplement of many animals: pages that stay small, each animal on one of them, links that lead somewhere."""

import re
from dataclasses import replace

import pytest

from made_cohort import made_results
from vasowave.study.report import write_report

MANY = 50


@pytest.fixture(scope="module")
def animals():
    """Fifty animals of one group, alike but for their names: what a page holds of them is what counts here."""
    (result,) = made_results({"CTL": 1}, walls=("linear",))
    return [replace(result, name=f"mouse {number:03d}") for number in range(1, MANY + 1)]


def folds_of(page):
    return re.findall(r"<summary>(mouse \d+) \(", page.read_text(encoding="utf-8"))


@pytest.mark.validation
def test_every_animal_of_many_stands_on_one_page_which_the_supplement_leads_to(animals, tmp_path, undrawn):
    write_report(animals, tmp_path, pdf=False)
    first = tmp_path / "supplement.html"
    linked = re.findall(r'href="(supplement-[^"]+)"', first.read_text(encoding="utf-8"))
    assert linked == ["supplement-animals-1.html", "supplement-animals-2.html"]
    assert folds_of(first) == []
    shown = [folds_of(tmp_path / name) for name in linked]
    assert [name for names in shown for name in names] == [animal.name for animal in animals]
    assert [len(names) for names in shown] == [48, 2]
    for name in linked:
        outward = re.findall(r'href="([^"#]+)"', (tmp_path / name).read_text(encoding="utf-8"))
        assert outward == ["supplement.html", "report.html"]
    write_report(animals[:3], tmp_path, pdf=False)
    assert folds_of(first) == [animal.name for animal in animals[:3]]
    assert not any((tmp_path / name).exists() for name in linked)  # pages of animals that are gone contradict this one
