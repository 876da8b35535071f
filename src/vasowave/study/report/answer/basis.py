"""What the answer rests on: imaged lungs, errors that p allows for, and how far lungs may differ for it to hold."""

from collections.abc import Sequence

import numpy as np

from vasowave.study.cohort.cohort import Cohort
from vasowave.study.cohort.effects import Effect, GroupEffect, grouped
from vasowave.study.cohort.primary import Primary
from vasowave.study.report.answer.effects import Called, EffectVerdict, labels, standing
from vasowave.study.report.answer.limits import assumed_errors, shared_images
from vasowave.study.report.wording import listed, number

_SOURCES = {"usual": "a usual value; the study gives none", "lab": "stated", "imaged": "by the lungs imaged"}


def basis(cohort: Cohort, primary: Primary, called: Called) -> list[str]:
    """Return sentences on the images and errors behind the answer, and on the lungs that would change it."""
    if not primary.law or not primary.effects:
        return []
    images = shared_images(cohort)
    lungs = [*_lungs(primary), *_tipping(primary.effects, called)] if images else []
    drawn = any(effect.origin == "posterior" for effect in primary.effects)
    return [*images, *assumed_errors(cohort.results, drawn), *lungs, *_without_image(primary.effects)]


def _lungs(primary: Primary) -> list[str]:
    """Say how much lungs of one group are taken to differ."""
    if primary.lungs is None:
        return []
    share, source = number(100 * primary.lungs.sd, 2), _SOURCES[primary.lungs.source]
    return [f"Radii are taken to differ by {share} % between lungs of one group (SD; {source})."]


def _tipping(effects: Sequence[Effect], called: Called) -> list[str]:
    """Say which effects other lungs would hide, and which would be shown if lungs differed less."""
    several = len(labels(effects)) > 1
    tipped = [effect for effect in effects if isinstance(effect, GroupEffect) and 0 < effect.tipping_lung_sd < np.inf]
    effects_by_standing = grouped(tipped, standing)

    def named(effect: GroupEffect) -> str:
        share = f"{number(100 * effect.tipping_lung_sd, 2)} %"
        side = "above" if standing(effect) == EffectVerdict.SHOWN else "below"
        return f"{called(effect.quantity)} ({f'{effect.contrast}, ' if several else ''}{side} {share})"

    texts = {
        EffectVerdict.SHOWN: "If they differ more, effects are no longer shown: {}.",
        EffectVerdict.OPEN: "If they differ less, which more imaged lungs of a group would tell, more are shown: {}.",
    }
    return [
        text.format(listed([named(effect) for effect in effects_by_standing[verdict]]))
        for verdict, text in texts.items() if verdict in effects_by_standing
    ]  # fmt: skip


def _without_image(effects: Sequence[Effect]) -> list[str]:
    """Say that measured quantities do not depend on images."""
    measured = any(effect.source == "measured" for effect in effects)
    return ["No image is behind numbers that are measured."] if measured else []
