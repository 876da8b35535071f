"""What the answer rests on: imaged lungs, errors that p allows for, and how far lungs may differ for it to hold."""

import numpy as np
import pandas as pd

from vasowave.study.cohort.cohort import Cohort
from vasowave.study.cohort.primary import Primary
from vasowave.study.report.answer.effects import Called, EffectVerdict, by_standing, effect_of, standing
from vasowave.study.report.answer.limits import assumed_errors, shared_images
from vasowave.study.report.wording import listed, number

_SOURCES = {"usual": "a usual value; the study gives none", "lab": "stated", "imaged": "by the lungs imaged"}


def basis(cohort: Cohort, primary: Primary, called: Called) -> list[str]:
    """Return sentences on the images and errors behind the answer, and on the lungs that would change it."""
    if not primary.law or not len(primary.rows):
        return []
    images = shared_images(cohort)
    lungs = [*_lungs(primary), *_tipping(primary.rows, called)] if images else []
    drawn = bool((primary.rows["estimates"] == "posterior").any())
    return [*images, *assumed_errors(cohort.results, drawn), *lungs, *_without_image(primary.rows)]


def _lungs(primary: Primary) -> list[str]:
    """Say how much lungs of one group are taken to differ."""
    if primary.lungs is None:
        return []
    share, source = number(100 * primary.lungs.sd, 2), _SOURCES[primary.lungs.source]
    return [f"Radii are taken to differ by {share} % between lungs of one group (SD; {source})."]


def _tipping(rows: pd.DataFrame, called: Called) -> list[str]:
    """Say which effects other lungs would hide, and which would be shown if lungs differed less."""
    if "tipping lung sd" not in rows:
        return []
    limits = rows["tipping lung sd"]
    rows_by_standing = by_standing(rows[np.isfinite(limits) & (limits > 0)])
    several = rows["other"].nunique() > 1

    def named(row: pd.Series) -> str:
        share = f"{number(100 * row['tipping lung sd'], 2)} %"
        side = "above" if standing(row) == EffectVerdict.SHOWN else "below"
        return f"{called(row['quantity'])} ({f'{effect_of(row)}, ' if several else ''}{side} {share})"

    texts = {
        EffectVerdict.SHOWN: "If they differ more, effects are no longer shown: {}.",
        EffectVerdict.OPEN: "If they differ less, which more imaged lungs of a group would tell, more are shown: {}.",
    }
    return [
        text.format(listed([named(row) for _, row in rows_by_standing[place].iterrows()]))
        for place, text in texts.items() if place in rows_by_standing
    ]  # fmt: skip


def _without_image(rows: pd.DataFrame) -> list[str]:
    """Say that measured quantities do not depend on images."""
    return ["No image is behind numbers that are measured."] if (rows["source"] == "measured").any() else []
