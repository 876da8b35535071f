"""A cohort whose fits are made from formulas: real analyses and real results, no search behind them."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import made_fit
from vasowave.base import OTHER, VasowaveWarning
from vasowave.catheter import synthetic_raw_recording
from vasowave.pulse.cycle import Recording
from vasowave.pulse.examples import control_network, hypertensive_network
from vasowave.pulse.inference import columns
from vasowave.pulse.selection import verdicts
from vasowave.study.animal import Animal, AnimalResult, LawResult, Measured, Settings, result_of
from vasowave.study.cohort import Design, Variable, gathered

FAILURE = "no diastolic decay of positive pressure after ejection; check the cycle"
PLANTED = 98.765432
"""A resistance that no analysis of these animals could give."""

NETWORKS = {"HPH": hypertensive_network}


EXACT = dict.fromkeys(columns(), 0.0)


def made_results(groups, *, raw=0, walls=("linear", "tangent"), selection=False, errors=EXACT):
    """Return the results of a cohort; `groups` says how many animals each has, later groups are stiffer.

    The first `raw` animals have continuous recordings. `errors` are told; what follows of others takes a second each.
    """
    rng = np.random.default_rng(7)
    results = []
    for place, (group, count) in enumerate(groups.items()):
        for number in range(1, count + 1):
            factor = (1 + 0.8 * place) * np.exp(0.12 * rng.standard_normal())
            results.append(
                made_result(f"{group} {number}", group, factor, rng, len(results) < raw, walls, selection, errors)
            )
    return results


def planted_results():
    """Return 3 + 3 animals, the first of a raw recording, with a value, a mark and a note planted."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VasowaveWarning)
        results = made_results({"CTL": 3, "HPH": 3}, raw=1, errors={})
    results[1] = changed(results[1], "linear/quantities", R_T=PLANTED)
    results[0] = changed(results[0], "tangent/calibration", at_bound=np.array([True, False, False, False, False]))
    results[2] = replace(results[2], noticed=(OTHER(text="the flow <ends> late & is odd"),))
    return results


def changed(result, group, **values):
    """Return a result with variables of one stored group replaced."""
    tree = result.to_datatree().copy(deep=True)
    data = tree[group].to_dataset()
    tree[group].dataset = data.assign({name: data[name].copy(data=value) for name, value in values.items()})
    return AnimalResult.from_datatree(tree)


def bare_result(name="mouse", group="CTL", **parts):
    """Return a result that holds nothing but its name, its group and these parts."""
    nothing = xr.Dataset()
    measured = Measured(waves=nothing, impedance=nothing, quantities=nothing)
    needed = {"network": control_network(), "recording": nothing, "nominal": nothing, "measured": measured}
    return AnimalResult(name=name, group=group, **needed | parts)


def bare_law(name, **parts):
    """Return what a wall law says, of which nothing but these parts is there."""
    needed = ("calibration", "simulation", "waves", "impedance", "vessels", "quantities")
    return LawResult(name=name, **dict.fromkeys(needed, xr.Dataset()) | parts)


def made_result(name, group, factor, rng, raw, walls, selection, errors=EXACT):
    """Return one animal whose pressure and stiffness are `factor` times those of `made_fit`."""
    base = made_fit.made_recording(count=128)
    cycle = Recording(
        base.pressure * factor, base.flow * np.exp(0.08 * rng.standard_normal()), base.period, f"synthetic {name}"
    )
    network = NETWORKS.get(group, control_network)()
    if raw:
        beating = synthetic_raw_recording(cycle, rng, duration=8.0).raw
        with pytest.warns(match="the flow rests at"):  # as this wave does
            animal = Animal.from_raw(name, group, network, beating, synthetic=True)
    else:
        animal = Animal(name, group, network, cycle, synthetic=True)
    fits = [made_fit.made_fit(wall, recording=animal.recording, network=network, factor=factor) for wall in walls]
    how = Settings(walls=walls or ("linear",), starts=4, model_selection=selection, **errors)
    return result_of(animal, fits, how)


def voting(result, scores, likeliest):
    """Return a result with a stored comparison: score of every law by noise model, the third place says discarded."""
    columns = {name: [] for name in ("covariance", "wall", "AICc", "BIC", "AICc_verdict", "BIC_verdict", "lambda",
                                     "D", "N", "discarded")}  # fmt: skip
    for covariance, (by_law, discarded) in scores.items():
        says = {law: verdict for law, _, verdict in verdicts(by_law)}
        for place, (law, score) in enumerate(by_law.items()):
            row = (covariance, law, score, score, says[law], says[law], 0.01, 4.0 + place, 512.0, discarded)
            for name, value in zip(columns, row, strict=True):
                columns[name].append(value)
    selection = xr.Dataset({name: ("candidate", np.array(values)) for name, values in columns.items()})
    return replace(result, selection=selection.assign_attrs(preferred_covariance=likeliest))


def crossed_cohort(mice=3, walls=("linear",), levels=("vor", "nach"), groups=("Kontrolle Süd", "Hypoxie Öst")):
    """Return two groups of mice of long names, each recorded at every level, pressures falling from level to level."""
    rng = np.random.default_rng(11)
    results, columns = [], {"mouse": {}, "time": {}, "sex": {}, "litter": {}}
    for place, group in enumerate(groups):
        for number in range(1, mice + 1):
            mouse = f"{group.split()[-1]} {number}"
            own = (1 + 0.8 * place) * np.exp(0.12 * rng.standard_normal())
            for later, level in enumerate(levels):
                factor = own * 0.85**later * 0.9 ** (later * place) * np.exp(0.03 * rng.standard_normal())
                result = made_result(f"{mouse} {level}", group, factor, rng, False, walls, False)
                results.append(result)
                cells = {"mouse": mouse, "time": level, "sex": "fm"[number % 2], "litter": "ABCD"[number % 4]}
                for name, cell in cells.items():
                    columns[name][result.name] = cell
    design = Design(covariates=("sex",), subject="mouse", occasion="time")
    known = [Variable.from_cells(name, cells) for name, cells in columns.items()]
    return gathered(results, groups[0], variables=known, design=design)
