"""Measure how the house is built: arrows between modules, what tests know of the inside, names, signatures, lines.

uv run python tools/house.py            print all numbers
uv run python tools/house.py --check    fail, too, where one of `LIMITS` has risen
"""

import ast
import re
import sys
import tomllib
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import grimp
import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

ROOT = Path(__file__).parents[1]
SOURCE, TESTS = ROOT / "src/vasowave", ROOT / "tests"
LIMITS = {
    "modules in circles": 0,
    "upward arrows": 0,
    "imports by a string": 8,
    "private names in tests": 16,
    "patched attributes in tests": 39,
    "module paths in tests": 59,
    "vague names": 32,
    "vague names of functions": 84,
    "names of two classes": 0,
}
"""What must not rise; whoever lowers a number lowers its limit."""
VAGUE = frozenset(
    re.findall(
        r"\w+",
        """
        apart asked at beside both each every far few found given here how kept known least left look more most near of
        one other others own part parts rest said say seen so some such tell there these thing told wanted way ways what
        which who whole why
        """,
    )
)
"""Words that name nothing of the field."""
_ARGUMENTS = 7  # above which a signature is long
_HELD_BY_NAME = frozenset({"_replace", "_asdict", "_fields"})  # public methods of named tuples


def trees(folder: Path) -> Iterator[tuple[Path, ast.Module]]:
    """Give every Python file of a folder and what it holds."""
    for path in sorted(folder.rglob("*.py")):
        yield path, ast.parse(path.read_text("utf-8"))


def ranks() -> dict[str, tuple[int, int]]:
    """Return the height of every part, and of every room in its part, by the contracts of layers."""
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["importlinter"]["contracts"]

    def heights(contract: dict[str, Any]) -> dict[str, int]:
        rows = contract["layers"]
        return {name.strip(" ()"): len(rows) - row for row, line in enumerate(rows) for name in line.split("|")}

    parts = heights(contracts[0])
    rooms = {
        f"{container.removeprefix('vasowave.')}.{room}": height
        for contract in contracts[1:]
        if contract["type"] == "layers" and len(contract["containers"]) == 1
        for container in contract["containers"]
        for room, height in heights(contract).items()
    }
    return {part: (height, 0) for part, height in parts.items()} | {
        room: (parts[room.split(".")[0]], height) for room, height in rooms.items()
    }


def height_of(module: str, heights: dict[str, tuple[int, int]]) -> tuple[int, int]:
    """Return the height of a module: of its room, else of its part; (0, 0) of the root."""
    inner = module.split(".")[1:3]
    return heights.get(".".join(inner)) or heights.get(inner[0] if inner else "", (0, 0))


def upward(importer: tuple[int, int], imported: tuple[int, int]) -> bool:
    """Whether an import goes to a higher part, or to a higher room of the same part."""
    if not importer[0] or importer[0] != imported[0]:
        return 0 < importer[0] < imported[0]
    return 0 < importer[1] < imported[1]


def arrows() -> Counter[str]:
    """Count modules that import each other in a circle, and imports of a higher room, types and functions included."""
    graph = grimp.build_graph("vasowave", exclude_type_checking_imports=False, cache_dir=None)
    modules = sorted(graph.modules)
    number, heights = {name: row for row, name in enumerate(modules)}, ranks()
    pairs = [(one, two) for one in modules for two in graph.find_modules_directly_imported_by(one)]
    rows, columns = np.array([[number[name] for name in pair] for pair in pairs]).T
    _, labels = connected_components(
        csr_array((np.ones(len(rows)), (rows, columns)), shape=(len(modules), len(modules))), connection="strong"
    )
    sizes = np.bincount(labels)
    return Counter(
        {
            "arrows": len(pairs),
            "modules in circles": int(sizes[sizes > 1].sum()),
            "upward arrows": sum(upward(*(height_of(name, heights) for name in pair)) for pair in pairs),
            "imports by a string": sum(
                path.read_text("utf-8").count("import_module(") for path in SOURCE.rglob("*.py")
            ),
        }
    )


def inside_knowledge() -> Counter[str]:
    """Count what the tests know of the inside: private names, attributes that they patch, and paths of modules."""
    private, modules, patched = set(), set(), 0
    for _, tree in trees(TESTS):
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("vasowave"):
                modules.add(node.module)
                private |= {f"{node.module}.{name.name}" for name in node.names if name.name.startswith("_")}
            elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
                patched += (node.value.id, node.attr) == ("monkeypatch", "setattr")
                hidden = node.attr.startswith("_") and not node.attr.startswith("__")
                if hidden and node.value.id not in ("self", "cls") and node.attr not in _HELD_BY_NAME:
                    private.add(f"{node.value.id}.{node.attr}")
    return Counter(
        {
            "private names in tests": len(private),
            "patched attributes in tests": patched,
            "module paths in tests": len(modules),
        }
    )


def names() -> Counter[str]:
    """Count the names that are bound, those that are vague, of functions too, long signatures, names of two classes."""
    count: Counter[str] = Counter()
    classes: Counter[str] = Counter()
    for _, tree in trees(SOURCE):
        for node in ast.walk(tree):
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
                count.update(["names bound", *(["vague names"] if node.id in VAGUE else [])])
            elif isinstance(node, ast.arg):
                count.update(["names bound", *(["vague names"] if node.arg in VAGUE else [])])
            elif isinstance(node, ast.FunctionDef):
                given = node.args
                long = len(given.posonlyargs + given.args + given.kwonlyargs) > _ARGUMENTS
                count["signatures of more than seven arguments"] += long
                count["vague names of functions"] += node.name.strip("_") in VAGUE
            elif isinstance(node, ast.ClassDef):
                classes[node.name] += 1
    count["names of two classes"] = sum(number > 1 for number in classes.values())
    return count


def lines() -> Counter[str]:
    """Count the lines of every room of the source, of the tests and of the docs."""
    count: Counter[str] = Counter()
    for suffix in ("py", "pyi", "js", "css", "html"):
        for path in SOURCE.rglob(f"*.{suffix}"):
            count[f"src/{path.relative_to(SOURCE).parts[0]}"] += len(path.read_text("utf-8").splitlines())
    for folder, suffix in ((TESTS, "*.py"), (ROOT / "docs", "*.md")):
        count[folder.name] = sum(len(path.read_text("utf-8").splitlines()) for path in folder.rglob(suffix))
    return count


def risen(measured: Counter[str]) -> list[str]:
    """Return a sentence for every number above its limit."""
    return [
        f"{name}: {measured[name]}, more than {limit}; what is new can do without"
        for name, limit in LIMITS.items()
        if measured[name] > limit
    ]


if __name__ == "__main__":
    house = arrows() + inside_knowledge() + names()
    for title, value in house.items():
        print(f"{value:7d}  {title}" + (f" (at most {LIMITS[title]})" if title in LIMITS else ""))
    print(f"{100 * house['vague names'] / house['names bound']:7.1f}  vague names, %\n")
    for title, value in sorted(lines().items(), key=lambda item: -item[1]):
        print(f"{value:7d}  {title}")
    if "--check" in sys.argv[1:] and (failures := risen(house)):
        sys.exit("\n".join(failures))
