"""Run the rows of docs/evidence.md that take seconds, and compare what comes out with the page.

    uv run python benchmarks/evidence.py            every row
    uv run python benchmarks/evidence.py image      those with one of these words

A row whose command is of pytest holds where its tests pass; one of a benchmark, where it prints the row's result. The
result of every row, run or not, is looked up on the page that it names: the numbers between two commas in one line.
Status 1 where anything differs.
"""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "evidence.md"
NUMBER = re.compile(r"(?<![\w.])\d+(?:\.\d+)?(?:e-\d+)?")
STRAIGHT = {"pytest": ["-m", "pytest", "-q", "-n", "0"], "python": []}


class Row(NamedTuple):
    """A row of the page: what is claimed, what came out and on which page that stands, and how it is shown."""

    claim: str
    result: str
    record: str
    command: str
    seconds: float | None


def rows(page: Path = PAGE) -> list[Row]:
    """Return the rows of all tables of the page; `seconds` is None of those that take minutes or more."""
    found = []
    for line in page.read_text("utf-8").splitlines():
        cells = [cell.strip() for cell in line.strip("|").split(" | ")]
        if (
            line.startswith("|")
            and len(cells) == 6
            and (link := re.search(r"\s*\(\[[\w ]+\]\(([\w-]+\.md)\)\)", cells[2]))
        ):
            taken = re.fullmatch(r"(\d+) s", cells[5])
            command = found[-1].command if cells[3] == "the same" else cells[3].strip("`")
            found.append(Row(cells[0], cells[2][: link.start()], link[1], command, float(taken[1]) if taken else None))
    return found


def missing(result: str, text: str) -> list[str]:
    """Return the pieces of a result, between commas and semicolons, whose numbers no line of a text holds together."""
    lines = [{*NUMBER.findall(line)} for line in text.splitlines()]
    pieces = [piece.strip() for piece in re.split("[,;]", result)]
    return [piece for piece in pieces if not any({*NUMBER.findall(piece)} <= line for line in lines)]


def difference(row: Row, made: dict[str, tuple[int, str]]) -> str:
    """Return what a row's command prints that differs from the page, empty where nothing does."""
    if row.command not in made:
        program, *words = shlex.split(row.command)
        done = subprocess.run([sys.executable, *STRAIGHT[program], *words], cwd=ROOT, capture_output=True, text=True,
                              check=False)  # fmt: skip
        made[row.command] = done.returncode, done.stdout + done.stderr
    status, text = made[row.command]
    if status or (row.command.startswith("pytest") and " passed" not in text):
        return f"status {status}: {text.strip().splitlines()[-1]}"
    lost = [] if row.command.startswith("pytest") else missing(row.result, text)
    return f"the page says {', '.join(lost)}; it prints\n{text.strip()}" if lost else ""


def main(words: list[str]) -> int:
    """Print a line a row and return the number of those that differ."""
    differing, made = 0, dict[str, tuple[int, str]]()
    for row in rows():
        if words and not any(word in f"{row}" for word in words):
            continue
        unrecorded = missing(row.result, (ROOT / "docs" / row.record).read_text("utf-8"))
        wrong = f"{row.record} does not say {', '.join(unrecorded)}" if unrecorded else ""
        before = os.times()
        if row.seconds is not None:
            wrong = difference(row, made) or wrong
        taken = sum(os.times()[2:4]) - sum(before[2:4])
        how = f"run, {taken:.0f} s" if row.seconds is not None else f"as {row.record} says; not run"
        print(f"{'DIFFERS' if wrong else 'same'}: {row.claim} ({how})" + (f"\n   {wrong}" if wrong else ""), flush=True)
        differing += bool(wrong)
    print(f"{differing} differences to the page")
    return differing


if __name__ == "__main__":
    sys.exit(bool(main(sys.argv[1:])))
