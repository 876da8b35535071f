"""Accuracy and silent failures on volumes unlike the phantom's, by kind.

Usage: python benchmarks/unlike_accuracy.py [volumes of each kind, 2] [first seed, 1000] [automatic|guided] [kind …]
Kinds stand in `unlike.KINDS` (constants were chosen on their seeds below 100) and `unlike.UNSEEN` (never looked at
while choosing); without a kind all are run. Ctrl-C ends early with the table of what was run.

A volume fails silently if its topology is wrong and no warning doubts the topology, or if a vessel is off by more than
10 % in length or 5 % in radius and no warning names it. Errors in percent: median / 95th percentile / worst.
"""

import os
import sys
import time
import warnings
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

sys.path.insert(0, os.path.dirname(__file__))
from unlike import KINDS, UNSEEN, make
from vasowave.errors import VasowaveError, VasowaveWarning
from vasowave.imaging import Options, extract

LENGTH, RADIUS = 0.10, 0.05
"""A vessel off by more than this share must be named by a warning."""


@dataclass(frozen=True)
class Outcome:
    """What came of one volume; errors are signed shares by vessel, in the order of the truth."""

    kind: str
    seed: int
    answer: str  # "right", "wrong", "refused"
    silent: str = ""  # what no warning named
    count: int = 0
    length: tuple = ()
    radius: tuple = ()
    named: tuple = ()
    sure: tuple = ()  # |radius error| over 2 SD
    cost: float = 0.0

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
            return Outcome(name, seed, "refused", str(error))
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
    flags = tuple(row in named for row in order)
    sure = np.abs(radius) * made.radius / (2 * found.measured.radius_sd[order])
    texts = ", ".join(f"{row + 1}" for row in missed)
    silent = f"vessel(s) {texts}" if missed else ""
    return Outcome(name, seed, "right", silent, len(order), tuple(length), tuple(radius), flags, tuple(sure), cost)


def table(results):
    print("| kind | right | refused | silent | length | radius | in 2 SD | named, of good vessels | CPU-s |")
    print("|---|---|---|---|---|---|---|---|---|")
    for kind in dict.fromkeys(one.kind for one in results):
        runs = [one for one in results if one.kind == kind]
        good = [one for one in runs if one.answer == "right"]
        columns = [
            f"{len(good)} of {len(runs)}",
            str(sum(one.answer == "refused" for one in runs)),
            str(sum(bool(one.silent) and one.answer != "refused" for one in runs)),
            spread([one.length for one in good]),
            spread([one.radius for one in good]),
            share([value for one in good for value in one.sure if np.isfinite(value)], lambda value: value <= 1),
            share(
                [
                    flag
                    for one in good
                    for flag, x, y in zip(one.named, one.length, one.radius, strict=True)
                    if abs(x) <= LENGTH and abs(y) <= RADIUS
                ],
                bool,
            ),
            f"{np.mean([one.cost for one in runs]):.1f}",
        ]
        print(f"| {kind} | " + " | ".join(columns) + " |", flush=True)


def spread(parts):
    values = 100 * np.abs(np.concatenate([np.array(part) for part in parts])) if parts else np.array([])
    return " / ".join(f"{value:.1f}" for value in np.quantile(values, (0.5, 0.95, 1))) if len(values) else "-"


def share(values, test):
    return f"{100 * np.mean([test(value) for value in values]):.0f} %" if values else "-"


def main():
    words = sys.argv[1:]
    numbers = [int(word) for word in words if word.isdigit()]
    count, first = [*numbers, *(2, 1000)[len(numbers) :]]
    mode = "guided" if "guided" in words else "automatic"
    kinds = [word for word in words if word in KINDS | UNSEEN] or list(KINDS | UNSEEN)
    results = []
    with ProcessPoolExecutor(2) as pool:
        jobs = [pool.submit(outcome, kind, seed, mode) for seed in range(first, first + count) for kind in kinds]
        try:
            for job in as_completed(jobs):
                one = job.result()
                results.append(one)
                if one.silent:
                    print(f"  {one.kind}, seed {one.seed}: {one.answer} ({one.count}), {one.silent}", flush=True)
        except (KeyboardInterrupt, BrokenProcessPool) as reason:
            print(f"stopped early: {reason!r}", flush=True)
        pool.shutdown(wait=True, cancel_futures=True)
    results.sort(key=lambda one: (kinds.index(one.kind), one.seed))
    print(f"{len(results)} volumes, {mode}, seeds {first} to {first + count - 1}")
    table(results)


if __name__ == "__main__":
    main()
