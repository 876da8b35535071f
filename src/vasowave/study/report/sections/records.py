"""Tables that become files but stand on no page as they are: tidy data of all animals in full precision."""

from collections.abc import Callable

import numpy as np
import pandas as pd

from vasowave.pulse.cycle.cycle import resample
from vasowave.pulse.inference.known_errors import SOURCES
from vasowave.study.animal.result import AnimalResult
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.report.sections.animals import estimates_frame, starts_frame
from vasowave.study.report.wording import animal_cells


def records(cohort: Cohort) -> dict[str, pd.DataFrame]:
    """Return the tables by name; one row for each number of an animal, parameter, pair of them, start, outlet or time.

    Where there are posteriors, of each quantity, of each source of its variance, and of each law too.
    """
    tables = {
        "Values": pd.concat([_values(result) for result in cohort.results], ignore_index=True),
        "Waveforms": pd.concat([_waveforms(result) for result in cohort.results], ignore_index=True),
    }
    if cohort.walls:
        tables |= {
            "Estimates": _by_law(cohort, estimates_frame),
            "Correlations": _by_law(cohort, _correlations),
            "EveryStart": _by_law(cohort, starts_frame),
            "Outlets": _by_law(cohort, _outlets),
        }
    drawn = {
        "Posterior": _by_law(cohort, _posterior), "Shares": _by_law(cohort, _shares), "Laws": _by_law(cohort, _law),
    }  # fmt: skip
    return tables | {name: table for name, table in drawn.items() if len(table)}


def _values(result: AnimalResult) -> pd.DataFrame:
    """Return the single numbers of an animal, measured and of each law."""
    return _labelled(result.table().drop(columns=["animal", "group"]), result)


def _by_law(cohort: Cohort, table: Callable[[AnimalResult, str], pd.DataFrame]) -> pd.DataFrame:
    frames = [_labelled(table(result, wall), result, wall=wall) for result in cohort.results for wall in result.laws]
    frames = [frame for frame in frames if len(frame)]
    return pd.concat(frames, ignore_index=True) if frames else pd.DataFrame()


def _labelled(table: pd.DataFrame, result: AnimalResult, **labels: str) -> pd.DataFrame:
    label_columns = animal_cells(result) | labels
    return table.assign(**label_columns)[[*label_columns, *table.columns]]  # type: ignore[arg-type]


def _correlations(result: AnimalResult, wall: str) -> pd.DataFrame:
    pairs = result.laws[wall].calibration["correlation"].to_dataframe().reset_index()
    return pairs.set_axis(["parameter", "other", "correlation [1]"], axis=1)


def _posterior(result: AnimalResult, wall: str) -> pd.DataFrame:
    """Return what the posterior says of every quantity."""
    posterior = result.laws[wall].posterior
    if posterior is None:
        return pd.DataFrame()
    names = ["unit", "median", "interval_low", "interval_high", "prior_low", "prior_high", "contraction"]
    table = pd.DataFrame({name: posterior.table[name].values for name in names if name in posterior.table.variables})
    table.insert(0, "quantity", posterior.table["quantity"].values)
    return table.assign(trusted=posterior.trusted)


def _shares(result: AnimalResult, wall: str) -> pd.DataFrame:
    """Return where the variance of every quantity comes from."""
    posterior = result.laws[wall].posterior
    if posterior is None:
        return pd.DataFrame()
    shares = {source: f"share_{source}" for source in SOURCES if f"share_{source}" in posterior.table}
    table = pd.DataFrame({source: posterior.table[name].values for source, name in shares.items()})
    return table.assign(quantity=posterior.table["quantity"].values).melt(
        "quantity", var_name="from", value_name="share of the variance [1]"
    )


def _law(result: AnimalResult, wall: str) -> pd.DataFrame:
    """Return the evidence for a law, its probability among the animal's, and how far its draws may be trusted."""
    posterior = result.laws[wall].posterior
    if posterior is None:
        return pd.DataFrame()
    names = ("log_evidence", "log_evidence_error", "k_hat", "effective", "halves_apart", "simulations")
    row: dict[str, float | bool] = {name: float(posterior.table[name]) for name in names if name in posterior.table}
    if result.evidence is not None and wall in result.evidence["wall"].values:
        row["probability"] = float(result.evidence["weight"].sel(wall=wall))
    return pd.DataFrame([row | {"trusted": posterior.trusted}])


def _outlets(result: AnimalResult, wall: str) -> pd.DataFrame:
    """Return what every vascular bed was calibrated to, and where it started."""
    sets = {"": result.laws[wall].calibration, " nominal": result.nominal}
    vessels = result.network
    columns = {
        f"{name}{suffix} [{value.attrs.get('units', '1')}]": value.values
        for suffix, data in sets.items()
        for name, value in data.data_vars.items()
        if value.dims == ("terminal",)
    }
    names = [vessels.name[row] for row in vessels.terminals]
    share = vessels.flow_fraction[vessels.terminals]
    return pd.DataFrame({"vessel": names, "flow fraction [1]": share, **columns})


def _waveforms(result: AnimalResult) -> pd.DataFrame:
    """Return pressure and flow at the inlet over one cycle: measured, and of every wall law."""
    recording = result.recording
    pressure = recording["pressure"].values
    waves = {"measured": (pressure, resample(recording["flow"].values, len(pressure)))}
    for wall in result.laws:
        law = result.laws[wall]
        waves[wall] = law.simulated("pressure", result.root).values, law.simulated("flow", result.root).values
    tables = [
        _labelled(pd.DataFrame({"time [s]": np.arange(len(p)) * (result.period / len(p)), "pressure [mmHg]": p,
                                "flow [ml/s]": q}), result, source=source)
        for source, (p, q) in waves.items()
    ]  # fmt: skip
    return pd.concat(tables, ignore_index=True)
