"""The limits of the answer: geometry that animals share, what data leave open, the error of the model itself."""

from collections import Counter
from collections.abc import Mapping

import numpy as np

from vasowave.animal.result import AnimalResult
from vasowave.cohort.cohort import Cohort
from vasowave.cohort.primary import Primary
from vasowave.report.wording import OF_FLOW, listed, number


def model_limits(cohort: Cohort, law: str, written: Mapping[str, str]) -> list[str]:
    """Return sentences on what the fits leave open; nothing where nothing was fitted."""
    if not law:
        return []
    return [
        *_image_pressure(cohort), *_residual(cohort, law), *_open(cohort, law, written), *_held(cohort, written),
        *_of_fits(cohort),
    ]  # fmt: skip


def _of_fits(cohort: Cohort) -> list[str]:
    """Offer posteriors, with what they cost, where there is none."""
    if any(result.laws[law].posterior is not None for result in cohort.results for law in result.laws):
        return []
    return [
        "Intervals of fits take what nobody said of image, zero and probe for exact, and the model for right. "
        "Posteriors (inference: posterior in study.yaml, --inference posterior of vasowave fit) allow for these "
        "errors; they take about ten seconds of one processor for an animal and law."
    ]


def _image_pressure(cohort: Cohort) -> list[str]:
    """Say at which pressure the radii were measured, where the results tell."""
    count = len(cohort.results)
    known = [result.network.pressure for result in cohort.results if result.network.pressure]
    if not known:
        return ["The image's pressure is not known; radii are taken as those at 0 mmHg, and stiffness depends on that."]
    low, high = number(min(known)), number(max(known))
    what = "recordings" if cohort.repeated else "animals"
    unknown = f" Of {count - len(known)} of {count} {what} it is not known: their radii are taken as those at 0 mmHg."
    return [
        f"Radii are those at the image's pressure, {low if low == high else f'{low} to {high}'} mmHg, taken as exact."
        f"{unknown if len(known) < count else ''}"
    ]


def no_wedge(cohort: Cohort) -> list[str]:
    """Say where resistances count from 0 mmHg for want of a pressure behind the beds; of one animal its answers do."""
    without = [result for result in cohort.results if "wedge_pressure" not in result.recording]
    if cohort.single or not without:
        return []
    whose = "" if len(without) == len(cohort.results) else f" of {len(without)} of {len(cohort.results)} recordings"
    return [f"No wedge pressure{whose} is given: PVR, R_T, R_T C_T and the measured decay count from 0 mmHg. With one "
            "they are smaller."]  # fmt: skip


def one_geometry(cohort: Cohort, primary: Primary) -> list[str]:
    """Say where animals of a group have one network: of its geometry there is one measurement, whatever n is.

    That the quantities of fits then have no p stands with the answers.
    """
    if cohort.single or not cohort.walls:
        return []
    alike = [group for group, results in cohort.groups.items() if len(results) > 1 and _share_a_network(results)]
    if not alike:
        return []
    if _share_a_network(cohort.results):
        return ["All animals have one network: of its geometry n is 1. Its error counts as the same in all of them."]
    first, *others = cohort.groups
    radius = {
        group: float(network.radius[network.root])
        for group, network in ((group, results[0].network) for group, results in cohort.groups.items())
    }
    factors = listed([f"{number((radius[group] / radius[first]) ** 4, 2)} in {group}" for group in others])
    alone = f"; by that alone it differs from {first} by a factor of {factors}" if others else ""
    drawn = len(primary.rows) and (primary.rows["estimates"] == "posterior").any()
    aware = " Intervals and p from posteriors contain the error of the image." if drawn else ""
    return [
        f"Within {listed(alike)} all animals have one network: of its geometry n is 1. Stiffness grows with the fourth "
        f"power of the root's radius{alone}.{aware}"
    ]


def _share_a_network(results: list[AnimalResult]) -> bool:
    first, *rest = (result.network.radius for result in results)
    return all(np.array_equal(one, first) for one in rest)


def _residual(cohort: Cohort, law: str) -> list[str]:
    table = cohort.misfits
    table = table[table["wall"] == law]
    left, error = float(table["RMSE"].median()), float(table["error"].median())
    typical = "" if cohort.single else " (median)"
    typical += OF_FLOW if cohort.law(law).compared == "flow" else ""
    if not np.isfinite(error):
        return [f"The {law} wall leaves {number(left, 2)} mmHg{typical}; how well the cycle itself is known is not."]
    said = "not noise but the model's error" if left > 2 * error else "what the beats' scatter explains"
    return [
        f"The {law} wall leaves {number(left, 2)} mmHg{typical}, {number(left / error, 2)} times the error of the "
        f"averaged cycle ({number(error, 2)} mmHg): {said}."
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
        "differ by more than a factor of 4, or at a bound)."
    ]


def _counted(cohort: Cohort, count: Mapping[str, int], fits: int, written: Mapping[str, str]) -> str:
    """Return parameters in words, of several animals with the number of fits: ``β in 2 of 6 and a in 1 of 6``."""
    return listed([written.get(n, n) + ("" if cohort.single else f" in {k} of {fits}") for n, k in count.items()])


def _held(cohort: Cohort, written: Mapping[str, str]) -> list[str]:
    """Name what was not fitted: a value that somebody chose, or the bound at which a search stopped."""
    said, stopped = [], []
    for wall in cohort.walls:
        fits = cohort.calibrations(wall)
        fixed = {
            f"{written.get(str(name), str(name))} = {number(float(value))}"
            for fit in fits
            for name, value, free in zip(fit["parameter"].values, fit["value"].values, fit["free"].values)
            if not free
        }
        if fixed:
            said.append(f"Held, not fitted ({wall} wall): {listed(sorted(fixed))}; its results hold for that value.")
        bound = Counter(str(n) for fit in fits for n in fit["parameter"].values[fit["at_bound"].values.astype(bool)])
        if bound:
            stopped.append(f"{_counted(cohort, bound, len(fits), written)} ({wall} wall)")
    if stopped:
        said.append(f"Stopped at a bound of the search: {listed(stopped)}; there the number is the bound's.")
    return said
