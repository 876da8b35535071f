"""Synthetic recordings whose every part is switched on alone, and the files of a virtual lab."""

import numpy as np
import pytest

from vasowave.datasets.published import published_table
from vasowave.datasets.raw import Disturbances, _beats, _ecg, _inspiration, _repeat, synthetic_raw_recording
from vasowave.datasets.virtual import _inflow, _resisting, _smooth_noise, _standardized
from vasowave.datasets.virtual_files import _without_pressure, labchart_text, network_text, table_text, write_lab_files
from vasowave.errors import InputError
from vasowave.model.linear import linear_solution
from vasowave.model.walls import LinearWall
from vasowave.network.network import Network
from vasowave.recording import Recording
from vasowave.recording.raw import RawRecording

T = np.arange(64) / 64
CYCLE = Recording(12 + 4 * np.sin(2 * np.pi * T), 1 + 0.5 * np.cos(2 * np.pi * T), 0.1)
NONE = dict.fromkeys(Disturbances.__dataclass_fields__, 0.0) | {"breaths_per_minute": 60.0}


def made(seed=1, **more):
    quiet = Disturbances(**(NONE | more.pop("disturbances", {})))
    return synthetic_raw_recording(CYCLE, np.random.default_rng(seed), duration=2.0, sampling_rate=500.0,
                                   disturbances=quiet, **more)  # fmt: skip


def test_without_disturbances_every_beat_is_the_cycle_itself():
    found = made()
    raw = found.raw
    assert (len(raw.pressure), raw.sampling_rate) == (1000, 500.0)
    assert np.diff(found.beat_times) == pytest.approx(0.1)
    phase = (raw.time - found.beat_times[0]) / 0.1
    assert raw.pressure == pytest.approx(12 + 4 * np.sin(2 * np.pi * phase), abs=1e-3)
    assert raw.flow == pytest.approx(1 + 0.5 * np.cos(2 * np.pi * phase), abs=1e-3)
    assert 0 <= found.beat_times[0] < 0.1
    assert 1.9 - 1e-9 <= found.beat_times[-1] <= raw.time[-1]
    assert np.diff(made(heart_rate=300.0).beat_times) == pytest.approx(0.2)
    assert made(ecg=False).raw.ecg is None


def test_each_disturbance_adds_what_it_says():
    plain = made().raw
    drift = made(disturbances={"pressure_drift": 6.0}).raw
    assert drift.pressure - plain.pressure == pytest.approx(0.1 * plain.time)
    line = made(baseline=lambda time: 3 * time).raw
    assert line.pressure - plain.pressure == pytest.approx(3 * plain.time)
    late = made(flow_delay=0.01).raw
    assert late.flow[5:] == pytest.approx(plain.flow[:-5])
    assert np.array_equal(late.pressure, plain.pressure)
    breathing = made(disturbances={"ventilation_pressure": 2.0, "ventilation_flow": 0.25})
    swell = (breathing.raw.pressure - plain.pressure) / 2.0
    assert (swell.min(), swell.max()) == pytest.approx((0.0, 1.0), abs=1e-4)
    assert np.mean(swell > 0) == pytest.approx(0.4, abs=0.01)
    assert breathing.raw.flow == pytest.approx(plain.flow * (1 - 0.25 * swell))
    assert breathing.inspiration == pytest.approx(np.interp(breathing.beat_times, plain.time, swell), abs=1e-3)
    noisy = made(disturbances={"pressure_noise": 0.2, "flow_noise": 0.1}).raw
    assert np.std(noisy.pressure - plain.pressure) == pytest.approx(0.2, rel=0.1)
    assert np.std(noisy.flow - plain.flow) == pytest.approx(0.1, rel=0.1)
    uneven = made(disturbances={"length_variation": 0.02, "amplitude_variation": 0.05})
    assert np.std(np.diff(uneven.beat_times)) == pytest.approx(0.002, rel=0.5)
    for wrong in ({"duration": 0.0}, {"sampling_rate": 0.0}, {"heart_rate": -60.0}):
        with pytest.raises(InputError, match="duration, sampling_rate and heart_rate of a synthetic recording must be"):
            synthetic_raw_recording(CYCLE, np.random.default_rng(1), **wrong)
    starts, gains, phase = _beats(np.random.default_rng(2), 0.1, 50.0, Disturbances(**NONE))
    assert (len(starts), len(gains)) == (int(1.5 * 50 / 0.1) + 21, int(1.5 * 50 / 0.1) + 20)
    assert -0.5 <= starts[0] <= -0.4
    assert 0 <= phase < 1


def test_beats_repeat_between_their_starts_with_their_gains():
    starts = np.array([-1.0, 0.0, 2.0, 3.0])
    ramp = np.array([2.0, 3.0, 4.0, 3.0])
    found = _repeat(np.tile(ramp, 1), np.array([0.0, 1.0, 1.5, 2.0, 2.5]), starts, np.array([1.0, 2.0, 1.0]))
    assert found[[0, 3]] == pytest.approx([2, 2])
    assert found[1] == pytest.approx(2 + 2 * 2, abs=0.3)
    assert found[4] == pytest.approx(4.0, abs=0.3)
    quiet = Disturbances(**NONE)
    assert _inspiration(np.array([0.0, 0.1, 0.2, 0.4, 0.9, 1.2]), quiet, 0.0) == pytest.approx([0, 0.5, 1, 0, 0, 1])
    assert _inspiration(np.array([0.0]), quiet, 0.2) == pytest.approx([1.0])
    ecg = _ecg(np.arange(1000) / 1000, np.array([-0.2, 0.2, 0.4, 0.6, 0.8, 1.1]), quiet, np.random.default_rng(1))
    assert np.argmax(ecg[150:250]) == pytest.approx(50, abs=2)


def test_made_inflows_noise_and_resistances_are_what_they_are_said_to_be():
    inflow = _inflow(0.2, 0.11, np.random.default_rng(3))
    assert (inflow.flow.mean(), inflow.period) == (pytest.approx(0.2), 0.11)
    noise = np.array([_smooth_noise(np.random.default_rng(seed)) for seed in range(40)])
    assert np.mean(noise**2) == pytest.approx(1.0, rel=0.2)
    values = _standardized(np.array([1.0, 2, 4, 9]))
    assert (values.mean(), np.std(values, ddof=1)) == pytest.approx((0, 1))
    tree = Network(("a", "b", "c"), [-1, 0, 0], [0.75, 0.55, 0.35], [0.047, 0.037, 0.026])
    model, R_T, tau = _resisting(tree, LinearWall(57.0), inflow, 80.0, 0.12, 1e-3)
    mean = linear_solution(model, inflow, 1).pressure[0, 0].real
    assert mean / 0.2 == pytest.approx(80.0, rel=1e-4)
    assert tau == pytest.approx(1e-3 * R_T / 0.88)
    with pytest.raises(InputError, match=r"no published table 'nominla' .did you mean 'nominal'.*there are: "):
        published_table("nominla")


def test_files_of_a_virtual_lab_hold_the_signals_to_their_digits(tmp_path):
    count = 500
    raw = RawRecording(np.arange(count) / 7, np.arange(count) / 3e3, 400.0, np.arange(count) / 11)
    lines = labchart_text(raw).split("\n")
    assert lines[0] == "Interval=\t0.0025 s"
    assert lines[4:7] == ["ChannelTitle=\tPAP\tFlow\tECG", "Range=\t10 V\t10 V\t10 mV", "UnitName=\tmmHg\tul/s\tmV"]
    assert lines[7].startswith("0.00000\t0.0000\t0.000\t0.0000\t#* ")
    assert lines[9] == "0.00500\t0.2857\t0.667\t0.1818"
    assert len(lines) == 7 + count + 1
    table = table_text(raw).split("\n")
    assert table[1] == "time [s],pressure [mmHg],flow [ml/s],ecg [mV]"
    assert table[4] == "0.00500,0.2857,0.000667,0.1818"
    gap = _without_pressure(labchart_text(raw), slice(3, 5)).split("\n")
    assert [line.split("\t")[1] for line in gap[9:13]] == ["0.2857", "NaN", "NaN", "0.7143"]
    tree = Network(("a", "b"), [-1, 0], [0.75, 0.55], [0.047, 0.037])
    assert network_text(tree).split("\n")[1:] == [
        "name,parent,length [mm],radius [mm]",
        "a,,7.5,0.47",
        "b,a,5.5,0.37",
        "",
    ]
    without = RawRecording(np.arange(count) / 7, np.ones(count), 400.0)
    assert table_text(without).split("\n")[3].endswith(",0.0000")
    (tmp_path / "x").write_text("")
    with pytest.raises(InputError, match="is not an empty folder; give another name"):
        write_lab_files(tmp_path)
    with pytest.raises(InputError, match="is not an empty folder"):
        write_lab_files(tmp_path / "x")
