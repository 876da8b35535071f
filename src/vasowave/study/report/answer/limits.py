"""What the answer rests on, and its limits: images that animals share, errors, what data leave open."""

from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from vasowave.base.sites import PULMONARY
from vasowave.pulse.inference.known_errors import AssumedError
from vasowave.study.animal.result import AnimalResult
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.cohort.effects import Effect, GroupEffect, grouped
from vasowave.study.cohort.primary import Primary
from vasowave.study.report.answer.effects import Called, EffectVerdict, labels, standing
from vasowave.study.report.wording import OF_FLOW, listed, number

_SOURCES = {"usual": "a usual value; the study gives none", "lab": "stated", "imaged": "by the lungs imaged"}
_TIMING = {"pressure_lag", "pressure_inertia", "flow_lag", "flow_delay"}
"""Errors that move one signal against the other."""


def model_limits(cohort: Cohort, law: str, written: Mapping[str, str]) -> list[str]:
    """Return sentences on what the fits leave open; nothing where nothing was fitted."""
    if not law:
        return []
    posterior = cohort.law(law).posterior
    drawn = posterior is not None and posterior.trusted
    return [
        *_image_pressure(cohort), *_residual(cohort, law), *_open(cohort, law, written), *_held(cohort, written),
        *(assumed_errors(cohort.results, drawn) if cohort.single else ()), *_of_fits(cohort, law),
    ]  # fmt: skip


def _of_fits(cohort: Cohort, law: str) -> list[str]:
    """Offer posteriors of the law that the answer stands on, with what they cost, where there is none."""
    if any(result.laws[law].posterior is not None for result in cohort.calibrated(law)):
        return []
    inference, scope = ("reference", "") if law == cohort.walls[0] else ("posterior", " and law")
    return [
        f"Posteriors weigh the error of the model, which intervals of fits and p do not (inference: {inference} in "
        f"study.yaml, --inference {inference} of vasowave fit), in three to ten seconds of a processor for an "
        f"animal{scope}."
    ]


def assumed_errors(results: Sequence[AnimalResult], drawn: bool = False) -> list[str]:
    """Say for which errors intervals and p of the model allow, and who told them; nothing where there are none.

    Those that are `drawn` by posteriors weigh the error of the model itself, too.
    """
    errors_by_source: dict[str, dict[str, list[AssumedError]]] = {}
    for error in (error for result in results for error in result.assumed_errors):
        alike = errors_by_source.setdefault(error.source if error.sd > 0 else "exact", {})
        alike.setdefault(error.name, []).append(error)
    words = {"usual": "{} (usual values; the study gives none)", "image": "{} (by the image)", "lab": "{} (stated)"}
    sentences = [
        text.format(listed([errors[0].among(errors) for errors in errors_by_source[source].values()]))
        for source, text in words.items()
        if source in errors_by_source
    ]
    if not sentences:
        return []
    late = {
        known_error.name for result in results for known_error in result.assumed_errors if known_error.sd > 0
    } & _TIMING
    right = [] if drawn else ["take the model itself as right"]
    right += [] if late else ["allow for no filter or delay of the instruments beyond those that are corrected"]
    beyond = f" They {listed(right)}." if right else ""
    return [f"Intervals and p of the model allow for these errors (SD): {'; '.join(sentences)}.{beyond}"]


def _image_pressure(cohort: Cohort) -> list[str]:
    """Say at which pressure the radii were measured, where the results tell."""
    count = len(cohort.results)
    pressures = [result.network.pressure for result in cohort.results if result.network.pressure]
    if not pressures:
        return ["The image's pressure is not known; radii are taken as those at 0 mmHg, and stiffness depends on that."]
    low, high = number(min(pressures)), number(max(pressures))
    noun = "recordings" if cohort.repeated else "animals"
    unknown = (
        f" Of {count - len(pressures)} of {count} {noun} it is not known: their radii are taken as those at 0 mmHg."
    )
    return [
        f"Radii are those at the image's pressure, {low if low == high else f'{low} to {high}'} mmHg."
        f"{unknown if len(pressures) < count else ''}"
    ]


def shared_images(cohort: Cohort) -> list[str]:
    """Say where one lung stands for several animals: how lungs of a group differ is then not measured."""
    if cohort.single or not cohort.walls:
        return []
    alike = [group for group, results in cohort.groups.items() if len(results) > 1 and _share_a_network(results)]
    if not alike:
        return []
    organ = _organ(cohort)
    if _share_a_network(cohort.results):
        return [
            f"One imaged {organ} stands for all animals: errors of its measurement are the same in all; how {organ}s "
            "of animals differ is not measured."
        ]
    groups = f"{'each of ' if len(alike) > 1 else ''}{listed(alike)}"
    if len(alike) == len(cohort.groups):
        return [
            f"Each group has one imaged {organ}, which stands for all its animals; how {organ}s differ is not measured."
        ]
    return [f"One imaged {organ} stands for all animals of {groups}: how {organ}s of a group differ is not measured."]


def _organ(cohort: Cohort) -> str:
    """Return what was imaged: the lung, or the arteries behind another site."""
    sites = {str(result.recording.attrs.get("site", PULMONARY)) for result in cohort.results}
    return "lung" if sites == {PULMONARY} else "arterial tree"


def _share_a_network(results: list[AnimalResult]) -> bool:
    first, *radii = (result.network.radius for result in results)
    return all(np.array_equal(radius, first) for radius in radii)


def _residual(cohort: Cohort, law: str) -> list[str]:
    table = cohort.misfits
    table = table[table["wall"] == law]
    rmse, error = float(table["RMSE"].median()), float(table["error"].median())
    typical = "" if cohort.single else " (median)"
    typical += OF_FLOW if cohort.law(law).compared == "flow" else ""
    if not np.isfinite(error):
        return [f"The {law} wall leaves {number(rmse, 2)} mmHg{typical}; how well the cycle itself is known is not."]
    verdict = "not noise but the model's error" if rmse > 2 * error else "what the beats' scatter explains"
    return [
        f"The {law} wall leaves {number(rmse, 2)} mmHg{typical}, {number(rmse / error, 2)} times the error of the "
        f"averaged cycle ({number(error, 2)} mmHg): {verdict}."
    ]


def _open(cohort: Cohort, law: str, written: Mapping[str, str]) -> list[str]:
    fits = cohort.calibrations(law)
    count = Counter(
        str(name)
        for fit in fits
        for name in fit["parameter"].values[fit["free"].values.astype(bool) & ~fit["determined"].values.astype(bool)]
    )
    if not count:
        return []
    return [
        f"The data do not determine {_counted(cohort, count, len(fits), written)} ({law} wall; ends of the interval "
        f"differ by more than a factor of 4, or at a bound{'' if cohort.single else '; such animals count less'})."
    ]


def _counted(cohort: Cohort, count: Mapping[str, int], fits: int, written: Mapping[str, str]) -> str:
    """Return parameters in words, of several animals with the number of fits: ``β in 2 of 6 and a in 1 of 6``."""
    return listed([written.get(n, n) + ("" if cohort.single else f" in {k} of {fits}") for n, k in count.items()])


def _held(cohort: Cohort, written: Mapping[str, str]) -> list[str]:
    """Name what was not fitted: a value that somebody chose, or the bound at which a search stopped."""
    sentences, stopped = [], []
    for wall in cohort.walls:
        fits = cohort.calibrations(wall)
        fixed = {
            f"{written.get(str(name), str(name))} = {number(float(value))}"
            for fit in fits
            for name, value, free in zip(fit["parameter"].values, fit["value"].values, fit["free"].values)
            if not free
        }
        if fixed:
            sentences.append(
                f"Held, not fitted ({wall} wall): {listed(sorted(fixed))}; its results hold for that value."
            )
        bound = Counter(str(n) for fit in fits for n in fit["parameter"].values[fit["at_bound"].values.astype(bool)])
        if bound:
            stopped.append(f"{_counted(cohort, bound, len(fits), written)} ({wall} wall)")
    if stopped:
        sentences.append(f"Stopped at a bound of the search: {listed(stopped)}; there the number is the bound's.")
    return sentences


def basis(cohort: Cohort, primary: Primary, called: Called) -> list[str]:
    """Return sentences on the images and errors behind the answer, and on the lungs that would change it."""
    if not primary.effects:
        return []
    if not primary.law:
        return _changed_later(cohort)
    images = shared_images(cohort)
    organ = _organ(cohort)
    lungs = [*_lungs(primary, organ), *_tipping(primary.effects, called, organ)] if images else []
    drawn = any(effect.origin == "posterior" for effect in primary.effects)
    measured = any(effect.source == "measured" for effect in primary.effects)
    without_image = ["No image is behind numbers that are measured."] if measured else []
    return [*_changed_later(cohort), *images, *assumed_errors(cohort.results, drawn), *lungs, *without_image]


def _changed_later(cohort: Cohort) -> list[str]:
    """Say what was declared otherwise before there were results."""
    names = {name: None for before, after in pairwise(cohort.declared) if after.seen for name in after.changes(before)}
    if not names:
        return []
    return [f"Changed when results were there already: {listed(list(names))} (Methods say from what); p and intervals "
            "do not allow for such a choice."]  # fmt: skip


def _lungs(primary: Primary, organ: str) -> list[str]:
    """Say how much lungs (or what was imaged) of one group are taken to differ."""
    if primary.lungs is None:
        return []
    share, source = number(100 * primary.lungs.sd, 2), _SOURCES[primary.lungs.source]
    return [f"Radii are taken to differ by {share} % between {organ}s of one group (SD; {source})."]


def _tipping(effects: Sequence[Effect], called: Called, organ: str) -> list[str]:
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
        EffectVerdict.OPEN: f"If they differ less, which more imaged {organ}s of a group would tell, more are shown: "
        "{}.",
    }
    return [
        text.format(listed([named(effect) for effect in effects_by_standing[verdict]]))
        for verdict, text in texts.items() if verdict in effects_by_standing
    ]  # fmt: skip
