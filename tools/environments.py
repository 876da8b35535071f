"""Run both commands of the README in surroundings that are not those of its authors, and print a row of each.

    uv run python tools/environments.py                      pip install of wheel and sources, each Python in turn
    uv run python tools/environments.py --only clone         uv run vasowave demo and uv run pytest in new clones
    uv run python tools/environments.py --python python3.13  another interpreter than those on the path

Every row has an empty home and no terminal. Processor seconds hold all processes and, at first, what is compiled.
Status 1 where a row fails. Three to ten minutes a row.
"""

import argparse
import os
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import parts
import surroundings

ROOT = Path(__file__).parents[1]
VERSIONS = ("3.11", "3.12", "3.13", "3.14")
SETTLED = ("SSL_", "PIP_", "UV_", "REQUESTS_", "CURL_", "OPENBLAS_", "LANG", "LC_")  # how this machine reaches packages


@dataclass(frozen=True)
class Surroundings:
    """Where a command runs: variables, folder and what its process sets before it begins."""

    folder: Path
    variables: dict[str, str]
    before: Callable[[], object] = field(default=lambda: None)

    def run(self, *command: str | Path) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            command, cwd=self.folder, env=self.variables, preexec_fn=self.before, stdin=subprocess.DEVNULL, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False,
        )  # fmt: skip


def empty(place: Path, path: str | None = None) -> Surroundings:
    """Return surroundings with an empty home and nothing set but how packages are reached."""
    home = place / "home"
    home.mkdir(parents=True, exist_ok=True)
    settled = {name: value for name, value in os.environ.items() if name.startswith(SETTLED)}
    return Surroundings(place, {**settled, "HOME": str(home), "PATH": path or _path()})


def _path() -> str:
    """Return the path without the environment that runs this script."""
    entries = os.environ["PATH"].split(os.pathsep)
    return os.pathsep.join(entry for entry in entries if not entry.startswith(sys.prefix))


def interpreters(asked: list[str]) -> dict[str, str]:
    """Return version and file of each interpreter that answers."""
    answers = {}
    for name in asked or [f"python{version}" for version in VERSIONS]:
        command = [shutil.which(name) or "false", "-c", "import platform; print(platform.python_version())"]
        version = subprocess.run(command, check=False, stdout=subprocess.PIPE, text=True).stdout.strip()
        if version:
            answers[version] = command[0]
        else:
            print(f"{name} is not to be had here", flush=True)
    return answers


def installed(shipped: Path, python: str, place: Path) -> Path:
    """Install a file that is shipped with pip alone and return the folder of its commands."""
    there = empty(place)
    subprocess.run([python, "-m", "venv", place / "venv"], check=True, env=there.variables)
    commands = place / "venv" / "bin"
    done = there.run(commands / "python", "-m", "pip", "install", "--quiet", "--disable-pip-version-check", shipped)
    if done.returncode:
        raise SystemExit(f"pip install {shipped.name}: {done.stdout}")
    return commands


def by_pip(shipped: dict[str, Path], pythons: dict[str, str]) -> Iterator[tuple[str, Surroundings, list[str | Path]]]:
    """What `pip install` leaves, with each interpreter and, of the first, on poorer machines."""
    for version, python in pythons.items():
        for kind, file in shipped.items():
            tag = "cp" + "".join(version.split(".")[:2])
            if kind == "wheel with kernels" and tag not in file.name:
                continue
            with tempfile.TemporaryDirectory() as folder:
                place = Path(folder)
                commands = installed(file, python, place)
                demo: list[str | Path] = [commands / "vasowave", "demo", "-o", "out"]
                yield f"Python {version}, {kind}", empty(place), demo
                if kind == "wheel" and version == next(iter(pythons)):
                    yield from poorer(place, commands)


def poorer(place: Path, commands: Path) -> Iterator[tuple[str, Surroundings, list[str | Path]]]:
    """The same installation without a compiler, on one core, in the background, and for a user who owns nothing."""
    demo: list[str | Path] = [commands / "vasowave", "demo", "-o", "out"]
    for name, path, before in (
        ("no compiler and no other program on the path", str(commands), lambda: None),
        ("one core", None, lambda: os.sched_setaffinity(0, {0})),
        ("background, SIGINT ignored", None, lambda: signal.signal(signal.SIGINT, signal.SIG_IGN)),
    ):
        here = place / name.split(",")[0].replace(" ", "-")
        surround = empty(here, path)
        yield name, Surroundings(here, surround.variables, before), demo
    here = place / "elsewhere"
    here.mkdir()
    python, variables = surroundings.elsewhere(here)
    there = Surroundings(here / "files", empty(here / "nothing").variables | variables)
    yield "another user, home read-only", there, [*python, "-m", "vasowave", "demo", "-o", "out"]


def by_clone(pythons: dict[str, str]) -> Iterator[tuple[str, Surroundings, list[str | Path]]]:
    """Both commands of the README in a new clone."""
    for version, python in pythons.items():
        with tempfile.TemporaryDirectory() as folder:
            place = Path(folder)
            subprocess.run(["git", "clone", "--quiet", ROOT, place / "clone"], check=True)
            there = empty(place)
            there = Surroundings(place / "clone", {**there.variables, "UV_PYTHON": python})
            yield f"Python {version}, clone, demo", there, ["uv", "run", "vasowave", "demo", "-o", place / "out"]
            yield f"Python {version}, clone, tests", there, ["uv", "run", "pytest", "-q"]


def main(only: str, asked: list[str]) -> int:
    """Run every row, print it as it ends and return how many failed."""
    failed, pythons = 0, interpreters(asked)
    with tempfile.TemporaryDirectory() as folder:
        files = [] if only == "clone" else parts.build(Path(folder))
        kinds = {"none-any.whl": "wheel", "x86_64.whl": "wheel with kernels", ".tar.gz": "sources"}
        shipped = {kind: path for path in files for end, kind in kinds.items() if path.name.endswith(end)}
        print("| where | status | wall s | CPU s |\n|---|---|---|---|", flush=True)
        for name, there, command in by_clone(pythons) if only == "clone" else by_pip(shipped, pythons):
            began, before = time.monotonic(), _processor_seconds()
            done = there.run(*command)
            wall, spent = time.monotonic() - began, _processor_seconds() - before
            failed += bool(done.returncode)
            print(f"| {name} | {done.returncode} | {wall:.0f} | {spent:.0f} |", flush=True)
            print(done.stdout[-3000:] if done.returncode else "", end="", flush=True)
    return failed


def _processor_seconds() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", choices=("pip", "clone"), default="pip")
    parser.add_argument("--python", action="append", default=[])
    arguments = parser.parse_args()
    sys.exit(bool(main(arguments.only, arguments.python)))
