"""Pressure-volume loops of ventricles with a known elastance: how often E_es, V_0 and their intervals are right.

    python benchmarks/loops.py 6 --docs      six ventricles of each shape and species: minutes; docs/coverage.md

Each row has four species, mouse to human, left and right, 200 to 2000 samples/s; the pressure's noise has an SD of 0.3
to 1 % of the pulse. Constants were chosen with the shapes that the table calls seen, not with the others.
"""

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from robustness_page import main_of_table
from vasowave.pulse.analysis import pressure_volume
from vasowave.pulse.cycle import PressureVolume

ROOT = Path(__file__).parents[1]
sys.path.append(str(ROOT / "tests"))
from made_ventricle import SHAPES, SPECIES, made_ventricles  # noqa: E402

HEAD = ("loops", "shapes", "ventricles", "E_es within 5 %", "V_0 within 10 % of the width", "E_es held", "V_0 held")
STILL = {"breaths": 0.0, "drift": 0.0}
KINDS: dict[str, dict[str, Any]] = {
    "volume's noise 0.5 % of the stroke": STILL | {"volume_noise": 0.005},
    "1 %": STILL | {"volume_noise": 0.01},
    "2 %": STILL | {"volume_noise": 0.02},
    "1 %, breaths of 1 mmHg": STILL | {"volume_noise": 0.01, "breaths": 1.0},
    "1 %, drift of 1 mmHg/min": STILL | {"volume_noise": 0.01, "drift": 1 / 60},
    "1 %, both": {"volume_noise": 0.01, "breaths": 1.0, "drift": 1 / 60},
}


def row(kind: str, shapes: tuple[str, ...], each: int) -> str:
    """Return the row of one kind of recording."""
    rng = np.random.default_rng([2027, list(KINDS).index(kind), SHAPES.index(shapes[0])])
    counts = np.zeros(4, dtype=int)
    for case in made_ventricles(rng, shapes, each=each, **KINDS[kind]):
        estimates = pressure_volume(PressureVolume(case.pressure, case.volume, case.rate, case.name)).estimates
        if "E_es" not in estimates:
            continue
        elastance, zero = estimates["E_es"], estimates["V_0"]
        counts += [
            abs(elastance.value / case.elastance - 1) < 0.05,
            abs(zero.value - case.zero_volume) < 0.1 * case.stroke_volume,
            elastance.low < case.elastance < elastance.high,
            zero.low < case.zero_volume < zero.high,
        ]
    words = "seen" if shapes[0] == SHAPES[0] else "unseen"
    return f"| {' | '.join(map(str, (kind, words, each * len(shapes) * len(SPECIES), *counts)))} |"


def table(each: int) -> Iterator[str]:
    """Yield the lines of the table."""
    yield f"| {' | '.join(HEAD)} |"
    yield "|---" * len(HEAD) + "|"
    for kind in KINDS:
        for shapes in (SHAPES[:2], SHAPES[2:]):
            yield row(kind, shapes, each)


if __name__ == "__main__":
    main_of_table(__doc__ or "", "loops", ROOT / "docs" / "coverage.md", table, 6)
