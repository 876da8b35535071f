"""Damage files of every format in ways their structure suggests, and count what the readers make of them.

uv run python tools/fuzz.py                               200 mutants of every format
uv run python tools/fuzz.py 2000 --seed 7                 2000 of every format (hours: a MATLAB mutant takes a second)
uv run python tools/fuzz.py 50 --format edf --format vtp  two formats
uv run python tools/fuzz.py 2000 --docs                   the table goes into docs/robustness.md, too

Every mutant is read in a process that may take 2 GB of addresses; one that takes longer than 20 s is ended.

Outcomes: refused (an error of ours), told (read, and a warning or a note says something), same (read, nothing changed),
other values (numbers changed without a word), cut between lines (a text that ends earlier, whole to its last line:
nothing in it tells), other structure (counts, parents or rates changed without a word), foreign (an exception that is
not ours), hang, crash (the process that read it ended). Exit code 1: a foreign exception, a hang, a crash, a text
whose structure changed without a word, or any change without a word of a store that has a check sum.
"""

import argparse
import select
import subprocess
import sys
import tempfile
import warnings
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

sys.path += [str(Path(__file__).parents[1] / folder) for folder in ("tools", "benchmarks")]

from fuzzing import images, recordings, stores, studies, vessels
from fuzzing.forms import Form
from robustness_page import put
from vasowave.base import VasowaveError, VasowaveWarning

FORMS = recordings.FORMS | vessels.FORMS | images.FORMS | studies.FORMS | stores.FORMS
FORMS |= {"result of an animal, alone": stores.ALONE}
OUTCOMES = (
    "refused", "told", "same", "other values", "cut between lines", "other structure", "foreign", "hang", "crash"
)  # fmt: skip
LONGEST = 20  # s
MEMORY = 2_000_000_000  # bytes


def outcome(form: Form, folder: Path, sound: Any) -> str:
    """Return what became of the files in a folder, compared with what the sound ones gave."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            found = form.read(folder / form.opened)
        except VasowaveError:
            return "refused"
        except Exception as error:
            print(f"{form.damaged}: {type(error).__name__}: {error}", file=sys.stderr)
            return "foreign"
    if any(issubclass(one.category, VasowaveWarning) for one in caught) or form.notes(found) - form.notes(sound):
        return "told"
    if form.structure(found) != form.structure(sound):
        return "other structure"
    pairs = zip(form.values(found), form.values(sound), strict=True)
    return "same" if all(_equal(*pair) for pair in pairs) else "other values"


def _equal(one: Any, other: Any) -> bool:
    return bool(np.array_equal(one, other) if isinstance(one, np.ndarray) else one == other)


def mutants(name: str, numbers: range, seed: int, folder: Path, keep: Path | None = None) -> Any:
    """Make, read and yield the outcome of each numbered mutant of one format."""
    form = FORMS[name]
    form.write(folder)
    victim = next(folder.glob(form.damaged))
    content = victim.read_bytes()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VasowaveWarning)  # as that a flow was gated
        sound = form.read(folder / form.opened)
    for number in numbers:
        damaged = form.mutate(content, np.random.default_rng([seed, number, list(FORMS).index(name)]))
        victim.write_bytes(damaged)
        became = outcome(form, folder, sound)
        if became == "other structure" and form.text and damaged.endswith(b"\n") and content.startswith(damaged):
            became = "cut between lines"
        if keep and (became in ("foreign", "hang", "crash") or (became == "other structure" and form.text)):
            (keep / f"{name} {became} {number}{victim.suffix}").write_bytes(damaged)
        yield became


def fuzz(name: str, count: int, seed: int, keep: Path | None = None) -> Counter[str]:
    """Return how often each outcome occurred among `count` mutants of one format, read in processes of their own."""
    found: Counter[str] = Counter()
    done = 0
    while done < count:
        arguments = [name, str(done), str(count), str(seed), *([str(keep)] if keep else [])]
        command = [sys.executable, __file__, "--child", *arguments]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, bufsize=1) as child:
            assert child.stdout is not None
            patience = 10.0 * LONGEST  # until the sound file is read, everything has to be loaded
            while not (silent := not select.select([child.stdout], [], [], patience)[0]):
                if not (line := child.stdout.readline()):  # the end of what it says, and of itself
                    break
                found[line.strip()] += 1
                done += 1
                patience = LONGEST
            if done < count:
                found["hang" if silent else "crash"] += 1
                done += 1
            child.kill()
    return found


def read_as_child(name: str, begin: str, end: str, seed: str, keep: str | None = None) -> int:
    """Read mutants within a limit of memory; print each one's outcome."""
    import resource

    with tempfile.TemporaryDirectory() as folder:
        for number, became in enumerate(
            mutants(name, range(int(begin), int(end)), int(seed), Path(folder), Path(keep) if keep else None)
        ):
            print(became, flush=True)
            if number == 0:  # what is loaded by now is not the mutants'
                resource.setrlimit(resource.RLIMIT_AS, (_addresses() + MEMORY, resource.RLIM_INFINITY))
    return 0


def _addresses() -> int:
    return int(Path("/proc/self/statm").read_text().split()[0]) * 4096 if Path("/proc/self/statm").exists() else 0


def table(rows: dict[str, Counter[str]]) -> str:
    """Return the outcomes of every format as a table."""
    lines = [f"| format | mutants | {' | '.join(OUTCOMES)} |", "|" + "---|" * (len(OUTCOMES) + 2)]
    for name, found in rows.items():
        lines.append(f"| {name} | {sum(found.values())} | {' | '.join(str(found[one]) for one in OUTCOMES)} |")
    return "\n".join(lines) + "\n"


def is_bad(name: str, found: Counter[str]) -> bool:
    """Whether something happened that must not."""
    never = ["foreign", "hang", "crash"]
    never += ["other structure"] if FORMS[name].text or FORMS[name].exact else []
    never += ["other values", "cut between lines"] if FORMS[name].exact else []
    return any(found[one] for one in never)


def main() -> int:
    if sys.argv[1:2] == ["--child"]:
        return read_as_child(*sys.argv[2:])
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("count", type=int, nargs="?", default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--format", choices=list(FORMS), action="append")
    parser.add_argument("--keep", type=Path, help="folder for mutants with outcomes that need a look")
    parser.add_argument("--docs", action="store_true", help="put the table into docs/robustness.md")
    arguments = parser.parse_args()
    rows = {}
    if arguments.keep:
        arguments.keep.mkdir(parents=True, exist_ok=True)
    for name in arguments.format or FORMS:
        rows[name] = fuzz(name, arguments.count, arguments.seed, arguments.keep)
        print(f"{name}: " + ", ".join(f"{rows[name][one]} {one}" for one in OUTCOMES if rows[name][one]), flush=True)
    print("\n" + table(rows))
    if arguments.docs:
        put("inputs", table(rows))
    return 1 if any(is_bad(*row) for row in rows.items()) else 0


if __name__ == "__main__":
    sys.exit(main())
