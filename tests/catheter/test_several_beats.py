"""A table of several beats is no cycle of a slower heart, and one beat of any shape is one."""

import numpy as np
import pytest

from vasowave.base import InputError
from vasowave.catheter.read import beats_within, read_recording


def beats(rng, count, period, alternate=0.0):
    """Return times, pressure and flow of some beats: an ejection into a Windkessel, solved to its periodic state."""
    samples = 200
    lengths = np.full(count, period)
    ejection, decay = rng.uniform(0.28, 0.5) * period, rng.uniform(0.5, 2.5) * period
    strokes = 1 + 0.02 * rng.standard_normal(count) + alternate * (-1.0) ** np.arange(count)
    phase = np.tile(np.arange(samples) / samples, count) * period
    flow = np.repeat(strokes, samples) * np.where(phase < ejection, np.sin(np.pi * phase / ejection) ** 2, 0.0)
    step, pressure = period / samples, 20.0
    course = np.empty(len(flow))
    for _ in range(12):
        for i, inflow in enumerate(flow):
            pressure += step * (50.0 * inflow - pressure) / decay
            course[i] = pressure + 8.0 * inflow
    return np.arange(len(flow)) * step, course, flow, lengths.sum()


@pytest.mark.parametrize("count", [1, 2, 3])
@pytest.mark.parametrize("rate", [540.0, 350.0, 90.0, 70.0])
def test_beats_are_counted_in_mouse_rat_pig_and_human(count, rate):
    for seed in range(4):
        _, pressure, flow, lasts = beats(np.random.default_rng([seed, int(rate)]), count, 60 / rate, 0.1 * (seed % 2))
        assert beats_within(pressure, flow, lasts) == count


def written(path, time, pressure, flow):
    rows = (f"{t:.6f},{p:.4f},{q:.5f}" for t, p, q in zip(time, pressure, flow, strict=True))
    path.write_text("\n".join(["time [s],pressure [mmHg],flow [ml/s]", *rows, ""]), encoding="utf-8")
    return path


@pytest.mark.parametrize(("alternate", "code"), [(0.0, "several-beats"), (0.1, "several-unlike-beats")])
def test_of_two_beats_in_a_table_the_mean_is_taken_at_their_rate_and_it_is_said(tmp_path, alternate, code):
    time, pressure, flow, _ = beats(np.random.default_rng(1), 2, 60 / 700, alternate)
    with pytest.warns(match="the table holds 2 beats, not one"):
        cycle = read_recording(written(tmp_path / "two.csv", time, pressure, flow))
    assert cycle.heart_rate == pytest.approx(700.0, rel=1e-3)
    assert cycle.cardiac_output == pytest.approx(flow.mean(), rel=1e-3)
    assert cycle.mean_pressure == pytest.approx(pressure.mean(), rel=1e-3)
    assert f"recording.{code}" in [one.code for one in cycle.notes]


def test_several_beats_without_times_are_refused_because_the_period_may_be_of_one(tmp_path):
    _, pressure, flow, lasts = beats(np.random.default_rng(1), 2, 60 / 500)
    for name, values in (("p", pressure), ("q", flow)):
        (tmp_path / f"{name}.txt").write_text("\n".join(f"{one:.5f}" for one in values) + "\n", encoding="utf-8")
    with pytest.raises(InputError, match="holds 2 beats, and nothing tells whether the period"):
        read_recording(tmp_path / "p.txt", tmp_path / "q.txt", period=lasts)
