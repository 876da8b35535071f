"""Recordings that are averaged at different parts of the breath are told before they are compared."""

from dataclasses import fields, replace

import numpy as np
import pytest
from small_study import SETTINGS

from vasowave.catheter import Disturbances, synthetic_raw_recording
from vasowave.study.entering import check_study

NONE = Disturbances(**{field.name: 0.0 for field in fields(Disturbances)})
DESIGN = "design: {subject: rat, occasion: when}\n"


def write_breathing(file, cycle, seed, height):
    """Write ten seconds of a cycle with breaths of a height that rest at the end opposite to it, mmHg."""
    quiet = replace(NONE, length_variation=0.015, pressure_noise=0.1, ecg_noise=0.05)
    hump = lambda t: np.where(t * 1.4 % 1 < 0.4, np.sin(np.pi * (t * 1.4 % 1) / 0.4) ** 2, 0.0)  # noqa: E731
    raw = synthetic_raw_recording(
        cycle, np.random.default_rng(seed), duration=10.0, sampling_rate=500.0, disturbances=quiet,
        baseline=lambda t: height * hump(t),
    ).raw  # fmt: skip
    columns = np.column_stack([raw.time, raw.pressure, raw.flow, raw.ecg])
    header = "time [s],pressure [mmHg],flow [ml/s],ecg [mV]"
    np.savetxt(file, columns, "%.6g", ",", header=header, comments="")


@pytest.mark.parametrize(
    ("heights", "settings", "is_told"),
    [
        ((4.0, -4.0), "", True),
        ((4.0, 3.0), "", False),
        ((4.0, -4.0), "averaging: {reject_ventilation: false}\n", False),
    ],
    ids=["opposite ends", "one end", "whole breaths as asked"],
)
def test_a_pair_at_opposite_ends_of_the_breath_is_told_with_its_size(make_study, mice, heights, settings, is_told):
    folder = make_study(settings=SETTINGS + DESIGN + settings)
    rows = ["animal,group,network,recording,kind,rat,when"]
    for name, cycle, height in zip(("pre", "post"), mice, heights, strict=False):
        write_breathing(folder / f"{name}.csv", cycle, len(name), height)
        rows.append(f"r1 {name},CTL,n.csv,{name}.csv,raw,r1,{name}")
    (folder / "animals.csv").write_text("\n".join(rows) + "\n", "utf-8")
    told = [one.finding for one in check_study(folder).problems if one.finding.code == "check.breaths-differ"]
    assert bool(told) == is_told
    if is_told:
        assert "at the lower end of r1 pre and at the upper end of r1 post" in str(told[0])
        assert "between recordings of one animal (r1)" in str(told[0])
        # Over whole breaths the mean stands above each end by the mean of the hump, 0.2 of its height.
        assert dict(told[0].values)["size"] == pytest.approx(0.2 * 8.0, rel=0.25)
