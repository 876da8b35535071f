"""The methods in words, ready to paste, with the settings that were used."""

from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import pairwise
from operator import attrgetter

import numpy as np

from vasowave.pulse.inference.known_errors import kinds
from vasowave.pulse.model.blood import boundary_layer
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.cohort.comparison import SourceComparison
from vasowave.study.cohort.declared import AnimalChanges, Declaration
from vasowave.study.cohort.effects import Effect, grouped
from vasowave.study.cohort.primary import Primary
from vasowave.study.cohort.simultaneous_intervals import DRAWS
from vasowave.study.cohort.two_groups import MAX_EXACT_ANIMALS
from vasowave.study.report.answer.design import design_text
from vasowave.study.report.answer.effects import labels
from vasowave.study.report.blocks import Paragraph, Section
from vasowave.study.report.terms import symbol
from vasowave.study.report.wording import (
    ERROR_OF_DRAWS,
    LIMIT,
    friction_words,
    listed,
    named,
    number,
    some_of,
    span,
    symbols,
)

_NAMED = 6  # animals, in a sentence
_FIDUCIALS = {"ecg": "the R wave of the ECG", "pressure": "the foot of the pressure"}
_SEARCHES = {"least-squares": "bounded least squares (trust region)", "sqp": "sequential quadratic programming"}
_ANALYSES = (
    "Waves were separated and their time-normalized intensity computed without smoothing (eqs. 15, 16); I_R is the "
    "ratio of the ranges of the backward and the forward pressure wave over the cycle (eq. 17). Impedance spectra "
    "came from Fourier series (eqs. 18, 19), harmonics whose flow was near the noise level were marked. "
    "Compliances were taken at diastolic pressure, C_v by the published series/parallel rule and as plain sum "
    "(eqs. 25 to 30), wave speeds at mean pressure (eqs. 31, 32)."
)


def methods_section(cohort: Cohort, primary: Primary, comparisons: Mapping[str, SourceComparison]) -> Section:
    """Return the paragraphs on data, model, calibration, analyses and statistics."""
    texts = [_data(cohort)]
    if cohort.walls:
        texts += [_model(cohort), _calibration(cohort), *_posteriors(cohort)]
    texts.append(_ANALYSES)
    if not cohort.single:
        texts += [*_primary(cohort, primary, symbols(cohort)), _statistics(cohort, comparisons)]
    return Section("methods", "Methods", [Paragraph(text) for text in texts])


def _data(cohort: Cohort) -> str:
    whose = "one animal" if cohort.single else f"{_counted(cohort)} animals"
    version = cohort.results[0].origin.get("vasowave", "")
    return (
        f"Pressure and flow in the main pulmonary artery of {whose} were analyzed with vasowave "
        f"{version}.{_failed(cohort)} {_averaged(cohort)}.{_drifts(cohort)} Nominal parameters came "
        f"from {'the' if cohort.single else 'each'} recording: Z_c by the up-slope method (eq. 8), wall stiffness from "
        "Z_c (eqs. 9, 10), the time constant from the diastolic decay (eq. 12), resistances and compliances of the "
        "beds by the flow division of Poiseuille's law (eqs. 11, 13)."
    )


def _counted(cohort: Cohort) -> str:
    """Return how many animals of each group were analyzed, and of how many, where some were lost: ``3 of 4 HPH``."""
    lost = Counter(failure.group for failure in cohort.lost)
    counts = {group: len(cohort.groups.get(group, [])) for group in (*cohort.groups, *lost)}
    if cohort.repeated:  # an animal of which one recording was lost is there all the same
        subjects = {
            group: {cohort.subjects[result.name] for result in cohort.groups.get(group, [])} for group in counts
        }
        return listed([f"{len(subjects[group])} {group} ({n} recordings)" for group, n in counts.items()])
    return listed(
        [f"{n} of {n + lost[group]} {group}" if lost[group] else f"{n} {group}" for group, n in counts.items()]
    )


def _failed(cohort: Cohort) -> str:
    """Name every animal that was lost, and every law, posterior or comparison that an animal lacks."""
    failures = grouped(cohort.failures, attrgetter("scope"))
    text = "; ".join(f"{listed([failure.animal for failure in alike])} ({scope})" for scope, alike in failures.items())
    return f" Failed: {text}; reasons stand in the table Failures." if text else ""


def _averaged(cohort: Cohort) -> str:
    """Say whose beats were averaged, and whose cycle was given as it is."""
    raw = {result.name: result.beats for result in cohort.results if result.beats is not None}
    given_names = named([result for result in cohort.results if result.beats is None])
    if not raw:
        return f"One averaged cycle of pressure and flow{'' if cohort.single else ' per animal'} was given"
    counts = sorted({int(beats["kept"].sum()) for beats in raw.values()})
    count = " to ".join(str(limit) for limit in dict.fromkeys((counts[0], counts[-1])))
    marks = {str(beats.attrs.get("fiducial", "")) for beats in raw.values()}
    aligned = listed(sorted(_FIDUCIALS.get(mark, mark) for mark in marks))
    whose = f" of {', '.join(raw)}" if given_names else ""
    words = f"Pressure and flow{whose} were averaged over {count} beats (rejected ones left out), aligned at {aligned}"
    return f"{words}; of {given_names} an averaged cycle was given" if given_names else words


def _drifts(cohort: Cohort) -> str:
    """Say of how many recordings a drift of the pressure was removed, and how large it was."""
    beats = [result.beats for result in cohort.results if result.beats is not None]
    removed = [abs(float(record.attrs["drift_size"])) for record in beats if record.attrs.get("drift_removed")]
    if not removed:
        return ""
    scope, size = "" if cohort.single else f" of {len(removed)} of {len(beats)} recordings", span(np.array(removed), 2)
    return f" The drift of the diastolic pressure{scope} was removed ({size} mmHg over a recording)."


def _model(cohort: Cohort) -> str:
    networks = [result.network for result in cohort.shown.values()]
    sizes = listed([str(size) for size in sorted({len(network) for network in networks})])
    lengths = np.array([network.length.sum() for network in networks])
    return (
        f"One-dimensional flow (eq. 2) was solved in {'a network' if cohort.single else 'networks'} of {sizes} vessels "
        f"({span(lengths)} cm in all), with {listed([_law(cohort, wall) for wall in cohort.walls])}, continuity of "
        f"pressure and flow at junctions (eq. 6) and {_beds(cohort)}; {_entered(cohort)}."
        f"{_blood(cohort)}{_numerics(cohort)}"
    )


_ENTERED = {
    "flow": "the measured flow was the inflow",
    "pressure": "the measured pressure entered at the inlet, and the flow was compared",
    "both": "the measured flow was the inflow, and the error of the flow counts beside that of the pressure",
}


def _entered(cohort: Cohort) -> str:
    enters = {str(fit.attrs.get("enters", "flow")) for wall in cohort.walls for fit in cohort.calibrations(wall)}
    return listed([_ENTERED[label] for label in sorted(enters)] or [_ENTERED["flow"]])


def _law(cohort: Cohort, wall: str) -> str:
    """Return a wall law in words: ``the linear wall law (linear elastic, p = …, eq. 3)``."""
    law = cohort.law(wall)
    equation = f"eq. {law.equation}" if law.equation[:1].isdigit() else law.equation
    details = ", ".join(filter(None, (law.title if law.title != wall else "", law.formula, equation)))
    return f"the {wall} wall law" + (f" ({details})" if details else "")


def _beds(cohort: Cohort) -> str:
    """Return the vascular beds in words: ``three-element Windkessels (eq. 7)``."""
    equation = _of_beds(cohort, "equation")
    return f"{_of_beds(cohort, 'title')} ({f'eq. {equation}' if equation else _of_beds(cohort, 'formula')})"


def _of_beds(cohort: Cohort, attribute: str) -> str:
    """Return what is stored of the vascular beds: their title, formula, equation, or factors."""
    return next((str(fit.attrs[f"bed_{attribute}"]) for wall in cohort.walls for fit in cohort.calibrations(wall)), "")


def _blood(cohort: Cohort) -> str:
    blood = cohort.settings.get("blood")
    if not isinstance(blood, dict):
        return ""
    friction = dict(blood.get("friction", {}))
    layers = np.array([boundary_layer(float(blood["viscosity"]), result.period) for result in cohort.results])
    return (
        f" Blood had density {number(blood['density'], 4)} g/ml and kinematic viscosity "
        f"{number(blood['viscosity'])} cm²/s (boundary "
        f"layer {span(layers)} cm); friction was that of {friction_words(friction.pop('law', ''), friction)}."
    )


def _numerics(cohort: Cohort) -> str:
    attrs = [result.laws[wall].simulation.attrs for result in cohort.results for wall in result.laws]
    if not attrs or not all({"courant", "cell_size", "converged", "cycles"} <= set(simulation) for simulation in attrs):
        return ""
    periodic = sum(bool(simulation["converged"]) for simulation in attrs)
    courant, cell = (max(float(simulation[key]) for simulation in attrs) for key in ("courant", "cell_size"))
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
    bounds_note = f", own bounds for {listed(list(shared['bounds']))}" if shared.get("bounds") else ""
    held = ", ".join(f"{name} = {number(value)}" for name, value in (shared.get("fixed") or {}).items())
    free = "; ".join(f"{wall}: {_free(cohort, wall)}" for wall in cohort.walls)
    return (
        "The sum S of squared differences between measured and simulated waveforms at the inlet (eq. 14) was minimized "
        f"by {search} from {listed([str(count) for count in starts])} starts (seed {shared.get('seed', '–')}) within "
        f"{bounds}{bounds_note}, over {free}. {listed(_of_beds(cohort, 'factors').split(', '))} in all vascular beds."
        f"{f' Held fixed: {held}.' if held else ''} Intervals follow from the Jacobian at the optimum and allow for "
        "all spectra that the noise may have after what the residual shows, and for the errors of image, probe, zero "
        "and wall that stand under What is not known, to first order; they take the wall law as exact."
    )


def _posteriors(cohort: Cohort) -> list[str]:
    """Say how posteriors were made, where there are any."""
    drawn = [law.posterior for result in cohort.results for law in result.laws.values() if law.posterior is not None]
    if not drawn:
        return []
    trusted = sum(posterior.trusted for posterior in drawn)
    differ = "zero_sd" in cohort.differing_settings
    zero = "" if differ else f" (SD {cohort.settings.get('zero_sd', kinds()['zero'].usual):g} mmHg)"
    counts = [float(posterior.table["simulations"]) for posterior in drawn if "simulations" in posterior.table]
    ends = dict.fromkeys(f"{count:.0f}" for count in (min(counts), max(counts))) if counts else ()
    cost = f", with {' to '.join(ends)} simulations each" if counts else ""
    evidence = (
        " An evidence is the probability density of the measured harmonics, all that is unknown integrated out."
        if any(result.evidence is not None for result in cohort.results)
        else ""
    )
    return [
        f"Posteriors, {len(drawn)} of an animal and a wall law each, took as unknown the parameters, all radii and "
        "lengths, how stiffness changes with the radius, the zero of the pressure"
        f"{zero} and the model's own error. Modes were searched from several "
        f"starts, drawn from through an emulator and reweighted by the model itself{cost}; {trusted} passed the checks "
        f"of the reweighting and of two independent halves.{evidence}"
    ]


def _free(cohort: Cohort, wall: str) -> str:
    fit, written = cohort.calibrations(wall)[0], symbols(cohort)
    names = map(str, fit["parameter"].values[fit["free"].values.astype(bool)])
    return ", ".join(written.get(name, name) for name in names)


def _primary(cohort: Cohort, primary: Primary, written: Mapping[str, str]) -> list[str]:
    effects = primary.effects
    if not effects:
        return []
    family = _quantities(effects, written)
    law = f" of the {primary.law} wall law and of the recordings" if primary.law else ""
    drawn = _quantities([effect for effect in effects if effect.origin == "posterior"], written)
    of_draws = (
        f"; of {drawn} those of their posteriors, the error of a shared image added to the ratio's" if drawn else ""
    )
    declared = (
        "Primary was the one family of quantities that the settings name (vasowave's own where the study file leaves "
        f"them){law}: {family}.{_declared(cohort)}"
    )
    if not cohort.design.plain:
        return [f"{declared} {_by_design(cohort, primary, of_draws)}{_not_tested(primary, written)}"]
    return [
        f"{declared} Groups were compared by ratios on logarithms: within each group the animals were pooled by random "
        "effects (restricted maximum likelihood; weights from the standard errors of their estimates"
        f"{of_draws}), standard errors after Hartung and Knapp, not below "
        "those of the errors alone, with Satterthwaite's degrees of freedom; quantities without standard errors so "
        "have Welch's. p values and 95 % intervals are simultaneous, for all quantities and pairs of groups, from "
        "one reference distribution: a parametric fast double bootstrap of the least p, with each group's own spreads "
        f"and the quantities' correlation within animals ({_draws(2)}).{_not_tested(primary, written)}"
    ]


def _declared(cohort: Cohort) -> str:
    """Say when the family was declared, and what was changed since."""
    if not cohort.declared:
        return ""
    first, *later = cohort.declared
    subject = (
        "Groups, family, law, design and animals" if "animals" in first.content else "Groups, family, law and design"
    )
    text = f" {subject} were declared on {first.time}{_when(first)}."
    for before, after in pairwise(cohort.declared):
        if first_said := after.first_said(before):
            text += f" Declared first on {after.time}{_when(after)}: {listed(first_said)}."
        if changed := after.changes(before):
            old, new = (listed([*words.content.get("reference", {}).values()]) for words in (before, after))
            detail = {
                "animals": f" ({_of_rows(after.rows(before))})",
                "reference": f" ({old or 'none'} → {new or 'none'})",
            }
            text += (
                f" Changed on {after.time}{_when(after)}: {listed([name + detail.get(name, '') for name in changed])}."
            )
    text += "" if later else " They were not changed since."
    if "animals" not in cohort.declared[-1].content:
        text += " Which animals belonged to which group, and their cells of the design's columns, were not declared."
    return text


def _of_rows(rows: AnimalChanges) -> str:
    """Say which animals were added, dropped or changed."""
    cells = [f"{animal}, {column} {old or 'empty'} → {new or 'empty'}" for animal, column, old, new in rows.changed]
    changes = {"added": rows.added, "dropped": rows.dropped, "changed": cells}
    return "; ".join(f"{kind}: {some_of([*names], _NAMED)}" for kind, names in changes.items() if names)


def _when(declaration: Declaration) -> str:
    return ", when results were there already" if declaration.seen else ", before there were results"


def _by_design(cohort: Cohort, primary: Primary, of_draws: str) -> str:
    return (
        f"The design: {design_text(cohort)} Each quantity's logarithms followed one linear mixed model, with the "
        f"animals' known errors (standard errors of their estimates{of_draws}), a variance between animals for each "
        "group or cell of groups and second factor that no animal links with others (one for all where a cell has "
        "fewer than three recordings), and a variance for each block, for subjects and, of three times or more, for "
        "what recordings of a subject share the more the nearer they are in time; variances by restricted maximum "
        "likelihood, standard errors and degrees of freedom after Kenward and Roger. Covariates enter as main effects, "
        "and cells are compared at their average. "
        "p values and 95 % intervals are simultaneous for all quantities and effects "
        f"({listed(labels(primary.effects))}): the least p was "
        "compared with that of draws from the joint distribution of the estimates, with the correlation of the "
        f"quantities within animals ({_draws()})."
    )


def _draws(stages: int = 1) -> str:
    """Return how many draws a p is of, and how exact it is by that; draws of draws (`stages`) add their error."""
    error = float(np.sqrt(stages)) * ERROR_OF_DRAWS
    return (
        f"{DRAWS} draws and the data; a p near {LIMIT} has a standard error of {error:.3f} by that, and stands with ≈ "
        f"within {2 * ERROR_OF_DRAWS:.3f} of {LIMIT}"
    )


def _quantities(effects: Sequence[Effect], written: Mapping[str, str]) -> str:
    """Return the symbols of the quantities of some effects, each once."""
    return listed([symbol(name, written) for name in dict.fromkeys(effect.quantity for effect in effects)])


def _not_tested(primary: Primary, written: Mapping[str, str]) -> str:
    untested = [effect for effect in primary.effects if effect.untested]
    if not untested:
        return ""
    return (
        f" No p is given for {_quantities(untested, written)}: animals of a group have one image, which fits take as "
        "exact, so that their intervals do not contain its error."
    )


def _statistics(cohort: Cohort, comparisons: Mapping[str, SourceComparison]) -> str:
    if cohort.repeated:
        return (
            "Groups are described by mean, SD, median and quartiles of all recordings. The paper's tests and "
            "importance indices are not made, since they take every recording for an animal of its own."
        )
    counts = {source: len(comparison.contrasts) for source, comparison in comparisons.items()}
    tests = "; ".join(f"{source}: {count} tests" for source, count in counts.items() if count)
    if not tests:
        return "Groups are described by mean, SD, median and quartiles; nothing was compared."
    return (
        "Secondary: as in the paper, groups were also compared by two-sided Mann-Whitney tests (exact up to "
        f"{MAX_EXACT_ANIMALS} animals, beyond that by the normal distribution), p values adjusted by Holm's method "
        f"within each source ({tests}), ratios of geometric means with Welch intervals, and Hedges' g with intervals "
        f"from the noncentral t distribution; the importance index η (eq. 20) is relative to {cohort.reference}. Every "
        "ratio was computed again without each animal in turn where groups had three animals or more."
    )
