"""Break random lines of the source, one at a time, and see whether the tests that belong to them notice.

uv run python benchmarks/mutants.py 5                  five mutants: minutes
uv run python benchmarks/mutants.py 100 --seed 3       an afternoon
uv run python benchmarks/mutants.py 20 --in imaging    only in one part of the package
uv run python benchmarks/mutants.py 100 --seed 3 --record    first: which tests run these lines; as long as the tests
uv run python benchmarks/mutants.py 100 --seed 3 --again     what survived meets the tests once more
uv run python benchmarks/mutants.py 100 --seed 3 --docs

A mutant is one change in one line: a comparison turned or moved by one, an operator exchanged, a number changed,
`and` for `or`, a condition negated. Lines are drawn evenly from all of src. A mutant meets the tests that run its
line, by the record in build/, those with the module's own name first, then approved descriptions, then the quick
ones, and at last what holds in every module. A flag, and a line that runs on import, meet that first, the latter then
all tests that run functions of the module; a line that nothing records (compiled kernels), the four files of tests
that are nearest: those that import the module, then what imports it. With --whole all default tests run. The tests
run in a fork of this process, which has loaded the libraries. Outcomes are kept in build/, one file a mutant: several
of these commands share the work, and one that was stopped goes on. Tests that would take more than a minute of a
processor (of compiled kernels four) are not all run, so that the share that is noticed is a lower bound; a test that
takes far longer than it does has noticed. Exit code 1: one survived.
"""

import argparse
import ast
import json
import multiprocessing
import os
import random
import re
import resource
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

from lines_of_tests import RECORD, ROOT, SOURCE, TESTS, is_compiled, record, record_lines, statement
from robustness_page import put

LONGEST = 900  # s; a mutant that makes the tests hang is noticed
FEW = 4  # files of tests that import a module or what imports it, those with its own name first
PATIENCE, COMPILING = 60, 240  # s of a processor that the tests of one mutant may take, also where it is compiled
LONGER = 10  # times its usual time (and 5 s) is a test that does not end
OUT_OF_TIME = (-signal.SIGXCPU, -signal.SIGKILL)
EVERYWHERE = "tests/test_conventions.py"  # what holds in every module
FLAGS = ("True", "False")
LOADED = ("matplotlib.pyplot", "numba", "pandas", "pytest", "scipy.optimize", "scipy.signal", "scipy.stats", "xarray")

COMPARED = {ast.Lt: "<=", ast.LtE: "<", ast.Gt: ">=", ast.GtE: ">", ast.Eq: "!=", ast.NotEq: "=="}
OPERATED = {ast.Add: "-", ast.Sub: "+", ast.Mult: "/", ast.Div: "*", ast.FloorDiv: "*", ast.Pow: "*"}
SIGNS = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.FloorDiv: "//", ast.Pow: "**"}
TURNED = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!="}


class Mutant(NamedTuple):
    """One change: `old` at a line and column (counted from 0, in characters) of a file becomes `new`."""

    file: Path
    line: int
    column: int
    old: str
    new: str

    def __str__(self) -> str:
        return f"{self.file.relative_to(ROOT)}:{self.line} `{self.old}` → `{self.new}`"

    def source(self) -> str:
        """Return the source with the change."""
        lines = self.file.read_text(encoding="utf-8").splitlines(keepends=True)
        text = lines[self.line - 1]
        assert text[self.column :].startswith(self.old)
        lines[self.line - 1] = text[: self.column] + self.new + text[self.column + len(self.old) :]
        return "".join(lines)


def mutants_of(file: Path) -> Iterator[Mutant]:
    """Yield every change that one file allows."""
    text = file.read_text(encoding="utf-8")
    lines = text.splitlines()

    def between(left: ast.expr, right: ast.expr, sign: str, new: str) -> Iterator[Mutant]:
        """Yield the change of the sign between two operands that stand on one line."""
        if left.end_lineno != right.lineno:
            return
        line = lines[right.lineno - 1].encode()
        gap = line[left.end_col_offset : right.col_offset].decode()
        if gap.count(sign) == 1:
            column = len(line[: left.end_col_offset].decode()) + gap.index(sign)
            yield Mutant(file, right.lineno, column, sign, new)

    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Compare) and len(node.ops) == 1 and type(node.ops[0]) in COMPARED:
            kind = type(node.ops[0])
            yield from between(node.left, node.comparators[0], TURNED[kind], COMPARED[kind])
        elif isinstance(node, ast.BinOp) and type(node.op) in OPERATED and not _is_text(node):
            yield from between(node.left, node.right, SIGNS[type(node.op)], OPERATED[type(node.op)])
        elif isinstance(node, ast.BoolOp):
            old, new = ("and", "or") if isinstance(node.op, ast.And) else ("or", "and")
            yield from between(node.values[0], node.values[1], old, new)
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            yield Mutant(file, node.lineno, _column(lines, node), "not ", "")
        elif isinstance(node, ast.Constant) and type(node.value) in (int, float) and node.lineno == node.end_lineno:
            column = _column(lines, node)
            old = lines[node.lineno - 1].encode()[node.col_offset : node.end_col_offset].decode()
            yield Mutant(file, node.lineno, column, old, _other_number(old, node.value))
        elif isinstance(node, ast.Constant) and type(node.value) is bool:
            yield Mutant(file, node.lineno, _column(lines, node), str(node.value), str(not node.value))


def _is_text(node: ast.BinOp) -> bool:
    return any(
        isinstance(one, ast.JoinedStr) or isinstance(getattr(one, "value", None), str)
        for one in (node.left, node.right)
    )


def _column(lines: list[str], node: ast.expr) -> int:
    return len(lines[node.lineno - 1].encode()[: node.col_offset].decode())


def _other_number(text: str, value: float) -> str:
    if isinstance(value, int):
        return str(value + 1)
    return repr(value * 2) if value else "1.0"


def drawn(count: int, seed: int, part: str = "") -> list[Mutant]:
    """Return changes of `count` lines drawn evenly from all lines that allow one."""
    rng, lines = random.Random(seed), {}
    for file in sorted(SOURCE.rglob("*.py")):
        if part in str(file.relative_to(SOURCE)):
            for mutant in mutants_of(file):
                lines.setdefault((file, mutant.line), []).append(mutant)
    return [rng.choice(lines[where]) for where in rng.sample(sorted(lines), min(count, len(lines)))]


def tests_of(mutant: Mutant) -> list[str]:
    """Return the tests that run a mutant's line, the module's namesakes and the quick ones first."""
    recorded, (begin, on_import) = record(), statement(mutant.file, mutant.line)
    of_all = on_import or mutant.old in FLAGS
    of_module = recorded["lines"].get(str(mutant.file.relative_to(ROOT)), {})
    running = sorted({test for tests in of_module.values() for test in tests}) if on_import else []
    running = running or of_module.get(str(begin), [])
    first, last = ([EVERYWHERE], []) if of_all else ([], [EVERYWHERE])
    if not running:
        near = [str(test.relative_to(ROOT)) for test in nearest_tests(mutant.file)]
        return [*first, *near, *last]
    seconds = recorded["seconds"]
    namesakes = {test for test in running if mutant.file.stem in Path(test.partition("::")[0]).stem}
    running.sort(key=lambda test: (test not in namesakes, "approved" not in test, seconds[test]))
    return [*first, *running, *last]


def nearest_tests(file: Path) -> list[Path]:
    """Return its namesakes among the files of tests, then those that import a module, what imports it, and so on."""
    tests, modules = sorted(TESTS.rglob("test_*.py")), [_name(file)]
    near = [test for test in tests if file.stem in test.stem]
    known = set(modules)
    while modules and len(near) < FEW:
        near += [test for test in tests if test not in near and any(_imports(test, module) for module in modules)]
        above = [_name(one) for one in SOURCE.rglob("*.py") if any(_imports(one, module) for module in modules)]
        modules = [module for module in dict.fromkeys(above) if module not in known]
        known.update(modules)
    return near[:FEW] or [TESTS / "test_package.py"]


def _name(file: Path) -> str:
    name = ".".join(file.relative_to(SOURCE.parent).with_suffix("").parts)
    return name.removesuffix(".__init__")


def _imports(file: Path, module: str) -> bool:
    return module in _imported(file)


@cache
def _imported(file: Path) -> frozenset[str]:
    """Return all that a file imports, modules and names in them; imports in its strings count too."""
    text = file.read_text(encoding="utf-8")
    modules = set(re.findall(r"^\s*import ([\w.]+)", text, re.MULTILINE))
    for room, names in re.findall(r"^\s*from ([\w.]+) import (\([^)]*\)|.*)", text, re.MULTILINE):
        known = re.findall(r"\w+", names)
        modules |= {
            room,
            *(f"{room}.{name}" for name in known),
            *(_faces(room)[name] for name in known if name in _faces(room)),
        }
    return frozenset(modules)


@cache
def _faces(package: str) -> dict[str, str]:
    """Return the module of every name that the face of a package offers."""
    stub = SOURCE.parent.joinpath(*package.split("."), "__init__.pyi")
    text = stub.read_text(encoding="utf-8") if stub.is_file() else ""
    return {name: module for module, name in re.findall(r"^from ([\w.]+) import \w+ as (\w+)", text, re.MULTILINE)}


def noticed_by(mutant: Mutant, whole: bool = False) -> str:
    """Return the test that fails with the mutant, or why it could not run; empty if it survives."""
    chosen = [str(TESTS)] if whole else tests_of(mutant)
    with tempfile.TemporaryDirectory(prefix="mutant-") as name:
        folder = Path(name).resolve()
        shutil.copytree(SOURCE, folder / "vasowave", ignore=shutil.ignore_patterns("kernels-*"))
        (folder / "vasowave" / mutant.file.relative_to(SOURCE)).write_text(mutant.source(), encoding="utf-8")
        limit = 0 if whole else COMPILING if is_compiled(mutant.file) else PATIENCE
        tested = multiprocessing.get_context("fork").Process(target=_test, args=(folder, chosen, limit))
        tested.start()
        tested.join(LONGEST)
        if tested.is_alive():
            os.killpg(tested.pid, signal.SIGKILL)
            return "the tests do not end"
        said = (folder / "said").read_text(encoding="utf-8", errors="replace")
        hanging = _hanging(folder / "begun", limit) if tested.exitcode in OUT_OF_TIME else ""
    if absent := re.search(r"^ERROR: not found: (.*)$", said, re.MULTILINE):
        raise SystemExit(f"the record names a test that is not there: {absent[1]}; record anew (--record)")
    failed = re.search(r"^(?:FAILED|ERROR) (\S+)", said, re.MULTILINE)
    if tested.exitcode in (0, 5, *OUT_OF_TIME):
        return hanging and f"{hanging} does not end"
    return failed[1] if failed else f"pytest ended with {tested.exitcode}"


class _Begun:
    """A plugin of pytest: which test begins, and at what time of the processor."""

    def __init__(self, file: Path):
        self._file = file

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        self._file.write_text(f"{time.process_time()} {nodeid}", encoding="utf-8")


def _hanging(file: Path, limit: float) -> str:
    """Return the test that took the rest of the time though it usually takes a small part of that."""
    since, _, test = file.read_text(encoding="utf-8").partition(" ") if file.exists() else ("", "", "")
    if not since:  # ended as it was written
        return ""
    usual = record()["seconds"].get(test, limit)
    return test if limit - float(since) > LONGER * usual + 5 else ""


def _test(folder: Path, chosen: list[str], limit: int) -> None:
    """Run tests on the package in a folder, in a process and a group of its own, and end with pytest's status.

    They may take `limit` seconds of a processor; 0 is no limit.
    """
    os.setpgrp()  # no new session: it would have a share of the machine of its own
    if limit:
        resource.setrlimit(resource.RLIMIT_CPU, (limit, limit))
    with (folder / "said").open("w") as said:
        os.dup2(said.fileno(), 1)
        os.dup2(said.fileno(), 2)
    os.chdir(ROOT)
    os.environ |= {"PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1"}
    sys.dont_write_bytecode = True
    sys.path.insert(0, str(folder))
    import pytest

    begun = _Begun(folder / "begun")
    os._exit(pytest.main(["-x", "-q", "-p", "no:cacheprovider", "-n", "0", *chosen], [begun]))


def table(found: dict[Mutant, str]) -> str:
    """Return how many were planted and noticed, by part of the package, and the survivors."""
    parts: dict[str, list[str]] = {}
    for mutant, test in found.items():
        parts.setdefault(mutant.file.relative_to(SOURCE).parts[0].removesuffix(".py"), []).append(test)
    lines = ["| part | mutants | noticed |", "|---|---|---|"]
    lines += [f"| {part} | {len(tests)} | {sum(map(bool, tests))} |" for part, tests in sorted(parts.items())]
    lines.append(f"| all | {len(found)} | {sum(map(bool, found.values()))} |")
    return "\n".join(lines) + "\n\n" + "".join(f"- {mutant}\n" for mutant, test in found.items() if not test)


def tried(mutants: list[Mutant], folder: Path, whole: bool = False) -> None:
    """Try what nobody tried or takes at present, one file a mutant; print what comes of it."""
    folder.mkdir(parents=True, exist_ok=True)
    for number, mutant in enumerate(mutants):
        try:
            file = (folder / f"{number}.json").open("x", encoding="utf-8")
        except FileExistsError:
            continue
        with file:
            noticed = noticed_by(mutant, whole)
            json.dump([str(mutant), noticed], file)
        print(f"{number} {mutant}: {noticed or 'SURVIVED'}", flush=True)


def outcomes(mutants: list[Mutant], folder: Path) -> dict[Mutant, str]:
    """Return the test that noticed each mutant that was tried, empty if it survived; forget those of other sources."""
    found: dict[Mutant, str] = {}
    for number, mutant in enumerate(mutants):
        path = folder / f"{number}.json"
        said = path.read_text(encoding="utf-8") if path.exists() else ""
        if said and json.loads(said)[0] == str(mutant):
            found[mutant] = json.loads(said)[1]
        elif said:
            path.unlink()
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("count", type=int, nargs="?", default=5)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--in", dest="part", default="", help="word in the path of the file")
    parser.add_argument("--whole", action="store_true", help="run all default tests")
    parser.add_argument("--record", nargs="*", metavar="TEST", help="find out which tests run the lines, all or some")
    parser.add_argument("--list", action="store_true", help="only say which mutants are drawn, and their tests")
    parser.add_argument("--again", action="store_true", help="try again what survived")
    parser.add_argument("--docs", action="store_true", help="put the table into docs/robustness.md")
    arguments = parser.parse_args()
    chosen = drawn(arguments.count, arguments.seed, arguments.part)
    folder = RECORD.parent / "mutants" / f"{arguments.seed} {arguments.part.replace('/', ' ')}".strip()
    os.environ["NUMBA_CACHE_DIR"] = str(RECORD.with_name("kernels"))  # compiled source decides: a mutant finds its own
    if arguments.record is not None:
        record_lines({(one.file, one.line) for one in chosen}, arguments.record)
        return 0
    if arguments.list:
        for mutant in chosen:
            print(mutant, *tests_of(mutant))
        return 0
    earlier = outcomes(chosen, folder)
    for number, mutant in enumerate(chosen):
        if arguments.again and earlier.get(mutant) == "":
            (folder / f"{number}.json").unlink()
    for library in LOADED:
        import_module(library)
    tried(chosen, folder, arguments.whole)
    found = outcomes(chosen, folder)
    print("\n" + table(found))
    if arguments.docs:
        put("mutants", table(found))
    return 1 if not all(found.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
