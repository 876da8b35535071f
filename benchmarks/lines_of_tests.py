"""Which tests run which lines of the source: one pass of the default tests under coverage, kept in build/."""

import ast
import json
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from xml.etree import ElementTree

ROOT = Path(__file__).parents[1]
SOURCE, TESTS = ROOT / "src" / "vasowave", ROOT / "tests"
RECORDING = "uv run --with pytest-cov==7.1.0 python benchmarks/mutants.py --record"
RECORD = ROOT / "build" / "tests of lines.json"


def statement(file: Path, line: int) -> tuple[int, bool]:
    """Return the line where coverage counts the statement that holds a line, and whether import runs it."""
    nodes = list(ast.walk(ast.parse(file.read_text(encoding="utf-8"))))
    around = [node for node in nodes if isinstance(node, ast.stmt) and node.lineno <= line <= node.end_lineno]
    inside = [
        node for node in around
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and node.body[0].lineno <= line
    ]  # fmt: skip
    return max((node.lineno for node in around), default=line), not inside  # a decorator stands in no statement


@cache
def record() -> dict[str, dict]:
    """Return, as recorded, the tests of every line of every file (`lines`) and how long they take (`seconds`)."""
    return json.loads(RECORD.read_text()) if RECORD.exists() else {"lines": {}, "seconds": {}}


def record_lines(chosen: Sequence[str] = ()) -> None:
    """Run the default tests once under coverage; keep which test runs which lines, and how long each takes.

    Of `chosen` tests alone, what is found joins the record there is.
    """
    if find_spec("pytest_cov") is None:
        sys.exit(f"the record needs pytest-cov: {RECORDING}")
    RECORD.parent.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as name:
        times, environment = Path(name) / "times.xml", os.environ | {"COVERAGE_FILE": f"{name}/lines"}
        measured = [f"--cov={SOURCE}", "--cov-context=test", "--cov-report=", f"--junitxml={times}"]
        command = [sys.executable, "-m", "pytest", "-q", *measured, *chosen]
        subprocess.run(command, cwd=ROOT, env=environment, check=False)  # a test may fail under coverage
        seconds = {_node(case): float(case.get("time", 0)) for case in ElementTree.parse(times).iter("testcase")}
        lines = lines_of(Path(name) / "lines", seconds)
    known = record() if chosen else {"lines": {}, "seconds": {}}
    for file, tests_of_line in known["lines"].items():
        for line, tests in tests_of_line.items():
            there = lines.setdefault(file, {}).setdefault(int(line), [])
            there += [test for test in tests if test not in seconds]
    RECORD.write_text(json.dumps({"lines": lines, "seconds": known["seconds"] | seconds}))
    print(f"{len(seconds)} tests run lines of {len(lines)} files")


def _node(case: ElementTree.Element) -> str:
    """Return the name by which pytest runs a test again."""
    return case.get("classname", "").replace(".", "/") + ".py::" + case.get("name", "")


def lines_of(measured: Path, tests: Iterable[str]) -> dict[str, dict[int, list[str]]]:
    """Return the tests that run each line of each file; what one sets up, its file uses and those that share it."""
    from coverage import CoverageData

    data, beside = CoverageData(str(measured)), {}
    data.read()
    for test in tests:
        beside.setdefault(test.partition("::")[0], []).append(test)
    shared = {file: _shared(ROOT / file) for file in beside}

    def use(context: str) -> Iterator[str]:
        test, _, phase = context.rpartition("|")
        if phase != "setup":
            yield test
            return
        own = test.partition("::")[0]
        for file, others in beside.items():
            if file == own or shared[file] & shared.get(own, set()):
                yield from others

    found: dict[str, dict[int, list[str]]] = {}
    for file in data.measured_files():
        for line, contexts in data.contexts_by_lineno(file).items():
            users = sorted({test for context in contexts if context for test in use(context)} & set(tests))
            found.setdefault(str(Path(file).relative_to(ROOT)), {})[line] = users
    return found


def _shared(file: Path) -> set[str]:
    """Return the fixtures of a whole session that a file of tests names, and those that these need."""
    above = [folder / "conftest.py" for folder in file.parents if folder.is_relative_to(TESTS)]
    conftests = "".join(path.read_text(encoding="utf-8") for path in above if path.is_file())
    needs = dict(re.findall(r'scope="session".*\)\ndef (\w+)\((.*?)\)', conftests))
    words = set(re.findall(r"\w+", file.read_text(encoding="utf-8"))) if file.exists() else set()
    named = words & set(needs)
    for _ in needs:
        named |= {name for one in named for name in re.findall(r"\w+", needs[one]) if name in needs}
    return named
