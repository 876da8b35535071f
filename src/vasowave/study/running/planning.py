"""The number of animals that a study needs, from a study's own spreads and errors or from the published ones."""

from pathlib import Path
from typing import Any

import numpy as np

from vasowave.base.settings import given_values
from vasowave.pulse.examples.published import published_table
from vasowave.study.cohort.planning import Plan, plan_of, spreads_of, with_occasions
from vasowave.study.cohort.power import Planning, Spread
from vasowave.study.results.results import Results, read_results


def plan(study: str | Path | Results | None = None, **settings: Any) -> Plan:
    """Return how many animals of each of two groups show an effect.

    Parameters
    ----------
    study : str, Path or Results, optional
        A study that was run, for instance a pilot: spreads, errors and shared images of its first two groups, of each
        subject the first recording, and how far its recordings differ. Without it those of the published mice, of which
        errors are not known apart.
    settings
        Those of `Planning` by name: ``effect=1.5, power=0.8, occasions=1``; ``pairs=0.5`` for pairs, with
        ``littermates=True`` of littermates.

    Raises
    ------
    InputError
        There are no results, or no two groups in them that can be compared.

    Examples
    --------
    >>> import vasowave as vw
    >>> found = vw.plan(effect=1.5)
    >>> bool(found.powers["mPAP"].is_monotonic_increasing)
    True
    """
    planning = given_values(Planning, None, settings)
    if study is None:
        spreads, correlation = published_spreads()
        return plan_of(spreads, correlation, "the published mice", planning)
    results = study if isinstance(study, Results) else read_results(study)
    subject = next(
        (variable.levels for variable in results.variables if variable.name == results.settings.design.subject), {}
    )
    first = {subject.get(result.name, result.name): result for result in reversed(results.in_order(whole=False))}
    cohort = results.gathered([*reversed(first.values())], results.settings.groups[0])
    spreads, correlation = spreads_of(cohort, results.settings.report)
    if subject:
        everything = results.gathered(results.in_order(whole=False), results.settings.groups[0])
        spreads = with_occasions(spreads, everything, results.settings.report)
    return plan_of(spreads, correlation, results.settings.title, planning)


def published_spreads() -> tuple[list[Spread], np.ndarray]:
    """Return the spreads of the published animals, mice with and without hypoxia, and their correlation."""
    index = published_table("hemodynamics").set_index("quantity")
    spreads = []
    for name in ("mPAP", "CO"):
        row = index.loc[name].drop("unit").astype(float)
        shares = [row[f"{group} SD"] / row[f"{group} mean"] for group in ("CTL", "HPH")]
        low, high = (float(np.sqrt(np.log1p(share**2))) for share in shares)
        spreads.append(Spread(name, (low, high)))
    table = published_table("optimized_linear")
    for name, label in (("stiffness", "beta [mmHg]"), ("R_T", "R_T [mmHg s/ml]"), ("a", "a")):
        groups = [np.log(table.loc[table["group"] == group, label].to_numpy(float)) for group in ("CTL", "HPH")]
        spreads.append(Spread(name, (float(groups[0].std(ddof=1)), float(groups[1].std(ddof=1)))))
    return spreads, np.eye(len(spreads))
