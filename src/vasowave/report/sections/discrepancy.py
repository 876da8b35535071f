"""What the wall laws leave of the pressure by harmonic, and what of it all animals of a study have in common."""

import numpy as np
import pandas as pd

from vasowave.cohort.cohort import Cohort
from vasowave.cohort.discrepancy import all_discrepancies
from vasowave.figures.discrepancy import discrepancy_figure
from vasowave.report.blocks import Block, Bullets, Drawing, Fold, Table
from vasowave.report.wording import number


def discrepancy_blocks(cohort: Cohort) -> list[Block]:
    """Return sentences, figure and table; nothing where there are too few animals to see what they share."""
    found = all_discrepancies(cohort)
    if not found:
        return []
    caption = (
        "What each law leaves of the pressure by harmonic: every animal (thin), the root mean square of all (black), "
        "what all have in common (dotted), and the error of the averaged beats (dashed). Dots: phases agree more than "
        "chance would have it."
    )
    data = pd.concat([table.assign(wall=wall) for wall, table in found.items()], ignore_index=True)
    table = Table.of("Discrepancy", "What the laws leave in every harmonic, and what of it all animals share", data)
    return [
        Bullets([left_alike(wall, table, len(cohort.calibrated(wall))) for wall, table in found.items()]),
        Drawing("Discrepancy", caption, discrepancy_figure(cohort, found)),
        Fold(table.caption, [table]),
    ]


def left_alike(wall: str, found: pd.DataFrame, animals: int) -> str:
    """Return what one law leaves of the pressure of so many animals, and whether in all of them alike."""
    left, error = (np.sqrt((found[name] ** 2).sum() / 2) for name in ("residual [mmHg]", "error [mmHg]"))
    alike = [
        f"{row['harmonic']} ({number(row['common [mmHg]'], 1)} mmHg)"
        for row in found[found["alike"]].to_dict("records")
    ]
    beats = f", the error of the averaged beats is {number(error, 2)}" if error > 0 else ""
    return (
        f"{wall.capitalize()} wall: {number(left, 2)} mmHg r.m.s. of the pressure are left{beats}; "
        f"{_shared(alike, animals)}."
    )


def _shared(alike: list[str], animals: int) -> str:
    if not alike:
        return "none of its harmonics is alike in all animals: what is left differs from animal to animal"
    which = f"harmonic {alike[0]} of it is" if len(alike) == 1 else f"harmonics {', '.join(alike)} of it are"
    return (
        f"{which} alike in all {animals} animals: there the model or the way of measuring errs, not chance, and more "
        "animals do not average it out"
    )
