"""The methods paragraph of a cohort, ready to paste, with the settings that were used."""

import json

import numpy as np

from vasowave.animal.reading import data_of, network, wall_laws
from vasowave.cohort.comparison import Comparison
from vasowave.figures.cohort_gallery import Cohort
from vasowave.report.cohort.cells import names
from vasowave.report.cohort.words import settings_of
from vasowave.report.wording import friction_words, listed, number

_LAWS = {"linear": "a linear elastic law (β, eq. 3)", "tangent": "a stiffening tangent law (p₁ and γ, eq. 4)"}
_FIDUCIALS = {"ecg": "the R wave of the ECG", "pressure": "the foot of the pressure"}
_METHODS = {
    "least-squares": "bounded least squares (trust region)",
    "sqp": "sequential quadratic programming",
}


def methods_paragraphs(cohort: Cohort, found: dict[str, Comparison]) -> list[str]:
    """Return the paragraphs on data, model, calibration, analyses and statistics."""
    modeled = [_model(cohort), _calibration(cohort)] if cohort.walls else []
    return [_data(cohort), *modeled, _analyses(), _statistics(cohort, found)]


def differing_settings(cohort: Cohort) -> list[str]:
    """Name the settings that are not the same for all animals."""
    shared = settings_of(cohort)
    keys = dict.fromkeys(key for tree in cohort.trees for key in json.loads(tree.attrs.get("settings", "{}")))
    return [key for key in keys if key not in shared]


def _data(cohort: Cohort) -> str:
    groups = listed([f"{len(trees)} {group}" for group, trees in cohort.groups.items()])
    return (
        f"Pressure and flow in the main pulmonary artery of {groups} animals were analyzed with vasowave "
        f"{cohort.trees[0].attrs.get('vasowave', '')}. {_averaged(cohort)}. Nominal parameters came from each "
        "recording: Z_c by the up-slope method (eq. 8), wall stiffness from Z_c (eqs. 9, 10), the time constant from "
        "the diastolic decay (eq. 12), resistances and compliances of the beds by the flow division of Poiseuille's "
        "law (eqs. 11, 13)."
    )


def _averaged(cohort: Cohort) -> str:
    """Say whose beats were averaged, and whose cycle was given as it is."""
    raw = [tree for tree in cohort.trees if "beats" in tree.children]
    given = names([tree for tree in cohort.trees if "beats" not in tree.children])
    if not raw:
        return "One averaged cycle of pressure and flow per animal was given"
    counts = sorted({int(data_of(tree, "beats")["kept"].sum()) for tree in raw})
    beats = " to ".join(str(count) for count in dict.fromkeys((counts[0], counts[-1])))
    marks = {str(data_of(tree, "beats").attrs.get("fiducial", "")) for tree in raw}
    aligned = listed(sorted(_FIDUCIALS.get(mark, mark) for mark in marks))
    whose = f" of {names(raw)}" if given else ""
    words = f"Pressure and flow{whose} were averaged over {beats} beats (rejected ones left out), aligned at {aligned}"
    return f"{words}; of {given} an averaged cycle was given" if given else words


def _model(cohort: Cohort) -> str:
    sizes = sorted({len(network(tree)) for tree in cohort.shown.values()})
    laws = listed([_LAWS.get(wall, wall) for wall in cohort.walls])
    blood = settings_of(cohort).get("blood")
    words = ""
    if isinstance(blood, dict):
        friction = dict(blood.get("friction", {}))
        words = (
            f" Blood had density {blood['density']} g/ml and kinematic viscosity {blood['viscosity']} cm²/s; friction "
            f"was that of {friction_words(friction.pop('law', ''), friction)}."
        )
    return (
        f"One-dimensional flow (eq. 2) was solved in networks of {listed([str(size) for size in sizes])} vessels with "
        f"{laws}, continuity of pressure and flow at junctions (eq. 6) and three-element Windkessels (eq. 7); the "
        f"measured flow was the inflow.{words}{_numerics(cohort)}"
    )


def _numerics(cohort: Cohort) -> str:
    attrs = [data_of(tree, f"{wall}/simulation").attrs for tree in cohort.trees for wall in wall_laws(tree)]
    if not attrs or not all({"courant", "cell_size", "converged", "cycles"} <= set(one) for one in attrs):
        return ""
    periodic = sum(bool(one["converged"]) for one in attrs)
    courant, cell = (max(float(one[key]) for one in attrs) for key in ("courant", "cell_size"))
    return (
        f" The two-step Lax–Wendroff scheme had cells of at most {number(cell, 2)} cm and a Courant number of at most "
        f"{number(courant, 2)}; {periodic} of {len(attrs)} calibrated simulations met the criterion for a periodic "
        "state."
    )


def _calibration(cohort: Cohort) -> str:
    shared = settings_of(cohort)
    method = _METHODS.get(str(shared.get("method")), str(shared.get("method", "")))
    starts = sorted(
        {int(data_of(tree, f"{wall}/calibration").sizes["start"]) for tree in cohort.trees for wall in wall_laws(tree)}
    )
    bounds = "the bounds of Qureshi et al." if shared.get("paper_bounds") else "wide bounds (table of bounds)"
    own = shared.get("bounds") or {}
    fixed = shared.get("fixed") or {}
    extra = f", own bounds for {listed(list(own))}" if isinstance(own, dict) and own else ""
    held = (
        f" Held fixed: {', '.join(f'{k} = {v}' for k, v in fixed.items())}."
        if isinstance(fixed, dict) and fixed
        else ""
    )
    free = "; ".join(f"{wall}: {_free(cohort, wall)}" for wall in cohort.walls)
    return (
        "The sum S of squared differences between measured and simulated waveforms at the inlet (eq. 14) was minimized "
        f"by {method} from {listed([str(count) for count in starts])} starts (seed {shared.get('seed', '–')}) within "
        f"{bounds}{extra}, over {free}. "
        "R1 = r1·R1⁰, R2 = r2·R2⁰ and C = c1·C⁰ in all vascular beds."
        f"{held} Intervals follow from the Jacobian at the optimum and allow for the correlation of the residuals."
    )


def _free(cohort: Cohort, wall: str) -> str:
    fit = next(data_of(tree, f"{wall}/calibration") for tree in cohort.trees if wall in wall_laws(tree))
    free = fit["free"].values.astype(bool)
    return ", ".join(str(name) for name in fit["parameter"].values[np.flatnonzero(free)])


def _analyses() -> str:
    return (
        "Waves were separated and their time-normalized intensity computed without smoothing (eqs. 15, 16); I_R is the "
        "ratio of the ranges of the backward and the forward pressure wave over the cycle (eq. 17). Impedance spectra "
        "came from Fourier series (eqs. 18, 19), harmonics whose flow was near the noise level were marked. "
        "Compliances were taken at diastolic pressure, C_v by the published series/parallel rule and as plain sum "
        "(eqs. 25 to 30), wave speeds at mean pressure (eqs. 31, 32)."
    )


def _statistics(cohort: Cohort, found: dict[str, Comparison]) -> str:
    tests = "; ".join(f"{source}: {len(one.contrasts)} tests" for source, one in found.items() if len(one.contrasts))
    if not tests:
        return "Groups are described by mean, SD, median and quartiles; nothing was compared."
    reference = next(iter(cohort.groups))
    more = (
        " More than two groups were compared by a permutation Kruskal-Wallis test first."
        if len(cohort.groups) > 2
        else ""
    )
    return (
        f"Groups were compared by exact two-sided Mann-Whitney tests, p values adjusted by Holm's method within each "
        f"source ({tests}), ratios of geometric means with Welch intervals, and Hedges' g with intervals from the "
        f"noncentral t distribution; the importance index η (eq. 20) is relative to {reference}.{more} Every "
        "comparison was repeated without each animal in turn where groups had three animals or more."
    )
