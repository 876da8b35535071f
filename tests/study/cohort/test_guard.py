"""What few animals do not show, and columns that no design names: against tests by SciPy of cohorts drawn here."""

import numpy as np
import pytest
from scipy import stats

from vasowave.study.cohort import (
    RULES,
    Design,
    PopulationShape,
    Variable,
    doubts_of,
    laid_out,
    rate_of_blocks,
    unused_columns,
)

GROUPS = {"CTL": 7, "HPH": 5}


def columns(sizes, **cells):
    members = {f"{group} {number}": group for group, size in sizes.items() for number in range(1, 1 + size)}
    return members, {name: Variable.from_cells(name, dict(zip(members, map(str, column), strict=True)))
                     for name, column in cells.items()}  # fmt: skip


def layout(sizes, design=Design(), **cells):  # noqa: B008
    members, variables = columns(sizes, **cells)
    return laid_out(design, variables, members, [*sizes])


def doubts(*given):
    return {doubt.shape: doubt for doubt in doubts_of(*given)}


def welch(first, second):
    """Return the false positives of Welch's test, by SciPy."""
    return float(np.mean(stats.ttest_ind(first, second, axis=1, equal_var=False).pvalue < 0.05))


@pytest.mark.parametrize("sizes", [(7, 5), (5, 5), (12, 12), (12, 4)])
def test_rates_of_two_groups_are_those_of_welchs_test(sizes):
    found = doubts(layout(dict(zip(GROUPS, sizes, strict=True))), 1)
    rng = np.random.default_rng(5)
    first = rng.exponential(size=(20_000, sizes[0])) - 1
    for ratio, rate in zip(RULES.spread_ratios, found[PopulationShape.SKEWED].rates, strict=True):
        assert rate == pytest.approx(welch(first, ratio * (rng.exponential(size=(20_000, sizes[1])) - 1)), abs=0.022)
    assert found[PopulationShape.SKEWED].cells == ("HPH",)
    respond = rng.standard_normal((20_000, sizes[1])) + RULES.shift * (rng.random((20_000, sizes[1])) < RULES.respond)
    rate = welch(rng.standard_normal((20_000, sizes[0])), respond - RULES.shift * RULES.respond)
    responders = found.get(PopulationShape.RESPONDERS)
    assert (responders.rates[0] if responders else RULES.tolerable) == pytest.approx(rate, abs=0.022)


def test_a_smaller_group_that_varies_more_is_worse_whichever_it_is_and_many_animals_show_their_shape():
    assert doubts(layout({"CTL": 4, "HPH": 12}), 1)[PopulationShape.SKEWED].cells == ("CTL",)
    assert doubts_of(layout({"CTL": 40, "HPH": 40}), 1) == ()


def test_a_design_with_a_covariate_is_doubted_as_one_without():
    plain = doubts(layout({"CTL": 7, "HPH": 4}), 3)[PopulationShape.SKEWED].rates[-1]
    sex = doubts(layout({"CTL": 7, "HPH": 4}, Design(covariates=("sex",)), sex="fmfmfmffmfm"), 3)[
        PopulationShape.SKEWED
    ].rates[-1]
    assert plain > 0.12
    assert sex > 0.12


def test_litters_that_a_design_does_not_name_are_counted_as_welchs_test_counts_them():
    rng, litter = np.random.default_rng(6), np.repeat(np.arange(6), 4)
    share = np.sqrt(RULES.block_share)
    values = share * rng.standard_normal((20_000, 6))[:, litter]
    values += np.sqrt(1 - RULES.block_share) * rng.standard_normal((20_000, 24))
    rate = rate_of_blocks(layout({"CTL": 12, "HPH": 12}), [f"L{one}" for one in litter], 1)
    assert rate == pytest.approx(welch(values[:, :12], values[:, 12:]), abs=0.02)
    across = [f"L{number % 6}" for number in range(24)]
    assert rate_of_blocks(layout({"CTL": 12, "HPH": 12}), across, 1) < 0.05
    named = layout({"CTL": 12, "HPH": 12}, Design(blocks=("litter",)), litter=[f"L{one}" for one in litter])
    assert rate_of_blocks(named, [f"L{one}" for one in litter], 1) < 0.08


@pytest.mark.parametrize(
    ("cells", "code", "words"),
    [
        ({"litter": "AAAABBBCCCDD"}, "design.unit-unused", "7 CTL from 2 (A, B), 5 HPH from 2 others (C, D)"),
        ({"Wurf": [1, 1, 1, 1, 2, 2, 2, 3, 3, 3, 4, 4]}, "design.unit-unused", "name it under blocks"),
        ({"cage": "AAAAAAABCDEF"}, "design.unit-confounded", "7 CTL from 1 (A), 5 HPH from 5 others"),
        ({"colony": "AAAABBBCCCDD"}, "design.unit-unused", "colony"),  # no word of a title, but units by its cells
        ({"litter": "AAAAAAABBBBB"}, "design.column-is-group", "all CTL are A, all HPH are B"),
        ({"operator": ["Ann"] * 7 + ["Bob"] * 5}, "design.column-is-group", "all CTL are Ann"),
        ({"Geschlecht": "wwwwwwwmmmmm"}, "design.column-is-group", "no analysis can tell"),
        ({"sex": "fffffmmmmmmf"}, "design.column-unequal", "CTL: 5 f, 2 m; HPH: 4 m, 1 f"),
        ({"weight": [24, 25, 23, 22, 24, 26, 25, 20, 21, 23, 20, 22]}, "design.column-unequal", "CTL: 22 to 26"),
        ({"date": [f"2024-01-{1 + day:02d}" for day in range(12)]}, "design.column-is-group", "2024-01-07; HPH"),
        ({"mouse": [1, 2, 3, 4, 5, 6, 7, 1, 2, 3, 4, 5]}, "design.subject-unused", "'1' in CTL 1, HPH 1"),
    ],
)  # fmt: skip
def test_a_column_that_looks_like_units_or_a_confounder_is_told_against_the_groups(cells, code, words):
    members, variables = columns(GROUPS, **cells)
    (found,) = unused_columns(variables, Design(), members, [*GROUPS])
    assert found.code == code
    assert words in str(found)
    assert found.place.part == f"column '{next(iter(cells))}'"


@pytest.mark.parametrize(
    "cells",
    [
        {"litter": "ABCDEFGABCDE"},
        {"litter": "ABABABAABABA"},
        {"cage": "ABCDEFGHIJKL"},
        {"cage": range(12)},
        {"sex": "fmfmfmffmfmf"},
        {"weight": [24, 21, 23, 22, 24, 20, 25, 21, 22, 23, 20, 24]},
        {"mouse": range(12)},
        {"comment": ["x", "y"] * 6, "tail length": range(12)},
        {"sex": "f" * 12},
    ],
)  # fmt: skip
def test_a_column_that_is_alike_in_the_groups_or_a_name_of_each_animal_is_no_finding(cells):
    members, variables = columns(GROUPS, **cells)
    assert unused_columns(variables, Design(), members, [*GROUPS]) == []


def test_a_column_that_the_design_names_is_no_finding_and_an_animal_counts_once():
    members, variables = columns({"CTL": 8, "HPH": 8}, litter="AAAABBBBCCCCDDDD", mouse=[*"aabbccddeeffgghh"],
                                 time=["before", "after"] * 8, sex="ffffffmmffmmmmmm")  # fmt: skip
    design = Design(subject="mouse", occasion="time", blocks=("litter",), covariates=("sex",))
    assert unused_columns(variables, design, members, ["CTL", "HPH"]) == []
    (found,) = unused_columns(variables, Design(subject="mouse", occasion="time", blocks=("litter",)), members,
                              ["CTL", "HPH"])  # fmt: skip
    assert "CTL: 3 f, 1 m; HPH: 1 f, 3 m" in str(found)
