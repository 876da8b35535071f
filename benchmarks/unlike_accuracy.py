"""Accuracy and silent failures on volumes unlike the phantom's, by kind.

Usage: python benchmarks/unlike_accuracy.py FILE.jsonl [volumes a kind, 4] [first seed, 3000] [guided] [kind …]
Kinds stand in `unlike.KINDS` (constants were chosen on their seeds below 3000) and `unlike.UNSEEN` (never looked at
while choosing); without a kind all are run, `MORE` of those that must never fail silently. Every outcome is appended
to FILE as it comes, and what it holds is not run again; with 0 volumes only its table is printed.

A volume fails silently if its topology is wrong and no warning doubts the topology, or if a vessel is off by more than
10 % in length or 5 % in radius and no warning names it. Errors in percent: median / 95th percentile / worst.
"""

import json
import os
import sys
import time
import warnings
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import linear_sum_assignment

sys.path.insert(0, os.path.dirname(__file__))
from unlike import KINDS, UNSEEN, make
from vasowave.base import VasowaveError, VasowaveWarning
from vasowave.lung import Options, extract

LENGTH, RADIUS = 0.10, 0.05
"""A vessel off by more than this share must be named by a warning."""
FEW = {"61 vessels": 2, "101 vessels": 1, "141 vessels": 1, "thin twigs": 3, "oval 0.7": 2}
"""Volumes of kinds that take longest."""
MORE = dict.fromkeys(
    ("plain", "bent 1.03", "bent 1.05", "taper 15 %", "taper 25 %", "fading 20 %", "fading 25 %", "fading 30 %"), 10
)
"""Volumes of the kinds of which none may fail silently."""


@dataclass(frozen=True)
class Outcome:
    """What came of one volume; errors are signed shares by vessel, in the order of the truth."""

    kind: str
    seed: int
    answer: str  # "right", "wrong", "refused"
    silent: str = ""  # what no warning named; where refused, the reason
    count: int = 0
    length: tuple = ()
    radius: tuple = ()
    named: tuple = ()
    sure: tuple = ()  # |radius error| over 2 SD
    cost: float = 0.0
    sure_length: tuple = ()

    @property
    def alarms(self):
        """Whether each vessel that is well measured is named by a warning."""
        rows = zip(self.named, self.length, self.radius, strict=True)
        return [flag for flag, length, radius in rows if abs(length) <= LENGTH and abs(radius) <= RADIUS]


def pairing(made, tree):
    """Return the found row of every true vessel, or None where the topology is another: known by the ends beyond."""
    true_ends, found_ends = made.terminals, np.array(tree.terminals)
    if len(true_ends) != len(found_ends):
        return None
    places = np.array([tree.lines[row].points[-1] for row in found_ends])
    gaps = np.linalg.norm(made.ends[true_ends][:, None] - places[None], axis=2)
    rows, columns = linear_sum_assignment(gaps)
    mates = dict(zip(found_ends[columns].tolist(), true_ends[rows].tolist(), strict=True))
    beyond_true = _beyond(made.parent, {row: row for row in true_ends.tolist()})
    beyond_found = _beyond(tree.parent, mates)
    by_ends = {ends: row for row, ends in beyond_found.items()}
    if set(by_ends) != set(beyond_true.values()) or len(by_ends) != len(made.parent):
        return None
    return [by_ends[beyond_true[row]] for row in range(len(made.parent))]


def _beyond(parent, names):
    """Return the named ends beyond every vessel."""
    found = {row: set() for row in range(len(parent))}
    for row, name in names.items():
        at = row
        while at >= 0:
            found[at].add(name)
            at = int(parent[at])
    return {row: frozenset(ends) for row, ends in found.items()}


def outcome(name, seed, mode):
    """Run one volume."""
    made = make((KINDS | UNSEEN)[name], seed)
    outlets = made.ends[made.terminals].tolist() if mode == "guided" else None
    begin = time.process_time()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VasowaveWarning)
        try:
            found = extract(made.volume, Options((made.root + np.array([0.02, 0, 0])).tolist(), outlets))
        except VasowaveError as error:
            return Outcome(name, seed, "refused", str(error), cost=time.process_time() - begin)
    return judged(name, seed, made, found, time.process_time() - begin)


def judged(name, seed, made, found, cost):
    """Compare an extraction with the truth."""
    order = pairing(made, found.tree)
    doubted = any(doubt.about == "topology" for doubt in found.doubts)
    if order is None:
        silent = "" if doubted else "topology"
        return Outcome(name, seed, "wrong", silent, len(found.network), cost=cost)
    named = {int(name) - 1 for doubt in found.doubts for name in doubt.vessels}
    length = found.network.length[order] / made.length - 1
    radius = found.network.radius[order] / made.radius - 1
    bad = (np.abs(length) > LENGTH) | (np.abs(radius) > RADIUS)
    missed = [order[row] for row in np.flatnonzero(bad) if order[row] not in named]
    flags = tuple(bool(row in named) for row in order)
    sure = np.abs(radius) * made.radius / (2 * found.measured.radius_sd[order])
    sure_length = np.abs(length) * made.length / (2 * found.measured.length_sd[order])
    texts = ", ".join(f"{row + 1}" for row in missed)
    silent = f"vessel(s) {texts}" if missed else ""
    length, radius, sure, sure_length = (tuple(map(float, column)) for column in (length, radius, sure, sure_length))
    return Outcome(name, seed, "right", silent, len(order), length, radius, flags, sure, cost, sure_length)


def table(results):
    print("| kind | right | refused | silent | length | radius | in 2 SD | good vessels named | CPU-s |")
    print("|---|---|---|---|---|---|---|---|---|")
    for kinds, heading in ((KINDS, None), (UNSEEN, "| **kinds kept unseen** | | | | | | | | |")):
        if heading:
            print(heading)
        for kind in kinds:
            runs = [one for one in results if one.kind == kind]
            if runs:
                print(f"| {kind} | " + " | ".join(columns(runs)) + " |")
        print("| **together** | " + " | ".join(columns([one for one in results if one.kind in kinds])) + " |")


def columns(runs):
    """Return the table's cells for `runs`."""
    good = [one for one in runs if one.answer == "right"]
    return [
        f"{len(good)} of {len(runs)}",
        str(sum(one.answer == "refused" for one in runs)),
        str(sum(bool(one.silent) and one.answer != "refused" for one in runs)),
        spread([one.length for one in good]),
        spread([one.radius for one in good]),
        share([value for one in good for value in one.sure if np.isfinite(value)], lambda value: value <= 1),
        share([flag for one in good for flag in one.alarms], bool),
        f"{np.mean([one.cost for one in runs]):.1f}" if runs else "-",
    ]


def spread(parts):
    values = 100 * np.abs(np.concatenate([np.array(part) for part in parts])) if parts else np.array([])
    return " / ".join(f"{value:.1f}" for value in np.quantile(values, (0.5, 0.95, 1))) if len(values) else "-"


def share(values, test):
    return f"{100 * np.mean([test(value) for value in values]):.0f} %" if values else "-"


def stored(path):
    """Return the outcomes that `path` holds, and those of an interrupted last line left out."""
    lines = path.read_text().splitlines() if path.exists() else []
    return [Outcome(**json.loads(line)) for line in lines if line.endswith("}")]


def run(path, jobs, mode):
    """Append the outcome of each of `jobs` that `path` does not hold."""
    done = {(one.kind, one.seed) for one in stored(path)}
    for kind, seed in jobs:
        if (kind, seed) in done:
            continue
        one = outcome(kind, seed, mode)
        with path.open("a") as file:
            file.write(json.dumps(asdict(one), default=float) + "\n")
        if one.silent and one.answer != "refused":
            print(f"  {one.kind}, seed {one.seed}: {one.answer} ({one.count}), {one.silent}", flush=True)


def main():
    words = sys.argv[1:]
    files = [Path(word) for word in words if word.endswith(".jsonl")]
    if len(files) != 1:
        sys.exit(__doc__)
    numbers = [int(word) for word in words if word.isdigit()]
    count, first = [*numbers, *(4, 3000)[len(numbers) :]]
    mode = "guided" if "guided" in words else "automatic"
    kinds = [word for word in words if word in KINDS | UNSEEN] or list(KINDS | UNSEEN)
    wanted = {kind: min(FEW.get(kind, count), count) if kind in FEW else MORE.get(kind, count) for kind in kinds}
    most = max(wanted.values()) if count else 0
    jobs = [(kind, first + turn) for turn in range(most) for kind in kinds if turn < wanted[kind]]
    run(files[0], jobs, mode)
    results = stored(files[0])
    print(f"{len(results)} volumes, {mode}")
    table(results)


if __name__ == "__main__":
    main()
