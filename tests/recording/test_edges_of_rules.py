"""Rules of recordings on their edge: the last case that a rule lets pass, and the first that it does not."""

import numpy as np
import pytest

from vasowave.errors import InputError, NumericalError
from vasowave.recording import BeatEdit, RawRecording, VentricularPressure
from vasowave.recording import gaps as gaps_module
from vasowave.recording.edits import judged, moved
from vasowave.recording.formats.edf import _stretches
from vasowave.recording.gaps import Span, describe_gaps, free_between, gaps_in, leaps_closed, longest_between, with_gaps
from vasowave.recording.harmonics import HarmonicErrors, _floor, _quantum
from vasowave.recording.plateaus import Plateau, _cut_off, _still, find_plateaus, plateau_findings
from vasowave.recording.plausibility import check_closure, odd_values
from vasowave.recording.rejection import (
    _correlation,
    choose_run,
    lost_in_run,
    mark_steps,
    misshapen_beats,
)
from vasowave.recording.same_signal import Trace, are_of_one
from vasowave.recording.signal import even_step
from vasowave.recording.ventilation import RULES, _narrowest_quarter, _off_level
from vasowave.recording.ventricle import _averaged, _upstrokes

SHARE = np.arange(200) / 200
WAVE = np.sin(2 * np.pi * SHARE)


def test_a_cycle_closes_at_five_percent_itself_and_says_nothing_at_one():
    """Steps of 2 over a range of 20: an end at 3 is a twentieth more; of 100, an end at 3 a hundredth more."""
    there = np.arange(0.0, 21, 2)
    told = check_closure(np.r_[there, there[::-1][1:-2], 3.0], "p", "here")
    assert [one.code for one in told] == ["recording.cycle-open"]
    wide = np.arange(0.0, 101, 2)
    assert check_closure(np.r_[wide, wide[::-1][1:-2], 3.0], "p", "here") == []


def test_a_mean_of_75_and_a_lowest_pressure_of_0_are_not_odd():
    flow = 0.2 + 0.25 * WAVE
    assert odd_values(75.0 + 15.0 * WAVE, flow, 0.11) == []
    assert odd_values(16.0 + 16.0 * WAVE, flow, 0.11) == []


def test_gaps_are_the_samples_that_are_none():
    values = np.array([np.nan, 1, 2, np.inf, np.nan, 3, np.nan])
    assert gaps_in(values, 10.0) == ((0.0, 0.1), (0.3, 0.5), (0.6, 0.7))
    assert gaps_in(np.ones(3), 10.0) == ()
    assert free_between(gaps_in(values, 10.0), 0.0, 0.7) == [(0.1, 0.3), (0.5, 0.6)]
    assert free_between([Span(1, 2), Span(1.5, 1.6)], 0.0, 3.0) == [(0.0, 1), (2, 3.0)]
    assert free_between([Span(2, 5)], 0.0, 3.0) == [(0.0, 2)]
    assert free_between([Span(3, 5)], 0.0, 3.0) == [(0.0, 3.0)]
    assert longest_between(gaps_in(values, 10.0), 0.0, 0.7) == (0.1, 0.3)
    assert longest_between([Span(0.0, 0.0104)], 0.0, 0.0309) == (0.011, 0.03)
    assert longest_between([Span(0, 3)], 0.0, 3.0) == (0.0, 0.0)


def test_gaps_are_told_three_at_most_joined_where_they_touch_with_the_longest_stretch_between():
    said = describe_gaps([Span(4, 5), Span(1, 2), Span(2, 3)], 0.0, 9.0, 1.0)
    assert said.startswith("no samples from 1 to 3 s, 4 to 5 s; the longest stretch without a gap is 5 to 9 s.")
    many = describe_gaps([Span(k, k + 0.5) for k in range(1, 5)], 0.0, 5.0, 1.0)
    assert "1 to 1.5 s, 2 to 2.5 s, 3 to 3.5 s and 1 more" in many
    assert "more" not in describe_gaps([Span(k, k + 0.5) for k in range(1, 4)], 0.0, 5.0, 1.0)
    assert describe_gaps([Span(1, 2)], 0.0, 3.0, 1.0).count("without a gap is") == 1
    assert describe_gaps([Span(1, 2)], 0.0, 3.0, 1.001).endswith("no 1.001 s are without a gap")
    assert describe_gaps([Span(0, 1), Span(3, 4), Span(1.5, 2)], 1.0, 3.0, 0.1).startswith(
        "no samples from 1.5 to 2 s;"
    )


def test_times_that_leap_seldom_and_not_too_far_are_closed():
    time = 0.001 * np.arange(300.0)
    time[200:] += 0.010
    closed, place = leaps_closed(time)
    assert closed == pytest.approx(0.001 * np.arange(300))
    assert place.tolist() == [*range(200), *range(210, 310)]
    spread = with_gaps(np.arange(300.0), place)
    assert (len(spread), spread[309], spread[199]) == (310, 299.0, 199.0)
    assert np.isnan(spread[200:210]).all()
    assert leaps_closed(0.001 * np.arange(300.0)) is None
    half = 0.001 * np.arange(300.0)
    half[200:] += 0.0005  # a step of one and a half is none
    assert leaps_closed(half) is None
    assert leaps_closed(np.zeros(5)) is None
    assert leaps_closed(np.zeros(1)) is None
    seldom = np.cumsum(np.append(0.0, np.ones(100)))
    seldom[50:] += 5
    assert leaps_closed(seldom) is not None  # one step of a hundred
    assert leaps_closed(seldom[:-1]) is None
    far = np.cumsum(np.append(0.0, np.ones(100)))
    far[50:] += 20 * 101 - 100  # 2020 places for 101 samples
    assert leaps_closed(far) is not None
    far[50:] += 1
    assert leaps_closed(far) is None
    assert gaps_module.leaps_closed(np.array([0.0, -1, -2])) is None


def test_times_rise_evenly_up_to_their_rounding():
    def step(time, quantum=1e-4):
        return even_step(np.asarray(time, float), quantum, "file", lambda row: f"line {row}")

    assert step([0, 0.01, 0.02, 0.0301]) == pytest.approx(0.0301 / 3)
    with pytest.raises(InputError, match="line 2, column 'time': time does not increase"):
        step([0, 0.01, 0.005, 0.03])
    with pytest.raises(InputError, match="line 1, column 'time': time does not increase"):
        step([0.0, 0.0, 0.0])
    with pytest.raises(InputError, match=r"line 2, column 'time': uneven sampling, a step of 0.02 s where the others"):
        step([0, 0.01, 0.03, 0.04, 0.05])
    with pytest.raises(InputError, match=r"written to 0.01 s, coarser"):
        step([0, 0.01, 0.01, 0.02], 0.01)
    assert step([0, 0.01, 0.02, 0.03], 0.01) == pytest.approx(0.01)


def test_a_plateau_lasts_four_tenths_of_a_second_and_hardly_moves():
    rate = 1000.0
    time = np.arange(4000) / rate
    pressure = 15 + 5 * np.sin(2 * np.pi * 9 * time)
    pressure[1200:1700] = 1.5
    (found,) = _still(pressure, rate)
    assert found == (1.2, 1.7, 1.5)
    short = 15 + 5 * np.sin(2 * np.pi * 9 * time)
    short[1200:1500] = 1.5  # three blocks of a tenth of a second
    assert _still(short, rate) == []
    raw = RawRecording(pressure, 0.1 * pressure, rate, origin=3.0)
    assert find_plateaus(raw) == (Plateau(4.2, 4.7, 1.5),)


def test_plateaus_are_zeros_near_zero_between_beats_and_calibrations_beyond():
    from vasowave.recording.plateaus import _AIR, _OFF_ZERO

    def code(level, start=5.0, end=6.0, first=4.0, last=7.0):
        return [one.code for one in plateau_findings((Plateau(start, end, level),), first, last)]

    within, right, off, known = code(0.0), code(0.0, first=5.5), code(_OFF_ZERO + 0.01), code(_AIR)
    assert len({*within, *right, *off, *known}) == 4
    assert code(0.0, last=6.0) == right  # it ends with the last beat
    assert code(0.0, first=5.0) == right
    assert code(_OFF_ZERO) == within
    assert code(-_OFF_ZERO - 0.01) == off
    assert code(_AIR - 1e-9) == off
    assert code(-_AIR) == known


def test_a_moved_beat_stays_between_its_neighbors_and_belongs_to_the_nearest():
    times = np.array([1.0, 2.0, 3.0, 4.0])

    def after(time, to):
        found, lost = moved(times, [BeatEdit("move", time, to)])
        return found.tolist(), len(lost)

    assert after(2.1, 2.4) == ([1, 2.4, 3, 4], 0)
    assert after(0.5, 0.7) == ([0.7, 2, 3, 4], 0)  # half an interval away
    assert after(0.49, 0.7)[1] == 1
    assert after(4.0, 9.0) == ([1, 2, 3, 9], 0)
    assert after(2.0, 3.0)[1] == 1
    assert after(2.0, 1.0)[1] == 1
    assert after(2.0, 2.999)[1] == 0


def test_a_beat_is_judged_from_its_start_to_before_its_end():
    starts, ends = np.array([1.0, 2.0]), np.array([2.0, 3.0])
    for time, hit in ((1.0, 0), (1.999, 0), (2.0, 1), (2.999, 1), (3.0, None), (0.999, None)):
        found, lost = judged([None, None], starts, ends, [BeatEdit("reject", time)])
        assert [reason is not None for reason in found] == [place == hit for place in range(2)]
        assert len(lost) == (hit is None)
    kept, _ = judged(["odd", None], starts, ends, [BeatEdit("keep", 1.5)])
    assert kept == [None, None]


def test_the_run_with_the_fewest_rejected_beats_is_averaged():
    bad = "x"
    used, run = choose_run([None, bad, None, None, None, bad, None], 3, "s")
    assert (used.tolist(), run) == ([2, 3, 4], range(2, 5))
    used, run = choose_run([None, None, bad, None], 3, "s")
    assert (used.tolist(), run) == ([0, 1, 3], range(4))
    assert choose_run([None, None], 2, "s")[0].tolist() == [0, 1]

    reasons = [None, None, bad, None]
    assert lost_in_run([None, bad, bad, None], range(4), 2) == []  # as many as were averaged
    (told,) = lost_in_run([None, bad, bad, bad, None], range(5), 2)
    assert dict(told.values) == {"lost": 3, "beats": 5}
    assert choose_run([None, None, _reason(), None], 4, "s")[0].tolist() == [0, 1, 3]  # fewer than wanted, yet enough
    with pytest.raises(NumericalError, match=r"s: 3 good beats of 4, 8 wanted"):
        choose_run([None, None, _reason(), None], 8, "s")  # two fifths of 8 are four
    assert reasons[2] == bad


def _reason():
    from vasowave.recording.rejection import _STEP

    return _STEP()


@pytest.mark.parametrize(("first", "rejected"), [(0, []), (1, [0, 1]), (3, [2, 3]), (4, [])])
def test_beats_before_and_after_a_step_are_rejected_and_none_beside_all_beats(first, rejected):
    reasons = [None] * 4
    mark_steps(reasons, [first])
    assert [place for place, reason in enumerate(reasons) if reason] == rejected


def test_correlations_are_those_of_numpy_and_none_of_a_beat_that_stands_still():
    rng = np.random.default_rng(2)
    smooth = np.linalg.matrix_power(_neighbors(50), 30)  # what remains of noise has no harmonic above 12
    beats, shape = rng.normal(0, 1, (4, 50)) @ smooth, smooth @ rng.normal(0, 1, 50)
    beats[3] = 2.0
    expected = [*(np.corrcoef(beat, shape)[0, 1] for beat in beats[:3]), 0.0]
    assert _correlation(beats, shape) == pytest.approx(expected, abs=1e-3)


def _neighbors(count):
    """Return what takes the mean of each sample and the two beside it, around the circle."""
    return (np.eye(count) + np.roll(np.eye(count), 1, 0) + np.roll(np.eye(count), -1, 0)) / 3


def test_the_level_at_the_end_of_expiration_is_the_narrowest_quarter():
    values = np.array([0.0, 0.1, 0.2, 5.0, 7.0, 9.0, 11.0, 13.0])
    middle, _ = _narrowest_quarter(values)
    assert middle in (pytest.approx(0.05), pytest.approx(0.15))  # two of eight
    nine = np.append(values, 15.0)
    assert _narrowest_quarter(nine)[0] == pytest.approx(0.1)  # three of nine


def test_peaks_are_cut_off_where_many_samples_stand_together_at_the_largest_value():
    sine = np.round(10 * np.tile(WAVE, 10), 2)
    assert _cut_off(sine) == 0.0
    clipped = np.minimum(sine, 8.0)
    assert _cut_off(clipped) == pytest.approx(np.mean(clipped == 8.0), abs=0.011)  # a sample beside each is as near
    alone = sine.copy()
    alone[50] = 12.0
    assert _cut_off(alone) == 0.0


def test_two_traces_are_of_one_if_a_stretch_of_the_shorter_stands_in_the_longer():
    rng = np.random.default_rng(4)
    whole = np.cumsum(rng.normal(0, 1, 6000)).astype(np.float32)
    one = Trace(whole, 1000.0, 545.0)
    part = Trace(whole[1500:4000] + np.float32(3.0), 1000.0, 545.0)
    assert are_of_one(one, part)
    assert are_of_one(part, one)
    assert not are_of_one(one, part._replace(rate=999.0))
    assert are_of_one(one, part._replace(heart_rate=545 * 1.049))
    assert not are_of_one(one, part._replace(heart_rate=545 * 1.051))
    assert not are_of_one(one, part._replace(pressure=np.cumsum(rng.normal(0, 1, 2500)).astype(np.float32)))
    brief = int(4 * 60 * 1000 / 545)  # four beats
    assert are_of_one(one, part._replace(pressure=whole[100 : 100 + brief + 1]))
    assert not are_of_one(one, part._replace(pressure=whole[100 : 100 + brief - 1]))


def test_records_that_follow_at_once_are_one_stretch():
    assert _stretches(np.array([0.0, 1, 2]), 1.0) == [(0, 3)]
    assert _stretches(np.array([0.0, 1, 2.00009]), 1.0) == [(0, 3)]
    assert _stretches(np.array([0.0, 1, 2.0002, 3.0002]), 1.0) == [(0, 2), (2, 4)]


@pytest.mark.parametrize(
    ("pressure", "period", "said"),
    [
        (20 * WAVE[:31], 0.1, "needs 32 samples"),
        (0.5 * WAVE, 0.1, "the pressure changes by 1 mmHg"),
        (20 * WAVE, 0.0, "a period of 0 s"),
        (20 * WAVE, np.inf, "a period of inf s"),
        (np.where(SHARE == 0.05, np.nan, 20 * WAVE), 0.1, "sample 11 is no finite number"),
    ],
)
def test_a_ventricles_pressure_is_refused_beyond_its_limits(pressure, period, said):
    with pytest.raises(InputError, match=said):
        VentricularPressure(pressure, period)
    assert VentricularPressure(0.501 * WAVE[::5], 1e-9).beats == 1


def test_beats_of_a_ventricle_are_averaged_from_upstroke_to_upstroke_without_odd_ones():
    beat = 2 + 20 * np.sin(np.pi * np.arange(100) / 100) ** 6
    starts = _upstrokes(np.tile(beat, 6))
    assert np.diff(starts).tolist() == [100] * (len(starts) - 1)
    assert len(_upstrokes(beat)) == 0
    pressure = np.tile(beat, 6)
    one = _averaged(pressure, np.array([30, 130, 230, 349, 450]), 0.001, "v")  # 100, 100, 119, 101
    assert (one.beats, one.period) == (4, pytest.approx(0.105))
    fewer = _averaged(pressure, np.array([30, 130, 230, 351, 452]), 0.001, "v")  # 121 is a fifth too long
    assert (fewer.beats, fewer.period) == (3, pytest.approx(0.301 / 3))
    assert fewer.pressure[0] == pytest.approx(np.mean(pressure[[30, 130, 351]]))


@pytest.mark.parametrize("place", [0, 5, 39])
def test_a_beat_of_odd_length_is_rejected_at_the_edge_of_a_recording_too(place):
    lengths = 0.11 + 0.0005 * np.random.default_rng(1).uniform(-1, 1, 40)
    lengths[place] *= 1.6
    beats = np.tile(WAVE, (40, 1))
    reasons = misshapen_beats(lengths, beats, beats, 0.15, 0.9, (WAVE, WAVE))
    assert [i for i, reason in enumerate(reasons) if reason] == [place]


@pytest.mark.parametrize("first", [0, 2, 4])
def test_beats_of_an_inspiration_stand_off_the_level_of_the_others_also_near_the_ends(first):
    means = 14.0 + 0.05 * np.random.default_rng(6).uniform(-1, 1, 61)
    means[first::5] += 1.5
    off, limit = _off_level(means, RULES)
    assert np.array_equal(np.abs(off) > limit, means > 15)


@pytest.mark.parametrize(
    ("values", "step"),
    [([0.5, 1.25, 3.0], 0.05), ([10.0, 20.0], 10.0), ([2.2, 2.6], 0.2), ([1.5, 2.0], 0.5)],
)
def test_the_step_of_rounded_numbers_is_the_coarsest_that_fits(values, step):
    assert _quantum(np.array(values)) == pytest.approx(step)


def test_signal_ends_where_harmonics_fall_below_twice_their_expected_error():
    """The sum of modulus² - 8·error² is largest there: 8 is four times the two of a square error."""
    error = np.full(9, 1.0)

    def last(*modulus):
        return HarmonicErrors(np.array([50.0, *modulus]), error[: len(modulus) + 1], "file").with_signal

    assert last(9, 9, 3, 1) == 3
    assert last(9, 9, 2.82, 1) == 2
    assert last(9, 2.0, 9, 1) == 3  # a weak one between strong ones
    assert last(2.0, 2.0) == 0
    assert last() == 0
    assert last(2.0, 1, 1, 1, 1, 5) == 0  # a single one far above the others' end: 25 - 8 are less than the rest lacks


def test_the_floor_of_a_spectrum_is_the_level_of_its_first_flat_octaves():
    k = np.arange(513.0)
    falling = 100.0 * 2.0 ** -(k / 5)
    white = np.sqrt(falling**2 + 0.04**2)
    assert _floor(white) == pytest.approx(0.04 / np.sqrt(2), rel=0.04)
    steep = 100.0 / np.maximum(k, 1) ** 3  # falls by 8 from octave to octave: the last quarter counts
    assert _floor(steep) == pytest.approx(np.sqrt(0.5 * np.mean(steep[-128:] ** 2)))
    emptied = white.copy()
    emptied[256:] *= 0.1  # interpolated above the rate it was recorded at
    assert _floor(emptied) == pytest.approx(0.04 / np.sqrt(2), rel=0.06)
