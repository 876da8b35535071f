"""Try what a release must pass, one line a check, and leave what is shipped in a folder; nothing is uploaded.

    uv run --group release python tools/release.py dist

Everything is built twice, in two folders, from the last commit. Status 1 where a check fails; each failure says what to
mend. At the end stands what this machine cannot try.
"""

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import time
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import yaml

import parts

ROOT = Path(__file__).parents[1]
EXTRAS = "cluster,imaging,pdf,workbench"
FREE = re.compile(r"0?BSD|MIT|Apache|ISC|PSF|Python Software Foundation|MPL|Mozilla|Zlib|CC0", re.IGNORECASE)
BINDING = re.compile(r"GPL(?![-\w.+ ]*WITH GCC-exception)|General Public", re.IGNORECASE)
"""Licenses that would bind what is made with vasowave; GCC's exception frees what its libraries are linked into."""
PROGRAMS = ("git", "uv", "twine", "check-wheel-contents", "pyright")
LEAST_TYPED = 0.99  # of the public names
LISTED = """
import importlib.metadata as packages, json
print(json.dumps([[one.name, [one.metadata.get("License-Expression"),
    *(word.rpartition(" :: ")[2] for word in one.metadata.get_all("Classifier", []) if word.startswith("License")),
    " ".join((one.metadata.get("License") or "").split())[:200]]] for one in packages.distributions()]))
"""
NOT_HERE = """\
Not tried by this script: upload to an index; rattler-build of recipe/recipe.yaml; wheels with kernels of other Pythons
than this one; Windows and macOS. The container is tried by tests/test_packaging.py where podman or docker runs."""


def output(*command: str | Path, **settings: Any) -> str:
    """Return what a command prints; it may fail."""
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False, **settings)
    return done.stdout if done.returncode else ""


def committed(_dist: Path, _python: Path) -> Iterator[str]:
    """The work tree is the commit that is built."""
    if changed := subprocess.check_output(["git", "status", "--porcelain"], cwd=ROOT, text=True):
        yield "the work tree differs from the last commit, which is what is built; commit or remove:\n" + changed


def versions(_dist: Path, _python: Path) -> Iterator[str]:
    """Project, citation, recipe and changelog name one version."""
    yield from named_versions(ROOT)


def named_versions(root: Path) -> Iterator[str]:
    """What differs between the files of a source that name its version."""
    project = tomllib.loads((root / "pyproject.toml").read_text("utf-8"))["project"]
    heading = re.search(r"^## \[(.+?)\](.*)", (root / "CHANGELOG.md").read_text("utf-8"), re.MULTILINE)
    named = {
        "CITATION.cff": yaml.safe_load((root / "CITATION.cff").read_text("utf-8"))["version"],
        "recipe/recipe.yaml": yaml.safe_load((root / "recipe" / "recipe.yaml").read_text("utf-8"))["context"][
            "version"
        ],
        "CHANGELOG.md": heading[1] if heading else "no version",
    }
    for file, version in named.items():
        if version != project["version"]:
            yield f"{file} says {version}, pyproject.toml {project['version']}; write the same into both"
    if heading and not re.search(r"\d{4}-\d\d-\d\d", heading[2]):
        yield "CHANGELOG.md: write the day of the release behind the version, as 2026-01-31"
    if "urls" not in project:
        yield "pyproject.toml: write [project.urls] with Source, Documentation and Changelog, where they are"


def same_bytes(dist: Path, _python: Path) -> Iterator[str]:
    """Two builds in two folders are the same, bit for bit."""
    archive = subprocess.run(["git", "archive", "HEAD"], cwd=ROOT, check=True, stdout=subprocess.PIPE)
    sums = []
    with tempfile.TemporaryDirectory() as place:
        (Path(place) / "sources.tar").write_bytes(archive.stdout)
        for folder in (Path(place) / "one", Path(place) / "another" / "place, deeper down"):
            with tarfile.open(Path(place) / "sources.tar") as sources:
                sources.extractall(folder / "tree", filter="data")
            parts.build(folder / "dist", folder / "tree")
            sums.append((folder / "dist" / "SHA256SUMS").read_text("utf-8").splitlines())
        shutil.copytree(folder / "dist", dist, dirs_exist_ok=True)
    for line in sorted({*sums[0]} ^ {*sums[1]}):
        yield f"{line.split()[1]} differs between two folders; compare what is inside (`unzip -v`)"


def contents(dist: Path, _python: Path) -> Iterator[str]:
    """The index's checks of metadata, and of what a wheel holds."""
    wheels, sources = sorted(dist.glob("*.whl")), sorted(dist.glob("*.tar.gz"))
    yield from filter(None, [output("twine", "check", "--strict", *wheels, *sources)])
    yield from filter(None, [output("check-wheel-contents", *wheels)])


def installed(dist: Path, python: Path) -> Iterator[str]:
    """The wheel and all its extras go together in a new environment."""
    (wheel,) = dist.glob("*-none-any.whl")
    subprocess.run(["uv", "venv", "--quiet", "--seed", python.parents[1]], check=True)
    install = ["uv", "pip", "install", "--quiet", "--python", python, f"{wheel}[{EXTRAS}]"]
    yield from filter(None, [output(*install), output(python, "-m", "pip", "check")])
    yield from filter(None, [output(python.parent / "vasowave", "--version", cwd=python.parent)])


def licenses(dist: Path, python: Path) -> Iterator[str]:
    """Nothing that is shipped or needed is bound by the GPL; the list is left beside the wheels."""
    rows = []
    for name, words in json.loads(subprocess.check_output([python, "-c", LISTED], text=True)):
        license_ = words[0] or "; ".join(filter(None, words[1:]))
        rows.append(f"{name}: {next(filter(None, words), 'not stated')[:80]}")
        if BINDING.search(license_) or not FREE.search(license_):
            yield f"{name} states the license {license_[:200]!r}; replace it, or write it into FREE if it binds nobody"
    (dist / "LICENSES.txt").write_text("\n".join(sorted(rows, key=str.lower)) + "\n", "utf-8")
    foreign = subprocess.run(["git", "grep", "-liE", r"copyright \(c\)|general public license"], cwd=ROOT,
                             stdout=subprocess.PIPE, text=True, check=False).stdout.split()  # fmt: skip
    for file in sorted({*foreign} - {"LICENSE", "tools/release.py", "tests/test_release.py"}):
        yield f"{file} names a license or an owner; if it is of others, leave it out"


def types(_dist: Path, python: Path) -> Iterator[str]:
    """Types of the public names are complete, as the wheel has them."""
    inside = {"VIRTUAL_ENV": str(python.parents[1]), "PATH": f"{python.parent}{os.pathsep}{os.environ['PATH']}"}
    command = ["pyright", "--verifytypes", "vasowave", "--ignoreexternal", "--outputjson"]
    told = subprocess.run(command, cwd=python.parent, env=os.environ | inside, capture_output=True, check=False).stdout
    found = json.loads(told)["typeCompleteness"]
    names = [one for one in found["symbols"] if one["isExported"] and one["name"].count(".") == 1]
    vague = [one["name"] for one in names if not one["isTypeKnown"] or one["isTypeAmbiguous"]]
    share = 1 - len(vague) / max(len(names), 1)
    print(f"   {share:.1%} of {len(names)} public names, {found['completenessScore']:.1%} of all of the package")
    if not names or share < LEAST_TYPED:
        yield f"types are incomplete: {', '.join(vague) or 'no name was found'}"


CHECKS: tuple[Callable[[Path, Path], Iterator[str]], ...] = (
    committed, versions, same_bytes, contents, installed, licenses, types
)  # fmt: skip


def main(dist: Path) -> int:
    """Run all checks, print what they find and return how many fail."""
    failed = 0
    with tempfile.TemporaryDirectory() as place:
        for check in CHECKS:
            began = time.monotonic()
            wrong = [*check(dist, Path(place) / "environment" / "bin" / "python")]
            failed += bool(wrong)
            print(f"== {check.__name__}: {'FAILED' if wrong else 'ok'}, {time.monotonic() - began:.0f} s", flush=True)
            print(*(f"   {one}" for one in wrong), sep="\n", end="\n" if wrong else "")
    print(NOT_HERE)
    return failed


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", default="dist", type=Path)
    folder = parser.parse_args().folder.resolve()
    if absent := [program for program in PROGRAMS if shutil.which(program) is None]:
        parser.error(f"not here: {', '.join(absent)}; use `uv run --group release`")
    sys.exit(bool(main(folder)))
