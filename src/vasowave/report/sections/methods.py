"""The methods in words, ready to paste, with the settings that were used."""

from collections import Counter
from collections.abc import Mapping

import numpy as np

from vasowave.animal.reading import data_of, network, period, wall_laws
from vasowave.blood import boundary_layer
from vasowave.cohort.cohort import Cohort
from vasowave.cohort.comparison import Comparison
from vasowave.cohort.primary import Primary
from vasowave.cohort.rank_tests import MOST_EXACT
from vasowave.cohort.simultaneous import DRAWS
from vasowave.report.blocks import Paragraph, Section
from vasowave.report.tables.cells import named, span, symbols
from vasowave.report.wording import friction_words, listed, number

_FIDUCIALS = {"ecg": "the R wave of the ECG", "pressure": "the foot of the pressure"}
_SEARCHES = {
    "least-squares": "bounded least squares (trust region)",
    "sqp": "sequential quadratic programming",
}


def methods_section(cohort: Cohort, primary: Primary, comparisons: Mapping[str, Comparison]) -> Section:
    """Return the paragraphs on data, model, calibration, analyses and statistics."""
    texts = [_data(cohort)]
    if cohort.walls:
        texts += [_model(cohort), _calibration(cohort)]
    texts.append(_analyses())
    if not cohort.single:
        texts += [*_primary(primary), _statistics(cohort, comparisons)]
    return Section("methods", "Methods", [Paragraph(text) for text in texts])


def _data(cohort: Cohort) -> str:
    whose = "one animal" if cohort.single else f"{_counted(cohort)} animals"
    return (
        f"Pressure and flow in the main pulmonary artery of {whose} were analyzed with vasowave "
        f"{cohort.results[0].attrs.get('vasowave', '')}.{_failed(cohort)} {_averaged(cohort)}. Nominal parameters came "
        f"from {'the' if cohort.single else 'each'} recording: Z_c by the up-slope method (eq. 8), wall stiffness from "
        "Z_c (eqs. 9, 10), the time constant from the diastolic decay (eq. 12), resistances and compliances of the "
        "beds by the flow division of Poiseuille's law (eqs. 11, 13)."
    )


def _counted(cohort: Cohort) -> str:
    """Return how many animals of each group were analyzed, and of how many, where some were lost: ``3 of 4 HPH``."""
    lost = Counter(one.group for one in cohort.lost)
    there = {group: len(cohort.groups.get(group, [])) for group in (*cohort.groups, *lost)}
    return listed(
        [f"{n} of {n + lost[group]} {group}" if lost[group] else f"{n} {group}" for group, n in there.items()]
    )


def _failed(cohort: Cohort) -> str:
    """Name every animal that was lost, and every law, posterior or comparison that an animal lacks."""
    parts: dict[str, list[str]] = {}
    for one in cohort.failures:
        parts.setdefault(one.what, []).append(one.animal)
    said = "; ".join(f"{listed(names)} ({what})" for what, names in parts.items())
    return f" Failed: {said}; reasons stand in the table Failures." if said else ""


def _averaged(cohort: Cohort) -> str:
    """Say whose beats were averaged, and whose cycle was given as it is."""
    raw = [result for result in cohort.results if "beats" in result.children]
    given = named([result for result in cohort.results if "beats" not in result.children])
    if not raw:
        return f"One averaged cycle of pressure and flow{'' if cohort.single else ' per animal'} was given"
    counts = sorted({int(data_of(result, "beats")["kept"].sum()) for result in raw})
    beats = " to ".join(str(count) for count in dict.fromkeys((counts[0], counts[-1])))
    marks = {str(data_of(result, "beats").attrs.get("fiducial", "")) for result in raw}
    aligned = listed(sorted(_FIDUCIALS.get(mark, mark) for mark in marks))
    whose = f" of {named(raw)}" if given else ""
    words = f"Pressure and flow{whose} were averaged over {beats} beats (rejected ones left out), aligned at {aligned}"
    return f"{words}; of {given} an averaged cycle was given" if given else words


def _model(cohort: Cohort) -> str:
    networks = [network(result) for result in cohort.shown.values()]
    sizes = listed([str(size) for size in sorted({len(one) for one in networks})])
    lengths = np.array([one.length.sum() for one in networks])
    return (
        f"One-dimensional flow (eq. 2) was solved in {'a network' if cohort.single else 'networks'} of {sizes} vessels "
        f"({span(lengths)} cm in all), with {listed([_law(cohort, wall) for wall in cohort.walls])}, continuity of "
        "pressure and flow at junctions (eq. 6) and three-element Windkessels (eq. 7); the measured flow was the "
        f"inflow.{_blood(cohort)}{_numerics(cohort)}"
    )


def _law(cohort: Cohort, wall: str) -> str:
    """Return a wall law in words: ``the linear wall law (linear elastic, p = …, eq. 3)``."""
    law = cohort.law(wall)
    equation = f"eq. {law.equation}" if law.equation[:1].isdigit() else law.equation
    said = ", ".join(filter(None, (law.title if law.title != wall else "", law.formula, equation)))
    return f"the {wall} wall law" + (f" ({said})" if said else "")


def _blood(cohort: Cohort) -> str:
    blood = cohort.settings.get("blood")
    if not isinstance(blood, dict):
        return ""
    friction = dict(blood.get("friction", {}))
    layers = np.array([boundary_layer(float(blood["viscosity"]), period(result)) for result in cohort.results])
    return (
        f" Blood had density {blood['density']} g/ml and kinematic viscosity {blood['viscosity']} cm²/s (boundary "
        f"layer {span(layers)} cm); friction was that of {friction_words(friction.pop('law', ''), friction)}."
    )


def _numerics(cohort: Cohort) -> str:
    attrs = [data_of(result, f"{wall}/simulation").attrs for result in cohort.results for wall in wall_laws(result)]
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
    shared = cohort.settings
    search = _SEARCHES.get(str(shared.get("method")), str(shared.get("method", "")))
    starts = sorted({int(fit.sizes["start"]) for wall in cohort.walls for fit in cohort.calibrations(wall)})
    bounds = "the bounds of Qureshi et al." if shared.get("paper_bounds") else "wide bounds (table of bounds)"
    own = f", own bounds for {listed(list(shared['bounds']))}" if shared.get("bounds") else ""
    held = ", ".join(f"{name} = {value}" for name, value in (shared.get("fixed") or {}).items())
    free = "; ".join(f"{wall}: {_free(cohort, wall)}" for wall in cohort.walls)
    return (
        "The sum S of squared differences between measured and simulated waveforms at the inlet (eq. 14) was minimized "
        f"by {search} from {listed([str(count) for count in starts])} starts (seed {shared.get('seed', '–')}) within "
        f"{bounds}{own}, over {free}. R1 = r1·R1⁰, R2 = r2·R2⁰ and C = c1·C⁰ in all vascular beds."
        f"{f' Held fixed: {held}.' if held else ''} Intervals follow from the Jacobian at the optimum and allow for "
        "all spectra that the noise may have after what the residual shows; they take image, wall law and zero of the "
        "pressure as exact."
    )


def _free(cohort: Cohort, wall: str) -> str:
    fit, written = cohort.calibrations(wall)[0], symbols(cohort)
    names = map(str, fit["parameter"].values[fit["free"].values.astype(bool)])
    return ", ".join(written.get(name, name) for name in names)


def _analyses() -> str:
    return (
        "Waves were separated and their time-normalized intensity computed without smoothing (eqs. 15, 16); I_R is the "
        "ratio of the ranges of the backward and the forward pressure wave over the cycle (eq. 17). Impedance spectra "
        "came from Fourier series (eqs. 18, 19), harmonics whose flow was near the noise level were marked. "
        "Compliances were taken at diastolic pressure, C_v by the published series/parallel rule and as plain sum "
        "(eqs. 25 to 30), wave speeds at mean pressure (eqs. 31, 32)."
    )


def _primary(primary: Primary) -> list[str]:
    if not len(primary.rows):
        return []
    written = listed(list(dict.fromkeys(primary.rows["quantity"].astype(str))))
    law = f" of the {primary.law} wall law and of the recordings" if primary.law else ""
    drawn = listed(list(primary.rows["quantity"][primary.rows["estimates"] == "posterior"].unique()))
    of_draws = (
        f"; of {drawn} those of their posteriors, the error of a shared image added to the ratio's" if drawn else ""
    )
    return [
        f"Primary, and declared before, was one family of quantities{law}: {written}. Groups were compared by ratios "
        "on "
        "logarithms: within each group the animals were pooled by random effects (restricted maximum likelihood; "
        "weights "
        f"from the standard errors of their estimates{of_draws}), standard errors after Hartung and Knapp, not below "
        "those of the errors alone, with Satterthwaite's degrees of freedom; quantities without standard errors so "
        "have Welch's. p values and 95 % intervals are simultaneous, for all quantities and pairs of groups, from "
        "one reference distribution: a parametric fast double bootstrap of the least p, with each group's own spreads "
        f"and the quantities' correlation within animals ({DRAWS + 1} draws).{_not_tested(primary)}"
    ]


def _not_tested(primary: Primary) -> str:
    rows = primary.rows[primary.rows["untested"] != ""]
    if not len(rows):
        return ""
    names = listed(list(dict.fromkeys(rows["quantity"].astype(str))))
    return (
        f" No p is given for {names}: animals of a group have one image, which fits take as exact, so that their "
        "intervals do not contain its error."
    )


def _statistics(cohort: Cohort, comparisons: Mapping[str, Comparison]) -> str:
    counts = {source: len(one.contrasts) for source, one in comparisons.items()}
    tests = "; ".join(f"{source}: {count} tests" for source, count in counts.items() if count)
    if not tests:
        return "Groups are described by mean, SD, median and quartiles; nothing was compared."
    several = " More than two groups were compared by a permutation Kruskal-Wallis test first."
    return (
        "Secondary: as in the paper, groups were also compared by two-sided Mann-Whitney tests (exact up to "
        f"{MOST_EXACT} animals, beyond that by the normal distribution), p values adjusted by "
        "Holm's method within each "
        f"source ({tests}), ratios of geometric means with Welch intervals, and Hedges' g with intervals from the "
        f"noncentral t distribution; the importance index η (eq. 20) is relative to {cohort.reference}."
        f"{several if len(cohort.groups) > 2 else ''} Every ratio was computed again without each animal in turn where "
        "groups had three animals or more."
    )
