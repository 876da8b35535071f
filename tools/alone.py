"""Try each part alone: copy it with what it stands on, run the example of its README and tests of it there.

uv run python tools/alone.py              every part, one after the other: the first quick test of each file
uv run python tools/alone.py pulse        one of them
uv run python tools/alone.py pulse -m "not validation"      its tests with options of pytest

Whether any other test of a part needs what stands above, every run of the tests sees: `tests/conftest.py` takes that
away while they run. What is seen only here: files that are missing, and what is imported as the tests are collected.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
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
SELECTION, FIRST_OF_EACH_FILE = ["-m", "fast", "-n", "0"], {"VASOWAVE_SHARE": "first"}


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


def tried(part: str, options: list[str]) -> tuple[int, str]:
    """Run the example and tests of a part where nothing above it exists; return the exit status and what they print."""
    with tempfile.TemporaryDirectory() as place:
        folder = copied(part, Path(place) / "project")
        (Path(place) / "shared").symlink_to(ROOT.parent / "shared")
        environment = os.environ | {"PYTHONPATH": str(folder / "src")} | ({} if options else FIRST_OF_EACH_FILE)
        work = folder / "work"
        work.mkdir()
        pytest = ["-m", "pytest", "-q", "--no-header", "-p", "no:cacheprovider"]
        tests = [*pytest, f"tests/{part}", *(options or SELECTION)]
        shown = f"== {part}\n"
        for command, where in ((["-c", example(part)], work), (tests, folder)):
            run = subprocess.run([sys.executable, *command], cwd=where, env=environment, check=False, text=True,
                                 stdout=subprocess.PIPE, stderr=subprocess.STDOUT)  # fmt: skip
            shown += run.stdout
            if run.returncode:
                break
        return run.returncode, shown


def main(arguments: list[str]) -> int:
    """Try the parts that are named, or all, two at a time; return 1 where something fails."""
    names = [name for name in arguments if name in BELOW] or [*BELOW]
    options, failed = [argument for argument in arguments if argument not in BELOW], []
    with ThreadPoolExecutor(2) as both:
        for name, (status, shown) in zip(names, both.map(lambda name: tried(name, options), names)):
            print(shown, flush=True)
            failed += [name] if status else []
    return print(f"alone, these fail: {', '.join(failed)}") or 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
