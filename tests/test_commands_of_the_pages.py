"""What the pages tell a user to type: command lines, options, settings, files and Python.

All command lines are parsed. The site's build runs the blocks marked ``shown``; the other lines, and every block of
Python, run here in a folder that holds the files they name, of synthetic mice with three vessels, with one start a fit.
NOT_RUN names what does not run, with the reason.
"""

import ast
import re
import shlex
import shutil
import subprocess
import sys
import textwrap
from collections.abc import Iterator
from itertools import groupby
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from typer.main import get_command

import vasowave as vw
from made_pages import SCAN, write_files, write_scan
from vasowave.base import settings_of
from vasowave.cli import app
from vasowave.lung.revise import read_edits
from vasowave.study.folder import StudyFile, parse_document, validated

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
PAGES = [
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    *(
        page
        for page in sorted(DOCS.rglob("*.md"))
        if page.relative_to(DOCS).parts[0] not in ("made", "made-gallery", "changes")
    ),
]
FENCED = re.compile(r"^```([^\n]*)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
INDENTED = re.compile(r"(?:^ {4}[^\n]*\n(?:[ \t]*\n)*)+", re.MULTILINE)
COMMAND = re.compile(r"^(?:uv run )?vasowave (?P<words>.+)")
EXPLAINED = re.compile(r"\s{2,}|\s#\s")  # what stands behind a command line
PYTHON = re.compile(r"^(?:import|from) |\bvw\.", re.MULTILINE)

NOT_RUN = {
    "demo": "takes a minute; a study of fewer mice is run here and in tests/study",
    "plan": "takes most of a minute; the site's build and tests/study/cohort/test_planning.py run it",
    "open": "serves a page until it is stopped; tests/workbench start it",
    "--scheduler": "needs a cluster; tests/study start one",
    "az.plot_pair": "needs ArviZ, which no extra installs",
}
"""Commands, options and lines of Python that are understood and not run, and why."""
STUDY = {"new", "add", "check", "run"}
"""Commands whose order makes a study: they run on every page that has them in another order; other lines run once."""
QUICK = {"fit": ["--starts", "1", "--cell-size", "0.3", "--no-pdf"], "run": ["--no-report"], "report": ["--no-pdf"]}
"""What is typed behind a command so that it takes seconds."""


class Line(NamedTuple):
    """A command line of a page; a mention is one inside a sentence, whose arguments may be left out."""

    page: str
    text: str
    mention: bool
    shown: bool

    @property
    def words(self) -> list[str]:
        return shlex.split(COMMAND.match(self.text)["words"])

    @property
    def is_whole(self) -> bool:
        """Whether it can be typed as it stands: with arguments, and without a word in capitals for something else."""
        return not (self.mention and all(word.startswith("-") for word in self.words[1:])) and not any(
            re.fullmatch("[A-Z]{4,}", word) for word in self.words
        )


def blocks(page: Path) -> tuple[list[tuple[str, str]], str]:
    """Return marks and texts of the blocks of code of a page, in order, and the page without them."""
    found = []

    def take(match: re.Match) -> str:
        mark, inside = (match[1], match[2]) if match.re is FENCED else ("", textwrap.dedent(match[0]))
        found.append((match.start(), mark.strip(), inside))
        return re.sub(r"[^\n]", " ", match[0])  # of the same length, so that places stay

    left = INDENTED.sub(take, FENCED.sub(take, page.read_text(encoding="utf-8")))
    return [(mark, inside) for _, mark, inside in sorted(found)], left


def command_lines(page: Path, root: Path = ROOT) -> list[Line]:
    """Return the command lines of a page: those of its blocks, then those of its sentences and tables."""
    name = page.relative_to(root).as_posix()
    inside, left = blocks(page)
    found = [
        Line(name, EXPLAINED.split(line.strip())[0], False, mark == "{shown}")
        for mark, text in inside for line in text.splitlines() if COMMAND.match(line.strip())
    ]  # fmt: skip
    spans = (" ".join(span.split()) for span in re.findall(r"`([^`]+)`", left))
    return found + [Line(name, span, True, False) for span in spans if COMMAND.match(span)]


def python_of(page: Path) -> list[str]:
    """Return the blocks of Python of a page, in order."""
    return [text for mark, text in blocks(page)[0] if mark == "python" or (mark == "" and _is_python(text))]


def _is_python(text: str) -> bool:
    try:
        ast.parse(text)
    except SyntaxError:
        return False
    return bool(PYTHON.search(text))


LINES = [line for page in PAGES for line in command_lines(page)]


def options_of(command) -> set[str]:
    """Return the options of a command."""
    return {option for one in command.params for option in (*one.opts, *one.secondary_opts)} | {"--help"}


def wrong(line: Line) -> str:
    """Return what the command line says against a line; empty where it understands it."""
    group, words = get_command(app), line.words
    context = group.make_context("vasowave", ["check"])
    while words and words[0].startswith("-"):  # nothing of the group itself is called: it could set up the shell
        if words[0] not in options_of(group):
            return f"no such option: {words[0]}"
        words = words[1:]
    if not words or words[0] == "COMMAND":
        return ""
    try:
        name, command, rest = group.resolve_command(context, words)
        if line.mention and all(word.startswith("-") for word in rest):
            unknown = {*rest} - options_of(command)
            return f"no such option: {', '.join(unknown)}" if unknown else ""
        command.make_context(name, rest, parent=context)
    except Exception as error:
        return str(error) or repr(error)
    return ""


def test_every_command_line_is_one_that_the_command_line_understands():
    assert len(LINES) > 150
    assert {line.text: said for line in LINES if (said := wrong(line))} == {}


def test_every_option_in_a_sentence_is_one_of_a_command():
    group = get_command(app)
    context = group.make_context("vasowave", ["check"])
    known = {"--docs", "--intervals", "--record", "--upgrade"}  # of benchmarks and tools
    known |= options_of(group).union(
        *(options_of(group.resolve_command(context, [name])[1]) for name in group.commands)
    )
    spans = {span for page in PAGES for span in re.findall(r"`(--[a-z][^`]*)`", blocks(page)[1])}
    assert len(spans) > 60
    assert {span for span in spans if re.split(r"[\s=]", span)[0] not in known} == set()


def test_every_program_that_a_page_names_is_there():
    texts = (page.read_text(encoding="utf-8") for page in PAGES)
    named = {name for text in texts for name in re.findall(r"\b((?:benchmarks|tools)/\w+\.py)", text)}
    assert len(named) > 10
    assert {name for name in named if not (ROOT / name).is_file()} == set()


def test_a_misspelt_option_or_command_and_a_surplus_word_are_found(tmp_path):
    page = tmp_path / "page.md"
    page.write_text(
        "Type `vasowave fit a.csv b.txt --strats 4`, `vasowave chekc` or `vasowave status --jsn`, or\n\n"
        "    vasowave tidy a.csv b.csv    what it does\n\n```\nuv run vasowave fit   # without files\n```\n\n"
        "or `vasowave fit` with `vasowave run my-study`.\n",
        encoding="utf-8",
    )
    said = {line.text: wrong(line) for line in command_lines(page, tmp_path)}
    assert [text for text, words in said.items() if not words] == ["vasowave fit", "vasowave run my-study"]
    assert "--strats" in said["vasowave fit a.csv b.txt --strats 4"]
    assert len(said) == 7


def test_the_files_that_pages_print_are_files_that_are_read(tmp_path):
    """Tables of vessels and of sites, and edits."""
    printed = {name: blocks(DOCS / f"{name}.md")[0] for name in ("exchange", "how-to/sites", "extract")}
    (loop,) = (text for _, text in printed["exchange"] if text.startswith("name,from,to"))
    (tmp_path / "loop.csv").write_text(loop, encoding="utf-8")
    assert len(vw.read_network(tmp_path / "loop.csv")) == 6
    (sites,) = (text for _, text in printed["how-to/sites"] if text.startswith("quantity"))
    (tmp_path / "sites.csv").write_text(sites, encoding="utf-8")
    for name in ("lpa", "rpa-mri"):
        (tmp_path / f"{name}.csv").write_text("\n".join(f"{2 + np.sin(n / 10)}" for n in range(64)), encoding="utf-8")
    assert [one.quantity for one in vw.read_sites(tmp_path / "sites.csv")] == ["pressure", "flow", "diameter"]
    (edits,) = (text for _, text in printed["extract"] if text.startswith("# mouse 6"))
    (tmp_path / "edits.txt").write_text(edits, encoding="utf-8")
    assert len(read_edits(tmp_path / "edits.txt")) == 7


def settings_of_pages() -> Iterator[tuple[str, str]]:
    """Yield what pages say of a study file, without laws of one's own: page and lines of YAML."""
    for page in PAGES:
        if page.stem in ("constants", "findings"):  # which have words in place of values
            continue
        found, left = blocks(page)
        said = [text for mark, text in found if mark == "yaml"]
        said += re.findall(
            r"^(\w+: .*?) +# in study.yaml, under \w+$", "\n".join(text for _, text in found), re.MULTILINE
        )
        said += re.findall(r"`([a-z_]+: [^`{…]+(?:\{[^`…]+\})?)`", left)
        yield from ((page.name, text) for text in said if "our_" not in text)


def is_of_a_study(text: str) -> bool:
    """Return whether lines are settings of a study, at its top or within a section."""
    sections = [name for name, one in settings_of(StudyFile).items() if one.section]
    inside = [f"{name}:\n{textwrap.indent(text, '  ')}" for name in sections]
    inside += [f"design:\n  subject: mouse\n{textwrap.indent(text, '  ')}"]
    documents = (parse_document(f"groups: [CTL, HPH]\n{one}\n".encode(), "page") for one in (text, *inside))
    return any(not one.problems and validated(one) is not None for one in documents)


def test_settings_that_a_page_prints_are_settings_of_a_study():
    found = {*settings_of_pages()}
    assert len(found) > 30
    assert {one for one in found if not is_of_a_study(one[1])} == set()
    assert not is_of_a_study("inferense: posterior")
    assert not is_of_a_study("inference: posteriors")


def law_of_the_page() -> str:
    """Return the wall law that the page on walls prints."""
    (law,) = (text for text in python_of(DOCS / "walls.md") if "class ExponentialWall" in text)
    return law


def vasowave(folder: Path, words: list[str]) -> str:
    """Type a command in a folder; return what it printed if it failed."""
    quick = ["--starts", "1", "--no-pdf"] if "--practice" in words else QUICK.get(words[0], [])  # which sets the cells
    command = [sys.executable, "-m", "vasowave", *words, *quick]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, encoding="utf-8")
    return "" if done.returncode == 0 else f"{done.returncode}: {done.stdout}{done.stderr}"


def quicken(study: Path) -> None:
    """Let a new study fit one wall from one start."""
    text = (study / "study.yaml").read_text("utf-8")
    for usual, quick in (("starts: 20", "starts: 1"), ("walls: [linear, tangent]", "walls: [linear]")):
        assert usual in text
        text = text.replace(usual, quick)
    (study / "study.yaml").write_text(text, "utf-8")


def lines_to_run() -> Iterator[Line]:
    """Yield the lines that the site's build does not run."""
    seen: set = set()
    for _, lines in groupby(LINES, lambda line: line.page):
        once = {line.text: line for line in lines if not line.shown}.values()
        lines = [line for line in once if line.is_whole and not {*line.words} & {*NOT_RUN}]
        study = tuple(line.text for line in lines if line.words[0] in STUDY)
        yield from (line for line in lines if line.text not in seen or (line.text in study and study not in seen))
        seen |= {study, *(line.text for line in lines)}


def _made_by(words: list[str]) -> str:
    """Return the folder that a command makes."""
    return words[words.index("-o") + 1] if "-o" in words else words[1] if words[0] == "new" else "vasowave-fit"


@pytest.mark.weekly
def test_every_command_line_of_the_pages_does_what_it_should(tmp_path):
    write_files(tmp_path, law_of_the_page())
    write_scan(tmp_path)
    study, count = tmp_path / "my-study", 0
    for line in lines_to_run():
        if line.words[0] in ("new", "fit", "extract", "centerlines"):  # as if each page were read alone
            shutil.rmtree(tmp_path / _made_by(line.words), ignore_errors=True)
        said = vasowave(tmp_path, [word.replace("x,y,z", SCAN) for word in line.words])
        assert said == "", f"{line.page}: {line.text}"
        if line.words[0] == "new":
            quicken(study)
        count += 1
    assert count > 30


GIVEN = """
import matplotlib
matplotlib.use("Agg")
import numpy as np
import vasowave as vw
calibrate, coarse = vw.calibrate, {"numerics": vw.Numerics(cell_size=0.3, samples=64)}
vw.calibrate = lambda *given, **named: calibrate(*given, **coarse | named | {"starts": 1})
network = vw.read_network("network.csv")
recording = vw.read_recording("cycle.csv")
inflow, pressure, period = recording.inflow, recording.pressure, recording.period
model = vw.Model(network, vw.LinearWall(57.0), vw.estimate_nominal(network, recording).outlets)
"""
"""What stands above the lines of a page: names that it takes for given, and coarse cells and one start a search."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """Return a folder with the files that programs of pages name, and a study that was run."""
    folder = tmp_path_factory.mktemp("pages")
    write_files(folder, law_of_the_page())
    for label, name in (("CTL", "control"), ("HPH", "hypoxia")):
        for number in (1, 2):
            shutil.copy(folder / "lab" / name / f"mouse {number}.txt", folder / f"{label} {number}.txt")
    recordings = [str(path) for path in sorted(folder.glob("??? ?.txt"))]
    assert vasowave(folder, ["new", "my-study"]) == ""
    quicken(folder / "my-study")
    assert vasowave(folder, ["add", "my-study", "lung.csv", *recordings]) == ""
    assert vasowave(folder, ["run", "my-study"]) == ""
    shutil.copytree(folder / "my-study", folder / "study")
    return folder


@pytest.mark.validation
@pytest.mark.parametrize("page", [page for page in PAGES if python_of(page)], ids=lambda page: page.stem)
def test_the_python_of_a_page_runs(page, folder):
    lines = [line for text in python_of(page) for line in text.splitlines()]
    left = [re.sub(r"; +az\.\w+\(.*\)$", "", line) for line in lines]
    program = folder / f"{page.stem}_page.py"
    program.write_text(GIVEN + "\n".join(left), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, program.name], cwd=folder, capture_output=True, text=True, check=False, encoding="utf-8"
    )
    assert done.returncode == 0, done.stderr
