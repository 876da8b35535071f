"""Everything that is written goes through one module; nothing else opens a file for writing, or moves one."""

import ast
from pathlib import Path

import pytest

import vasowave

PACKAGE = Path(vasowave.__file__).parent
WRITER = {"base/runtime/writing.py", "base/io/files.py"}
"""The module that calls the system, and the one that says in words what went wrong and writes whole folders."""

FORBIDDEN = {
    "os": {"open", "replace", "rename", "renames", "link", "symlink", "mkfifo", "truncate"},
    "shutil": {"copy", "copy2", "copyfile", "copytree", "move"},
    "tempfile": {"mkstemp", "NamedTemporaryFile", "TemporaryFile", "mkdtemp"},
    "gzip": {"GzipFile"},
}
METHODS = {"write_text", "write_bytes", "symlink_to", "hardlink_to", "touch"}
SAVERS = {"savefig", "to_csv", "to_json", "savez", "savetxt", "save", "tofile"}
"""Methods of libraries that write to a path; to memory they may."""


def writes(source):
    """Return lines of a program that open a file for writing, make one or move one."""
    return [node.lineno for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Call) and _writes(node)]


def _writes(call):
    function, arguments = call.func, call.args
    name = function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")
    owner = function.value if isinstance(function, ast.Attribute) else None
    if isinstance(owner, ast.Name) and name in FORBIDDEN.get(owner.id, ()):
        return True
    if name == "open":
        modes = [*arguments[:2], *(one.value for one in call.keywords if one.arg == "mode")]
        texts = [one.value for one in modes if isinstance(one, ast.Constant) and isinstance(one.value, str)]
        return any(set(text) <= set("rwaxbt+") and set(text) & set("wax+") for text in texts)
    return name in METHODS or (name in SAVERS and any(map(_is_path, arguments[:1])))


def _is_path(node):
    joined = isinstance(node, ast.BinOp) and isinstance(node.op, ast.Div)
    made = isinstance(node, ast.Call) and getattr(node.func, "id", "") in ("Path", "str")
    return joined or made or (isinstance(node, ast.Name) and node.id in ("path", "file", "output", "place", "target"))


@pytest.mark.parametrize(
    "line",
    [
        'open(path, "w")', 'path.open("a", encoding="utf-8")', 'path.open(mode="xb")', 'open(path, "rb+")',
        'path.write_text("x")', "(folder / name).write_bytes(b)", "os.replace(a, b)", "os.rename(a, b)",
        "os.open(a, 1)", "os.link(a, b)", "shutil.move(a, b)", "tempfile.mkstemp()", "figure.savefig(folder / name)",
        "table.to_csv(path, index=False)", "np.savez(Path(name), a=a)", 'gzip.open(path, "wb")', "path.touch()",
    ],
)  # fmt: skip
def test_a_line_that_writes_beside_the_writer_is_found(line):
    assert writes(f"def f():\n    {line}\n") == [2]


@pytest.mark.parametrize(
    "line",
    ["open(path)", 'path.open("rb")', "figure.savefig(content)", "table.to_csv(index=False)", "webbrowser.open(a)"],
)
def test_a_line_that_reads_or_writes_to_memory_is_none(line):
    assert writes(line) == []


def test_no_module_but_the_writer_opens_a_file_for_writing_or_moves_one():
    texts = {str(path.relative_to(PACKAGE)): path.read_text(encoding="utf-8") for path in PACKAGE.rglob("*.py")}
    found = {name: lines for name, text in texts.items() if (lines := writes(text))}
    assert found.keys() == WRITER, f"write through vasowave.base.io.files: {found}"
