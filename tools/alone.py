"""Try each part alone: copy it with what it stands on, run the example of its README and its tests there.

uv run python tools/alone.py              every part, one after the other
uv run python tools/alone.py pulse        one of them
uv run python tools/alone.py pulse -m "not validation"      its tests with options of pytest
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
BELOW = {
    "base": (),
    "pulse": ("base",),
    "catheter": ("base", "pulse"),
    "lung": ("base", "pulse"),
    "study": ("base", "pulse", "catheter", "lung", "cli", "__main__.py"),
}
"""What stands below a part; the study brings its commands. The workbench stands on all, so that all tests try it."""
SELECTION = ["-m", "fast", "-n", "2"]  # the others run with all tests


def copied(part: str, folder: Path) -> Path:
    """Copy a part, what it stands on, and its tests with their helpers into a folder."""
    source = ROOT / "src" / "vasowave"
    for name in (part, *BELOW[part], "__init__.py", "__init__.pyi", "py.typed"):
        copy = shutil.copytree if (source / name).is_dir() else shutil.copy
        (folder / "src" / "vasowave").mkdir(parents=True, exist_ok=True)
        copy(source / name, folder / "src" / "vasowave" / name)
    for name in ("benchmarks", "tools", "docs", f"tests/{part}", "tests/approved"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("build", "made*", "__pycache__"))
    for file in (ROOT / "pyproject.toml", *(ROOT / "tests").glob("*.*")):
        if not file.name.startswith("test_"):
            shutil.copy(file, folder / file.relative_to(ROOT))
    return folder


def example(part: str) -> str:
    """Return the program in the README of a part."""
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "src/vasowave" / part / "README.md").read_text("utf-8"), re.S)
    return "\n".join(blocks)


def tried(part: str, options: list[str]) -> int:
    """Run the example and the tests of a part where nothing above it exists; return the exit status."""
    with tempfile.TemporaryDirectory() as place:
        folder = copied(part, Path(place) / "project")
        (Path(place) / "shared").symlink_to(ROOT.parent / "shared")
        environment = os.environ | {"PYTHONPATH": str(folder / "src")}
        work = folder / "work"
        work.mkdir()
        shown = subprocess.run([sys.executable, "-c", example(part)], cwd=work, env=environment, check=False)
        if shown.returncode:
            return shown.returncode
        command = [sys.executable, "-m", "pytest", "-q", "--no-header", "-p", "no:cacheprovider", f"tests/{part}"]
        return subprocess.run([*command, *(options or SELECTION)], cwd=folder, env=environment, check=False).returncode


def main(arguments: list[str]) -> int:
    """Try the parts that are named, or all; return 1 where something fails."""
    names = [name for name in arguments if name in BELOW]
    options = [argument for argument in arguments if argument not in names]
    failed = [name for name in names or BELOW if print(f"== {name}", flush=True) or tried(name, options)]
    return print(f"alone, these fail: {', '.join(failed)}") or 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
