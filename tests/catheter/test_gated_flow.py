"""A flow of 20 to 25 phases beside a continuous pressure: put onto its beats, with what is known of where and when."""

import numpy as np
import pytest

from vasowave.base import InputError, VasowaveWarning
from vasowave.catheter import average_beats, read_raw_recording
from vasowave.catheter.read import kind_of

RATE, HUMAN = 240.0, (40, 180)
TIME = np.arange(0, 20, 1 / RATE)


def pressure(period):
    """A steep upstroke at the beginning of every beat, then a decay."""
    phase = TIME / period % 1
    return 10 + 12 * np.where(phase < 0.15, np.sin(np.pi / 2 * phase / 0.15), np.exp(-(phase - 0.15) / 0.4))


def phases(count, mean=80.0, late=0.0):
    phase = (np.arange(count) / count - late) % 1
    flow = np.where(phase < 0.35, np.sin(np.pi * phase / 0.35) ** 2, 0.0)
    return flow * mean / flow.mean()


def two_files(folder, flow_lines, period=0.8):
    rows = (f"{t:.5f},{p:.4f}\n" for t, p in zip(TIME, pressure(period), strict=True))
    (folder / "p.csv").write_text("time [s],pressure [mmHg]\n" + "".join(rows))
    (folder / "q.csv").write_text(flow_lines)
    return folder / "p.csv", folder / "q.csv"


def listed(values, head="phase,flow [ml/s]\n"):
    return head + "".join(f"{i},{value:.4f}\n" for i, value in enumerate(values))


def average(recorded):
    return average_beats(recorded, heart_rates=HUMAN)


@pytest.mark.parametrize("count", [20, 25])
@pytest.mark.parametrize("late", [0.0, 0.3])
def test_the_mean_and_the_heart_rate_are_those_of_the_files_and_the_feet_meet(tmp_path, count, late):
    files = two_files(tmp_path, listed(phases(count, late=late)))
    assert kind_of(files) == "raw"
    with pytest.warns(VasowaveWarning, match=rf"one cycle of {count} phases; .* \(75 beats/min\) by its foot"):
        recorded = read_raw_recording(*files)
    cycle = average(recorded).recording
    assert cycle.flow.mean() == pytest.approx(80, rel=5e-3)
    assert cycle.heart_rate == pytest.approx(75, rel=5e-3)
    upstrokes = [int(np.argmax(np.diff(values))) / len(values) for values in (cycle.pressure, cycle.flow)]
    assert (upstrokes[1] - upstrokes[0] + 0.5) % 1 - 0.5 == pytest.approx(0, abs=2 / count)


def test_the_flow_s_own_heart_rate_is_read_above_it_and_told(tmp_path):
    files = two_files(tmp_path, listed(phases(20), "Heart rate: 68 bpm\nphase,flow [ml/s]\n"))
    with pytest.warns(VasowaveWarning, match=r"20 phases, measured at 68 beats/min; .* to 12 ms"):
        recorded = read_raw_recording(*files)
    (note,) = (note for note in recorded.notes if note.code == "recording.gated-flow")
    assert dict(note.values)["error"] == pytest.approx(1e3 * 0.8 / 20 / np.sqrt(12), rel=1e-2)  # SD of an even spread


def test_phases_beside_a_continuous_pressure_in_one_table_are_read_with_their_times(tmp_path):
    flow, times = phases(25), np.arange(25) * 0.88 / 25 * 1e3
    cells = [f"{t:.2f},{q:.4f}" for t, q in zip(times, flow, strict=True)] + [","] * (len(TIME) - 25)
    rows = (f"{t:.5f},{p:.4f},{cell}\n" for t, p, cell in zip(TIME, pressure(0.8), cells, strict=True))
    (tmp_path / "a.csv").write_text("time [s],PAP [mmHg],trigger time [ms],MR flow [ml/s]\n" + "".join(rows))
    with pytest.warns(VasowaveWarning, match=r"25 phases, measured at 68\.18 beats/min"):
        recorded = read_raw_recording(tmp_path / "a.csv")
    assert average(recorded).recording.flow.mean() == pytest.approx(80, rel=5e-3)


def test_too_few_phases_are_refused(tmp_path):
    with pytest.raises(InputError, match="at least 16 a cycle"):
        read_raw_recording(*two_files(tmp_path, listed(phases(10))))


@pytest.mark.parametrize("unit", [" [ml/min]", ""])
def test_a_unit_that_is_given_counts_once(tmp_path, unit):
    files = two_files(tmp_path, listed(60 * phases(20), f"phase,flow{unit}\n"))
    with pytest.warns(VasowaveWarning):
        recorded = read_raw_recording(*files, flow_unit="ml/min")
    assert recorded.flow.mean() == pytest.approx(80, rel=0.02)


def test_a_channel_of_a_gated_cycle_cannot_be_chosen_and_that_is_said(tmp_path):
    files = two_files(tmp_path, listed(phases(20)))
    with pytest.raises(InputError, match="neither a channel nor a diameter can be chosen"):
        read_raw_recording(*files, flow="LPA flow")


def test_the_unit_in_a_title_is_no_heart_rate(tmp_path):
    rows = "".join(f"{i},{value:.4f},75\n" for i, value in enumerate(phases(20)))
    files = two_files(tmp_path, "phase,flow [ml/s],HR [1/min]\n" + rows)
    with pytest.warns(VasowaveWarning, match="20 phases; it was put"):
        read_raw_recording(*files)


def test_the_error_of_the_place_of_the_flow_goes_with_its_cycle(tmp_path):
    with pytest.warns(VasowaveWarning):
        recorded = read_raw_recording(*two_files(tmp_path, listed(phases(20))))
    assert average(recorded).recording.flow_delay_sd == pytest.approx(0.8 / 20 / np.sqrt(12), rel=1e-2)
