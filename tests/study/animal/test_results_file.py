"""What a stored file holds is what docs/results-file.md says, and all of it comes back."""

import os
from dataclasses import replace
from pathlib import Path

import pytest
import xarray as xr

import vasowave
from made_cohort import made_results
from made_posterior import made_posterior
from vasowave.base import InputError
from vasowave.pulse.examples import control_network, virtual_mouse
from vasowave.pulse.inference import compare_laws
from vasowave.study.animal import (
    AnimalResult,
    check_law_names,
    network_dataset,
    posterior_result,
    read_result,
    stored_law,
    write_result,
)
from vasowave.study.cohort import gathered, primary_comparison

PAGE = Path(__file__).parents[3] / "docs" / "results-file.md"
ABOUT = """\
# The file of a result

One animal's result is one netCDF-4 file: `AnimalResult.to_datatree()`, group by group; [results](results.md) says how
to read it. Here is every group with its attributes and variables. `WALL` is the name of a wall law; the parameters are
those of the power law, other laws have theirs in place of `beta` and `m`. `WALL/inference` holds besides the groups
that ArviZ reads: `posterior`, `prior`, `sample_stats`, `posterior_predictive`, `log_likelihood` and `observed_data`.
Where such a posterior may be believed, `WALL/tree` has the ends of 95 % intervals of loads, `mean_shear_low` to
`pulse_power_high`. A test compares this page with a stored file.
"""


@pytest.fixture(scope="module")
def result():
    """Return an animal with everything that can be stored."""
    (one,) = made_results({"CTL": 1}, raw=1, walls=("linear", "power"), selection=True)
    posteriors = [made_posterior(wall, number, 200.0) for number, wall in enumerate(one.laws)]
    site = vasowave.Observation("flow", "2", 0.01, mean=0.04)
    sites = vasowave.calibrate(control_network(), virtual_mouse(), starts=1, sites=[site]).sites
    power = replace(one.laws["power"], posterior=posterior_result(posteriors[1]), sites=sites)
    taper = 0.01 * control_network().radius
    known = replace(one.network, radius_sd=taper, taper=taper, taper_sd=taper)
    laws = {"linear": one.laws["linear"], "power": power}
    return replace(one, network=known, laws=laws, evidence=compare_laws(posteriors))


@pytest.fixture(scope="module")
def stored(result, tmp_path_factory):
    path = tmp_path_factory.mktemp("stored") / "animal.nc"
    write_result(result, path)
    with xr.open_datatree(path, decode_timedelta=False) as tree:
        return tree.load()


def described(tree):
    """Return the page of a stored tree."""
    lines = [ABOUT]
    for node in tree.subtree:
        path = node.path.strip("/").replace("power", "WALL")
        if path.startswith("linear") or path.startswith("WALL/inference/") or not (node.attrs or node.variables):
            continue
        lines.append(f"## {path or 'The file itself'}\n")
        attrs = sorted(str(name) for name in node.attrs if path or name not in vasowave_programs(tree))
        if attrs:
            lines.append(f"Attributes: {', '.join(f'`{name}`' for name in attrs)}.\n")
        data = node.to_dataset(inherit=False)
        if data.variables:
            lines.append("| variable | along | unit | meaning |\n|---|---|---|---|")
            rows = [
                f"| `{name}` | {', '.join(map(str, one.dims))} | {one.attrs.get('units', '')} "
                f"| {one.attrs.get('long_name', '')} |"
                for name, one in sorted(data.variables.items(), key=lambda item: str(item[0]))
            ]
            lines.append("\n".join(rows) + "\n")
    return "\n".join(lines).rstrip() + "\n"


def vasowave_programs(tree):
    """Return the attributes that name versions, which differ from machine to machine."""
    own = (
        "title",
        "Conventions",
        "animal",
        "group",
        "synthetic",
        "interrupted",
        "noticed",
        "assumed_errors",
        "findings",
        "failures",
        "settings",
    )
    return [name for name in tree.attrs if name not in own]


def test_approved_the_page_describes_every_variable_of_a_stored_file(stored):
    page = described(stored)
    if os.environ.get("VASOWAVE_APPROVE"):
        PAGE.write_text(page, encoding="utf-8")
    assert PAGE.read_text(encoding="utf-8") == page, "VASOWAVE_APPROVE=1 uv run pytest -n 0 -k approved"


def test_everything_comes_back_from_the_file_as_it_was(result, tmp_path):
    write_result(result, tmp_path / "a.nc")
    back = read_result(tmp_path / "a.nc")
    assert back.to_datatree().identical(result.to_datatree())
    assert network_dataset(back.network).identical(network_dataset(result.network))
    assert back.network.radius_sd is not None
    for field in ("name", "group", "synthetic", "interrupted", "noticed", "findings", "failures", "settings", "origin"):
        assert getattr(back, field) == getattr(result, field), field
    assert list(back.laws) == list(result.laws)
    assert back.laws["power"].posterior.trusted == result.laws["power"].posterior.trusted
    assert back.laws["linear"].posterior is None


@pytest.mark.parametrize("group", ["network", "recording", "measured/waves", "linear/tree"])
def test_a_tree_without_a_group_is_refused_with_its_name(stored, group):
    parent, _, name = group.rpartition("/")
    whole = stored.copy(deep=True)
    del (whole.children[parent] if parent else whole)[name]
    with pytest.raises(InputError, match=f"no group '{group}'"):
        AnimalResult.from_datatree(whole)


def test_no_wall_law_can_have_the_name_of_another_part(stored):
    for part in set(stored.children) - {"linear", "power"}:
        with pytest.raises(InputError, match=f"'{part}': a part of every result has this name"):
            check_law_names([part])


def test_the_laws_stand_in_the_order_in_which_a_user_named_them_also_after_they_were_stored(tmp_path):
    """The first is the primary law, and what export, sweep and posterior take."""
    results = made_results({"CTL": 2}, walls=("tangent", "power", "linear"))
    for number, result in enumerate(results):
        write_result(result, tmp_path / f"{number}.nc")
    back = [read_result(tmp_path / f"{number}.nc") for number in range(2)]
    assert [list(one.laws) for one in back] == [["tangent", "power", "linear"]] * 2
    assert stored_law(back[0])[0] == "tangent"
    failed = replace(back[0], laws={wall: law for wall, law in back[0].laws.items() if wall != "tangent"})
    cohort = gathered([failed, back[1]])  # the law failed in the first animal alone
    assert cohort.walls == ["tangent", "power", "linear"]
    assert primary_comparison(cohort).law == "tangent"
