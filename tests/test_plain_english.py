"""The rules of docs/writing.md that a program can check: words, length of sentences, beginnings."""

import importlib
import pkgutil
import re
from pathlib import Path

import pytest

import vasowave
from vasowave.base import KINDS

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
NOT_PROSE = ("made", "made-gallery", "changes", "writing.md", "findings.md", "constants.md", "results-file.md")
PAGES = [
    ROOT / "README.md",
    *(page for page in sorted(DOCS.rglob("*.md")) if not {*page.relative_to(DOCS).parts} & {*NOT_PROSE}),
]
WAY = [page for page in PAGES if page.parent not in (DOCS, DOCS / "decisions")] + [DOCS / "index.md"]
BESIDE = {*re.findall(r"^\S+$", (DOCS / "evidence.md").read_text(encoding="utf-8"), re.MULTILINE),
          "evidence", "decisions", "package", "study-file", "api", "manuscript", "trials"}  # fmt: skip
"""Pages that a user need not read: evidence, reasons, what is made from declarations."""
MOST, A_PICTURE = 20_000, 600  # words of all pages of a user; words of a page for which it has a picture
LONGEST = 40  # words
NOUNS = "Speed|Seed|Bed|Need|Red|Threshold|Fold|Specimen|Children|Men|Women|Screen|Token|Decade|Grade|Blade"
TURNED = re.compile(
    rf"^(?!(?:{NOUNS})\b)[A-Z][a-z]+(?:ed|en|ade|own|ept|eft|old|aid|ound|rawn) (?:is|are|was|were|stands?)\b"
)


def prose(text: str) -> list[str]:
    """Return the sentences of a page of Markdown, without code, tables, captions' marks and links' targets."""
    text = re.sub(
        r"```.*?```|^(?: {4}|\t)[^\n]*$|^\|[^\n]*$|^#[^\n]*$|<!--.*?-->", "\n\n", text, flags=re.DOTALL | re.MULTILINE
    )
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", text)
    blocks = re.split(r"\n\s*\n|\n\s*(?:[-*]|\d+\.) ", text)
    return [
        one.strip() for block in blocks for one in re.split(r"(?<=[.!?])\s+", " ".join(block.split())) if one.strip()
    ]


def words_of_the_house() -> list[str]:
    table = (DOCS / "writing.md").read_text(encoding="utf-8").partition("| not | but |")[2]
    return [row.split("|")[1].strip() for row in table.splitlines() if row.startswith("| ")]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_a_page_has_none_of_the_words_that_have_a_plainer_one(page):
    text = " ".join(prose(page.read_text(encoding="utf-8"))).lower()
    assert [word for word in words_of_the_house() if re.search(rf"\b{re.escape(word.lower())}\b", text)] == []


@pytest.mark.parametrize("page", WAY, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_sentences_on_the_way_of_a_user_are_short(page):
    assert [one for one in prose(page.read_text(encoding="utf-8")) if len(one.split()) > LONGEST] == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_no_sentence_of_a_page_begins_with_a_participle(page):
    assert [one for one in prose(page.read_text(encoding="utf-8")) if TURNED.search(one)] == []


def test_no_message_begins_with_a_participle_or_has_such_a_word():
    for found in pkgutil.walk_packages(vasowave.__path__, "vasowave."):
        if not found.name.endswith("__main__"):
            importlib.import_module(found.name)
    said = [(kind.code, text) for kind in KINDS.values() for text in (kind.text, kind.remedy)]
    assert [pair for pair in said if TURNED.search(pair[1])] == []
    assert [
        (code, word) for code, text in said for word in words_of_the_house() if re.search(rf"\b{word}\b", text.lower())
    ] == []


def test_the_checks_can_fail():
    assert sum(len(prose(page.read_text(encoding="utf-8"))) for page in PAGES) > 1000
    assert len(prose("One. Two. Three. [Four](five.md)\n\n    code is not prose\n\n| a | table |")) == 4
    assert TURNED.search("Compared are the harmonics 0 to 20.")
    assert not TURNED.search("Compared with the others it is small.")
    assert "utilize" in words_of_the_house()


def words_and_pictures(text: str) -> tuple[int, int]:
    return sum(len(one.split()) for one in prose(text)), len(re.findall(r"\{image\}|!\[|<img ", text))


def test_pages_that_a_user_reads_have_few_words_and_many_pictures():
    """A page of up to 600 words needs no picture, a longer one has one for every 600 of its words."""
    counted = {
        page.relative_to(ROOT).as_posix(): words_and_pictures(page.read_text(encoding="utf-8"))
        for page in PAGES if not {page.stem, page.parent.name} & BESIDE
    }  # fmt: skip
    assert 10_000 < sum(words for words, _ in counted.values()) < MOST
    assert {
        page: each for page, each in counted.items() if each[0] > A_PICTURE * max(each[1], each[0] <= A_PICTURE)
    } == {}
    assert words_and_pictures("One two.\n\n```{image} a.svg\n:alt: b\n```\n\n*Three.*\n\n    code") == (3, 1)
