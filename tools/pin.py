"""Pin every package, of every group and extra, to an exact version in pyproject.toml.

    uv run --no-project python tools/pin.py             pin what is new, keep what is pinned
    uv run --no-project python tools/pin.py --upgrade   move everything to the newest versions, then pin

The pins stand in pyproject.toml because uv.lock, which also records where files were downloaded, is not kept.
"""

import re
import subprocess
import sys
import tomllib
from pathlib import Path

PYPROJECT = Path(__file__).parents[1] / "pyproject.toml"
COMPILERS = "llvmlite", "numba", "numpy"
"""What a wheel's kernels are compiled with (`wheel_kernels`): they are of use beside the same versions only."""
BARE = ["--no-annotate", "--no-header", "--quiet"]


def uv(*arguments: str, stdin: str | None = None) -> list[str]:
    """Run uv beside pyproject.toml and return the lines it prints."""
    done = subprocess.run(
        ["uv", *arguments], cwd=PYPROJECT.parent, input=stdin, stdout=subprocess.PIPE, text=True, check=True
    )
    return done.stdout.splitlines()


def project_pins() -> list[str]:
    """Resolve the project for every platform and Python it supports."""
    return uv("export", "--all-groups", "--all-extras", "--no-emit-project", "--no-hashes", *BARE)


def build_pins(requires: list[str], pinned: list[str]) -> list[str]:
    """Resolve what builds the project; `pinned` holds."""
    lines = uv("pip", "compile", "--universal", *BARE, "-", stdin="\n".join([*requires, *pinned]))
    return [line for line in lines if line]


def with_pins(text: str, key: str, pins: list[str]) -> str:
    """Return the text of pyproject.toml with the list `key` replaced."""
    listed = "".join(f'    "{pin}",\n' for pin in pins)
    text, count = re.subn(rf"^{key} = \[\n.*?^\]", f"{key} = [\n{listed}]", text, flags=re.MULTILINE | re.DOTALL)
    if count != 1:
        raise SystemExit(f"pyproject.toml has {count} lists named {key}; expected one")
    return text


def main() -> None:
    """Rewrite both lists of pins; leave the file as it was when uv fails."""
    before = text = PYPROJECT.read_text(encoding="utf-8")
    upgrade = sys.argv[1:] == ["--upgrade"]
    if sys.argv[1:] and not upgrade:
        raise SystemExit(__doc__)
    try:
        if upgrade:
            text = with_pins(with_pins(text, "build-constraint-dependencies", []), "constraint-dependencies", [])
            PYPROJECT.write_text(text, encoding="utf-8")
            uv("lock", "--upgrade", "--quiet")
        settings = tomllib.loads(text)
        pinned = settings["tool"]["uv"]["build-constraint-dependencies"]
        project = project_pins()
        compilers = [pin for pin in project if pin.startswith(tuple(f"{name}==" for name in COMPILERS))]
        others = [pin for pin in pinned if not pin.startswith(tuple(f"{name}==" for name in COMPILERS))]
        build = sorted({*build_pins(settings["build-system"]["requires"], others), *compilers})
        text = with_pins(text, "constraint-dependencies", project)
        PYPROJECT.write_text(with_pins(text, "build-constraint-dependencies", build), encoding="utf-8")
        uv("lock", "--quiet")
    except BaseException:
        PYPROJECT.write_text(before, encoding="utf-8")
        raise


if __name__ == "__main__":
    main()
