"""Which tests run which lines of the source: one pass of the default tests over a copy in which these lines report.

A line reports with the name of the test that runs, also from processes that the test starts. Compiled kernels cannot.
"""

import ast
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

ROOT = Path(__file__).parents[1]
SOURCE, TESTS = ROOT / "src" / "vasowave", ROOT / "tests"
RECORD = ROOT / "build" / "tests of lines.json"
COMPILED = ("walls.py", "powers.py")  # beside the files that import numba

REPORTER = """
import os
import pathlib

_FOLDER, _SAID = pathlib.Path({folder!r}), set()


def ran(place):
    said = f"{{place}}\\t{{os.environ.get('PYTEST_CURRENT_TEST', '')}}"
    if said not in _SAID:
        _SAID.add(said)
        try:
            with (_FOLDER / str(os.getpid())).open("a") as file:
                file.write(said + "\\n")
        except OSError:
            pass  # a test that takes the machine away
"""

Place = tuple[Path, int]


def statement(file: Path, line: int) -> tuple[int, bool]:
    """Return the line where the statement begins that holds a line, and whether import runs it."""
    nodes = list(ast.walk(ast.parse(file.read_text(encoding="utf-8"))))
    around = [node for node in nodes if isinstance(node, ast.stmt) and node.lineno <= line <= node.end_lineno]
    inside = [
        node for node in around
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and node.body[0].lineno <= line
    ]  # fmt: skip
    return max((node.lineno for node in around), default=line), not inside  # a decorator stands in no statement


def is_compiled(file: Path) -> bool:
    """Whether the functions of a file are compiled, so that no line of them can report."""
    return file.name in COMPILED or "\nfrom numba import" in file.read_text(encoding="utf-8")


@cache
def record() -> dict[str, dict]:
    """Return, as recorded, the tests of lines of files (`lines`) and how long they take (`seconds`)."""
    return json.loads(RECORD.read_text()) if RECORD.exists() else {"lines": {}, "seconds": {}}


def record_lines(places: Iterable[Place], chosen: Sequence[str] = ()) -> None:
    """Run the default tests once on a copy in which `places` report; what is found joins the record there is.

    Of `chosen` tests alone, the others that are known of a line stay.
    """
    with tempfile.TemporaryDirectory() as name:
        copy, times, reports = Path(name) / "copy", Path(name) / "times.xml", Path(name) / "reports"
        reports.mkdir()
        shutil.copytree(SOURCE, copy / "vasowave")
        (copy / "reporter.py").write_text(REPORTER.format(folder=str(reports)), encoding="utf-8")
        asked = _reporting(places, copy)
        environment = os.environ | {"PYTHONPATH": str(copy)}
        command = [sys.executable, "-m", "pytest", "-q", f"--junitxml={times}", *chosen]
        subprocess.run(command, cwd=ROOT, env=environment, check=False)  # a test that reads the source may fail
        seconds = {_node(case): float(case.get("time", 0)) for case in ElementTree.parse(times).iter("testcase")}
        said = [line for path in reports.iterdir() for line in path.read_text(encoding="utf-8").splitlines()]
    known, found = record(), lines_of(said, seconds)
    lines = known["lines"]
    for file, begin in asked:
        of_file, new = lines.setdefault(file, {}), found.get(file, {}).get(begin, [])
        kept = [test for test in of_file.get(begin, []) if chosen and test not in seconds]
        of_file[begin] = sorted({*kept, *new})
    RECORD.parent.mkdir(exist_ok=True)
    RECORD.write_text(json.dumps({"lines": lines, "seconds": known["seconds"] | seconds}))
    print(f"{len(seconds)} tests, {len(asked)} lines")


def _reporting(places: Iterable[Place], copy: Path) -> set[tuple[str, str]]:
    """Make the statements at `places` report in the copy; return the files and lines by which they do.

    For a line that runs on import, every function of its module reports.
    """
    of_file: dict[Path, dict[int, bool]] = {}
    for file, line in places:
        begin, on_import = statement(file, line)
        of_file.setdefault(file, {})[begin] = on_import
    asked: set[tuple[str, str]] = set()
    for file, begins in of_file.items():
        if is_compiled(file):
            continue
        name = str(file.relative_to(ROOT))
        tree = _Reporting(name, begins).visit(ast.parse(file.read_text(encoding="utf-8")))
        first = next((n for n, one in enumerate(tree.body) if not _begins_a_file(one)), len(tree.body))
        tree.body.insert(first, ast.parse("from reporter import ran as _ran").body[0])
        (copy / file.relative_to(SOURCE.parent)).write_text(ast.unparse(ast.fix_missing_locations(tree)), "utf-8")
        asked |= {(name, str(begin)) for begin in begins}
    return asked


def _begins_a_file(one: ast.stmt) -> bool:
    docstring = isinstance(one, ast.Expr) and isinstance(one.value, ast.Constant)
    return docstring or (isinstance(one, ast.ImportFrom) and one.module == "__future__")


class _Reporting(ast.NodeTransformer):
    """Puts a report before the statements that begin at certain lines, or into all functions."""

    def __init__(self, name: str, begins: dict[int, bool]):
        self._name, self._inside = name, False
        self._own = {begin for begin, on_import in begins.items() if not on_import}
        self._everywhere = [begin for begin, on_import in begins.items() if on_import]

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.FunctionDef:
        outer, self._inside = self._inside, True
        self.generic_visit(node)
        self._inside = outer
        documented = ast.get_docstring(node) is not None
        node.body[documented:documented] = [self._report(begin) for begin in self._everywhere]
        return node

    def generic_visit(self, node: ast.AST) -> ast.AST:
        super().generic_visit(node)
        for field in ("body", "orelse", "finalbody"):
            block = getattr(node, field, None)
            if self._inside and isinstance(block, list):
                setattr(node, field, [one for each in block for one in self._with_report(each)])
        return node

    def _with_report(self, one: ast.stmt) -> Iterator[ast.stmt]:
        if getattr(one, "lineno", None) in self._own:
            yield self._report(one.lineno)
        yield one

    def _report(self, begin: int) -> ast.stmt:
        return ast.parse(f"_ran({f'{self._name}:{begin}'!r})").body[0]


def _node(case: ElementTree.Element) -> str:
    """Return the name by which pytest runs a test again."""
    return case.get("classname", "").replace(".", "/") + ".py::" + case.get("name", "")


def lines_of(said: Iterable[str], tests: Iterable[str]) -> dict[str, dict[str, list[str]]]:
    """Return the tests that run each line of each file; what one sets up, its file uses and those that share it."""
    beside: dict[str, list[str]] = {}
    for test in tests:
        beside.setdefault(test.partition("::")[0], []).append(test)
    shared = {file: _shared(ROOT / file) for file in beside}

    def use(context: str) -> Iterator[str]:
        test, _, phase = context.rpartition(" ")
        if phase != "(setup)":
            yield test
            return
        own = test.partition("::")[0]
        for file, others in beside.items():
            if file == own or shared[file] & shared.get(own, set()):
                yield from others

    found: dict[str, dict[str, set[str]]] = {}
    for line in said:
        place, _, context = line.partition("\t")
        file, _, begin = place.rpartition(":")
        if context:
            found.setdefault(file, {}).setdefault(begin, set()).update(use(context))
    known = set(tests)
    return {file: {begin: sorted(of & known) for begin, of in lines.items()} for file, lines in found.items()}


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
