"""Radii in images whose grey levels are not linear: what is named, and what the offered correction makes of them.

Usage: python benchmarks/grey_scales.py FILE.jsonl [volumes, 40] [first seed, 8000]
Volumes are those of `unlike`, each brought to 8 or 16 bits by one of `SCALES`, from the darkest level to the brightest.
The threshold is the one that `vasowave look` proposes; the root is given. A volume is silent if a radius is off by more
than 5 % and no doubt names the vessel. Where a correction is offered, the volume is extracted again with it. Limits
were chosen on seed 11, on linear volumes of seeds 41 to 43, and on 40 volumes from seed 7000 on. Errors in percent:
median / 95th percentile / worst.
"""

import json
import os
import sys
import time
import warnings
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

sys.path.insert(0, os.path.dirname(__file__))
from unlike import KINDS, UNSEEN, make
from unlike_accuracy import RADIUS, pairing, spread
from vasowave.base import VasowaveError, VasowaveWarning
from vasowave.lung import Options, extract, parse_grey
from vasowave.lung.lumen import levels_of
from vasowave.lung.read import Volume, isotropic
from vasowave.lung.witness import Grade

LOW = 0.05
"""Percentile of the grey levels that becomes 0."""


def logistic(u, steepness=6.0):
    ends = 1 / (1 + np.exp(steepness / 2))
    return (1 / (1 + np.exp(-steepness * (u - 0.5))) - ends) / (1 - 2 * ends)


def root_with_offset(u, offset=0.1):
    return (np.sqrt(u + offset) - np.sqrt(offset)) / (np.sqrt(1 + offset) - np.sqrt(offset))


def logarithm(u, strength=5.0):
    return np.log1p(strength * u) / np.log1p(strength)


def arctangent(u, strength=2.0):
    return np.arctan(strength * u) / np.arctan(strength)


def gamma(power):
    return lambda u: u**power


SCALES = {f"gamma {power:g}": gamma(power) for power in (0.5, 0.6, 0.7, 0.8, 1.0, 1.25, 1.4, 1.7, 2.0)} | {
    "logistic": logistic,
    "root with offset": root_with_offset,
    "logarithm": logarithm,
    "arctangent": arctangent,
    **{f"clipped at {share} %": gamma(1.0) for share in (50, 60, 70, 80, 90)},
}
VOLUMES = ("plain", "bent 1.03", "taper 15 %", "fading 20 %", "oval 0.85", "cupping", "irregular", "noise 10", "grain",
           "blurred along y", "faint rings", "patchy")  # fmt: skip


@dataclass(frozen=True)
class Outcome:
    """What came of one volume; radius errors are signed shares by vessel, `after` the offered correction."""

    kind: str
    scale: str
    bits: int
    seed: int
    answer: str  # "right", "wrong", "refused: why"
    silent: int = 0
    named: str = ""  # code of the doubt about the grey levels
    before: tuple = ()
    after: tuple = ()
    cost: float = 0.0


def exported(volume, name, bits, contrast=88.0, background=12.0):
    """Return `volume` as a viewer would export it: by a scale, clipped, in whole numbers."""
    grey = np.asarray(volume.grey, dtype=float)
    low, high = np.percentile(grey, LOW), grey.max()
    if name.startswith("clipped"):
        high = background + contrast * int(name.split()[2]) / 100
    share = np.clip((grey - low) / (high - low), 0, 1)
    return Volume(np.round((2**bits - 1) * SCALES[name](share)), volume.spacing, volume.origin)


def outcome(kind, scale, bits, seed):
    made = make((KINDS | UNSEEN)[kind], seed)
    image = exported(made.volume, scale, bits)
    root, begin = (made.root + np.array([0.02, 0, 0])).tolist(), time.process_time()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VasowaveWarning)
        try:
            found = extract(image, Options(root, threshold=levels_of(isotropic(image)).threshold))
        except VasowaveError as error:
            return Outcome(kind, scale, bits, seed, f"refused: {error}")
        cost = time.process_time() - begin
        about = [one for one in found.doubts if one.finding.code.startswith("image.")]
        named = about[0].finding.code if about else ""
        order = pairing(made, found.tree)
        if order is None:
            return Outcome(kind, scale, bits, seed, "wrong", named=named, cost=cost)
        before = found.network.radius[order] / made.radius - 1
        doubted = {int(name) - 1 for one in found.doubts if one.grade in (Grade.WRONG, Grade.LOOK, Grade.UNCERTAIN)
                   for name in one.vessels}  # fmt: skip
        silent = sum(abs(off) > RADIUS and row not in doubted for off, row in zip(before, order, strict=True))
        after = _after(made, image, root, about[0].text) if about and "corrected, grey " in about[0].text else ()
    return Outcome(kind, scale, bits, seed, "right", int(silent), named, tuple(before), after, cost)


def _after(made, image, root, text):
    """Return the radius errors with the correction that `text` offers."""
    pairs = parse_grey(text.partition("corrected, grey ")[2].partition(", the")[0])
    from vasowave.lung.measure import corrected

    threshold = levels_of(isotropic(corrected(image, pairs))).threshold
    try:
        found = extract(image, Options(root, threshold=threshold, grey=pairs))
    except VasowaveError:
        return (float("nan"),)
    order = pairing(made, found.tree)
    return (float("nan"),) if order is None else tuple(found.network.radius[order] / made.radius - 1)


def main():
    name, *numbers = sys.argv[1:]
    count, first = [*map(int, numbers), *(40, 8000)[len(numbers) :]]
    path, names = Path(name), list(SCALES)
    done = [Outcome(**json.loads(line)) for line in path.read_text().splitlines()] if path.exists() else []
    for number in range(count):
        job = (VOLUMES[number % len(VOLUMES)], names[number * 5 % len(names)], (8, 16)[number % 2], first + number)
        if job not in [(one.kind, one.scale, one.bits, one.seed) for one in done]:
            done.append(outcome(*job))
            with path.open("a") as file:
                file.write(json.dumps(asdict(done[-1]), default=float) + "\n")
    report(done)


def report(done):
    print("| scale | volumes | right | refused | silent | named | radius | offered | radius after it | within 2 % |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    groups = {"gamma 1": ["gamma 1"], "gamma 0.5 to 0.8": [f"gamma {p}" for p in (0.5, 0.6, 0.7, 0.8)],
              "gamma 1.25 to 2": [f"gamma {p:g}" for p in (1.25, 1.4, 1.7, 2.0)],
              "logistic, root, logarithm, arctangent": [name for name in SCALES if name[0] in "lra"],
              "clipped at 50 to 90 %": [name for name in SCALES if name.startswith("clipped")],
              "together": list(SCALES)}  # fmt: skip
    for title, names in groups.items():
        own = [one for one in done if one.scale in names]
        right, again = [one for one in own if one.answer == "right"], [one for one in own if one.after]
        within = [abs(off) <= 0.02 for one in again for off in one.after]
        cells = [title, len(own), len(right), sum(one.answer.startswith("refused") for one in own),
                 sum(one.silent > 0 for one in own), sum(bool(one.named) for one in own),
                 spread([one.before for one in right]), len(again), spread([one.after for one in again]),
                 f"{100 * np.mean(within):.0f} %" if within else "-"]  # fmt: skip
        print("| " + " | ".join(map(str, cells)) + " |")
    for one in done:
        if one.silent or one.answer != "right":
            print(
                f"  {one.kind}, {one.scale}, {one.bits} bit, seed {one.seed}: {one.answer[:150]}, silent {one.silent}"
            )


if __name__ == "__main__":
    main()
