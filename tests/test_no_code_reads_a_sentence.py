"""No code of ours decides by the words of a note, a warning or an error: these are for people."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import vasowave

SOURCE = Path(vasowave.__file__).parent

ALLOWED = {
    "base/runtime/memory.py:is_starved": "the operating system, NumPy and LLVM say only in words that memory ran out",
    "study/cohort/primary.py:_check": "the name of a quantity",
    "study/report/sections/animals.py:starts_frame": "the name of a variable",
    "lung/read/vti.py:array_of": "the numbers of an element of XML",
}
"""Functions that read words which others wrote."""

SENTENCES = {"note", "message", "sentence", "warning", "remark", "reason", "complaint", "suspicion", "doubt", "finding"}
ATTRIBUTES = {"text", "message", "msg", "reason", "remedy", "notes", "warnings", "findings", "problems", "stderr"}
SEARCHES = {"startswith", "endswith", "find", "rfind", "index", "rindex", "count", "partition", "rpartition", "split",
            "removeprefix", "removesuffix"}  # fmt: skip
MATCHES = {"match", "search", "fullmatch", "findall", "finditer", "sub", "subn", "split"}
SAME = {"lower", "upper", "casefold", "strip", "lstrip", "rstrip", "join", "replace", "decode", "splitlines"}
"""Methods whose result is as much a sentence as what they are called on."""


def readings(tree: ast.Module) -> Iterator[tuple[str, int]]:
    """Yield function and line of every place that looks into a sentence."""
    for function in ast.walk(tree):
        if isinstance(function, ast.FunctionDef):
            known = _sentences_of(function)
            for node in _own(function):
                if _reads(node, known):
                    yield function.name, node.lineno


def _own(function: ast.FunctionDef) -> Iterator[ast.AST]:
    for node in ast.iter_child_nodes(function):
        if not isinstance(node, ast.FunctionDef):
            yield node
            yield from _own(node)  # type: ignore[arg-type]


def _sentences_of(function: ast.FunctionDef) -> tuple[set[str], set[str]]:
    """Return the names in a function that hold sentences, and those of errors and findings."""
    values = {one.name for one in ast.walk(function) if isinstance(one, ast.ExceptHandler) and one.name}
    values |= {"error", "exception", "caught", "finding", "warning", "problem"}
    words = set(SENTENCES)
    for _ in range(2):  # a name that was given a sentence holds one, in whatever order they stand
        for node in ast.walk(function):
            if isinstance(node, ast.Assign) and _is_sentence(node.value, (words, values)):
                words |= {one.id for one in node.targets if isinstance(one, ast.Name)}
            if isinstance(node, ast.NamedExpr) and _is_sentence(node.value, (words, values)):
                words.add(node.target.id)
    return words, values


def _is_sentence(node: ast.AST, known: tuple[set[str], set[str]]) -> bool:
    words, values = known
    if isinstance(node, ast.Name):
        return node.id in words
    if isinstance(node, ast.Attribute):
        return node.attr in ATTRIBUTES and not (isinstance(node.value, ast.Name) and node.value.id in ("np", "re"))
    if isinstance(node, ast.Subscript):
        named = isinstance(node.slice, ast.Constant) and node.slice.value in ATTRIBUTES
        return named or (isinstance(node.value, ast.Name) and _is_sentence(node.value, known))
    if isinstance(node, ast.BoolOp):
        return any(_is_sentence(one, known) for one in node.values)
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in ("str", "repr", "getattr"):
        return any((isinstance(one, ast.Name) and one.id in values) or _is_sentence(one, known) for one in node.args)
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "texts":
        return True
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in SAME:
        return _is_sentence(node.func.value, known) or any(_is_sentence(one, known) for one in node.args)
    return isinstance(node, ast.IfExp) and (_is_sentence(node.body, known) or _is_sentence(node.orelse, known))


def _reads(node: ast.AST, known: tuple[set[str], set[str]]) -> bool:
    if isinstance(node, ast.Compare):
        sides = [node.left, *node.comparators]
        for operator, left, right in zip(node.ops, sides, sides[1:], strict=False):
            words = any(isinstance(one, ast.Constant) and isinstance(one.value, str) for one in (left, right))
            if isinstance(operator, ast.In | ast.NotIn):
                if _is_text(right, known) or (words and _is_written(right)) or (_is_sentence(left, known) and words):
                    return True
            elif isinstance(operator, ast.Eq | ast.NotEq) and _says(left, right, known):
                return True
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
        if node.func.attr in SEARCHES and (_is_sentence(node.func.value, known) or _is_written(node.func.value)):
            return bool(node.args)
        if node.func.attr in MATCHES and any(_is_sentence(one, known) for one in node.args):
            return True
    return False


def _is_text(node: ast.AST, known: tuple[set[str], set[str]]) -> bool:
    """Whether `in` looks for a part of a sentence, and not for a finding among findings."""
    many = isinstance(node, ast.Attribute) and node.attr in ("notes", "warnings", "findings", "problems")
    return _is_sentence(node, known) and not many


def _is_written(node: ast.AST) -> bool:
    """Whether it is the text of a value, whatever the value is: ``str(one)``."""
    return isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "str"


def _says(left: ast.AST, right: ast.AST, known: tuple[set[str], set[str]]) -> bool:
    """Whether a sentence is compared with words that are not empty."""
    return any(
        _is_sentence(one, known) and isinstance(other, ast.Constant) and isinstance(other.value, str) and other.value
        for one, other in ((left, right), (right, left))
    )


def found_in_source() -> dict[str, list[int]]:
    found: dict[str, list[int]] = {}
    for file in sorted(SOURCE.rglob("*.py")):
        for function, line in readings(ast.parse(file.read_text(encoding="utf-8"))):
            found.setdefault(f"{file.relative_to(SOURCE).as_posix()}:{function}", []).append(line)
    return found


def test_no_code_looks_into_a_sentence():
    found = found_in_source()
    assert {place: lines for place, lines in found.items() if place not in ALLOWED} == {}
    assert set(ALLOWED) <= set(found), "an exception that is no longer needed"


@pytest.mark.parametrize(
    "line",
    [
        "return '?' in note",
        "return note.startswith('baseline: ')",
        "return 'no data' in str(error)",
        "return re.search('lost', problem.message)",
        "return [one for one in fit.warnings if 'bound' in str(one)] if 'x' in found.text else []",
        "return error['msg'].removeprefix('Value error, ')",
        "return failure.reason == 'it is full'",
        "return [one for one in notes if 'drifts' in str(one)]",
        "what = getattr(error, 'problem', None) or 'it'\n    return 'tab' in str(what)",
        "lines = trial.stderr.decode().splitlines()\n    return lines[-1].startswith('Memory')",
    ],
)
def test_a_look_into_a_sentence_is_found(line):
    assert list(
        readings(ast.parse(f"def judge(note, error, problem, fit, found, failure, notes, signs, one):\n    {line}"))
    )


@pytest.mark.parametrize(
    "line",
    [
        "return found.code == 'fit.held'",
        "return one in recording.notes",
        "return [one for one in notes if one.severity is Severity.LOOK]",
        "return 'a' in names",
        "return not error.reason",
        "return message == ''",
    ],
)
def test_codes_and_findings_may_be_asked_for(line):
    assert not list(readings(ast.parse(f"def judge(found, recording, one, notes, names, error, message):\n    {line}")))
