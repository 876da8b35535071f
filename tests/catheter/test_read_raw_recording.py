"""Reading continuous recordings: tables and LabChart's text export, and what every wrong file is told."""

import warnings
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from vasowave.base import InputError, VasowaveWarning, factor
from vasowave.catheter.read import choose, read_raw_recording
from vasowave.catheter.signals import RawRecording

RATE = 1000.0
COUNT = 1500
TIME = np.arange(COUNT) / RATE
PRESSURE = 14 + 5 * np.sin(2 * np.pi * 9 * TIME)
FLOW = 0.2 + 0.2 * np.sin(2 * np.pi * 9 * TIME)
ECG = np.cos(2 * np.pi * 9 * TIME) ** 31
HEADER = (
    "Interval=\t{interval}\r\n"
    "ExcelDateTime=\t4.3749464322749809e+04\t10/11/19 11:08:37.485584\r\n"
    "TimeFormat=\tStartOfBlock\r\n"
    "DateFormat=\t\r\n"
    "ChannelTitle=\tPAP\tFlow\tECG\r\n"
    "Range=\t50.0 mmHg\t10.000 {flow}\t2.000 mV\r\n"
    "UnitName=\tmmHg\t{flow}\t*\r\n"
    "TopValue=\t56.44\t180.80\t*\r\n"
    "BottomValue=\t-0.09\t-0.96\t*\r\n"
)


def lab_table(path, titles, step=0.001):
    rows = zip(step * np.arange(COUNT), PRESSURE, FLOW, strict=True)
    text = "\n".join(f"{t:.3f},{p:.5f},{q:.6f}" for t, p, q in rows)
    return write(path, f"{titles}\n{text}\n")


def test_a_unit_after_a_stroke_is_read_as_one_in_brackets(tmp_path):
    found = read_raw_recording(lab_table(tmp_path / "a.csv", "t/s,P/cmH2O,PA flow/(l/min)"))
    assert found.sampling_rate == pytest.approx(1000.0)
    np.testing.assert_allclose(found.pressure, PRESSURE * factor("cmH2O", "pressure"), atol=1e-4)
    np.testing.assert_allclose(found.flow, FLOW * factor("l/min", "flow"), rtol=1e-4, atol=1e-4)


@pytest.mark.parametrize("rate", [None, 800.0])
def test_a_column_that_rises_evenly_is_asked_about_and_no_other_rate_is_believed(tmp_path, rate):
    file = lab_table(tmp_path / "a.csv", "Zeitpunkt,pressure [mmHg],flow [ml/s]")
    with pytest.raises(InputError, match="'Zeitpunkt' rises evenly"):
        read_raw_recording(file, sampling_rate=rate)


def test_a_column_that_rises_as_times_do_at_the_rate_that_is_given_stands_in_nobodys_way(tmp_path):
    file = lab_table(tmp_path / "a.csv", "Zeitpunkt,pressure [mmHg],flow [ml/s]")
    read = read_raw_recording(file, sampling_rate=1000.0)
    np.testing.assert_allclose(read.pressure, PRESSURE, atol=1e-4)


def test_samples_that_are_numbered_are_no_times(tmp_path):
    file = lab_table(tmp_path / "a.csv", "sample,pressure [mmHg],flow [ml/s]", step=1.0)
    assert read_raw_recording(file, sampling_rate=800.0).sampling_rate == 800.0


def labchart_block(interval="0.001 s", flow="ml/min", flow_scale=60.0, comma=False, remarks=(), first=0.0, count=COUNT):
    lines = []
    for i in range(count):
        cells = [first + TIME[i], PRESSURE[i], flow_scale * FLOW[i], ECG[i]]
        lines.append("\t".join(f"{x:.6f}" for x in cells) + dict(remarks).get(i, ""))
    head = HEADER.format(interval=interval, flow=flow)
    body = "\r\n".join(lines) + "\r\n"
    if comma:
        body = body.replace(".", ",")
        head = head.replace(interval, interval.replace(".", ","))
    return head + body


def write(path: Path, text: str, encoding: str = "utf-8") -> Path:
    path.write_bytes(text.encode(encoding))
    return path


def matches(raw: RawRecording, tolerance=1e-5):
    np.testing.assert_allclose(raw.pressure, PRESSURE[: len(raw.pressure)], atol=tolerance)
    np.testing.assert_allclose(raw.flow, FLOW[: len(raw.flow)], atol=tolerance)
    np.testing.assert_allclose(raw.ecg, ECG[: len(raw.pressure)], atol=tolerance)


@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_a_table_in_other_units_reads_back_in_canonical_ones(tmp_path, separator):
    head = separator.join(["t [ms]", "PAP [kPa]", "Flow [µl/s]", "EKG [V]"])
    rows = zip(TIME * 1e3, PRESSURE * 0.133322, FLOW * 1e3, ECG / 1e3, strict=True)
    body = "\n".join(separator.join(f"{x:.9f}" for x in row) for row in rows)
    raw = read_raw_recording(write(tmp_path / "raw.csv", f"{head}\n{body}\n"))
    matches(raw)
    assert raw.sampling_rate == pytest.approx(RATE, rel=1e-9)
    assert raw.duration == pytest.approx(1.5)


def test_a_labchart_block_in_ml_per_min_reads_back_in_ml_per_s(tmp_path):
    raw = read_raw_recording(write(tmp_path / "raw.txt", labchart_block()))
    matches(raw)
    assert raw.sampling_rate == pytest.approx(RATE)


def test_times_of_day_are_left_aside_and_no_channel_with_them(tmp_path):
    head, _, body = labchart_block().rpartition("BottomValue=")
    first, *rows = body.splitlines()
    clock = [f"11:08:{37 + t:09.6f}\t{row.partition(chr(9))[2]}" for t, row in zip(TIME, rows, strict=True)]
    raw = read_raw_recording(write(tmp_path / "raw.txt", "\r\n".join([f"{head}BottomValue={first}", *clock, ""])))
    matches(raw)
    assert raw.sampling_rate == pytest.approx(RATE)


@pytest.mark.parametrize(
    ("stretch", "said"),
    [
        ({"end": 9.0}, "0 to 9"),
        ({"end": 0.0}, "0 to 0"),
        ({"start": 1.6}, "1.6 to 1.5"),
        ({"start": -0.1, "end": 0.5}, "-0.1 to 0.5"),
    ],
)
def test_a_stretch_beyond_the_recording_is_refused_with_both(tmp_path, stretch, said):
    path = write(tmp_path / "raw.txt", labchart_block())
    with pytest.raises(InputError, match=rf": {said} s does not lie in 0 to 1\.5 s"):
        read_raw_recording(path, **stretch)


def test_a_stretch_may_be_the_whole_and_does_not_end_before_it_starts(tmp_path):
    path = write(tmp_path / "raw.txt", labchart_block())
    assert len(read_raw_recording(path, start=0.0, end=1.5).pressure) == COUNT
    with pytest.raises(InputError, match=r"ends at 0\.2 s and starts at 0\.8 s"):
        read_raw_recording(path, start=0.8, end=0.2)


def test_a_decimal_comma_and_a_western_micro_sign_change_nothing(tmp_path):
    text = labchart_block(flow="µl/s", flow_scale=1000.0, comma=True)
    raw = read_raw_recording(write(tmp_path / "raw.txt", text, "cp1252"))
    matches(raw)


@pytest.mark.parametrize("interval", ["1 ms", "0.001 s", "1000 µs"])
def test_the_interval_may_be_in_any_unit_of_time(tmp_path, interval):
    raw = read_raw_recording(write(tmp_path / "raw.txt", labchart_block(interval=interval)))
    assert raw.sampling_rate == pytest.approx(RATE)


def test_comments_stand_at_their_times_and_channels(tmp_path):
    text = labchart_block(remarks={100: "\t#* ventilator off, 5.3 mg", 700: "\t#1 catheter in MPA"})
    with pytest.warns(VasowaveWarning, match="5.3 mg' is noted at 0.1 s, within the stretch that is read"):
        raw = read_raw_recording(write(tmp_path / "raw.txt", text), start=0.05, end=1.4)
    assert [(round(c.time, 6), c.text, c.channel) for c in raw.comments] == [
        (0.1, "ventilator off, 5.3 mg", 0),
        (0.7, "catheter in MPA", 1),
    ]


def test_of_several_blocks_the_longest_is_read_unless_one_is_named(tmp_path):
    text = labchart_block(count=1200, flow="l/min", flow_scale=0.06) + labchart_block(first=40.0)
    path = write(tmp_path / "raw.txt", text)
    longest = read_raw_recording(path)
    assert len(longest.pressure) == COUNT
    assert any("block 2 of 2" in str(note) for note in longest.notes)
    first = read_raw_recording(path, block=1)
    assert len(first.pressure) == 1200
    matches(first, 1e-4)
    with pytest.raises(InputError, match="no block 3; it has 2"):
        read_raw_recording(path, block=3)


def test_an_export_without_the_time_column_is_read_by_its_interval(tmp_path):
    lines = labchart_block().split("\r\n")
    text = "\r\n".join(line if "=" in line else "\t".join(line.split("\t")[1:]) for line in lines)
    matches(read_raw_recording(write(tmp_path / "raw.txt", text)))


def test_a_gap_is_told_in_seconds_and_harmless_outside_the_stretch(tmp_path):
    lines = labchart_block().split("\r\n")
    cells = lines[9 + 20].split("\t")
    lines[9 + 20] = "\t".join([cells[0], "", *cells[2:]])
    path = write(tmp_path / "raw.txt", "\r\n".join(lines))
    with pytest.raises(InputError, match=r"block 1, channel 'PAP': no samples from 0\.02 to 0\.021 s"):
        read_raw_recording(path)
    assert read_raw_recording(path, start=0.1).pressure[0] == pytest.approx(PRESSURE[100], abs=1e-5)


def longer(text, seconds=4):
    """Return an export that goes on for so many seconds by repeating its rows, times going on."""
    lines = text.split("\r\n")
    head, rows = [one for one in lines if "=" in one], [one.split("\t") for one in lines if one and "=" not in one]
    body = [[f"{i / 1000:.3f}", *rows[i % len(rows)][1:4]] for i in range(1000 * seconds)]
    return [*head, *map("\t".join, body)], len(head)


def test_rows_that_an_export_left_out_are_a_gap_and_the_longest_whole_stretch_is_proposed_in_seconds(tmp_path):
    lines, head = longer(labchart_block())
    del lines[head + 1500 : head + 1520]
    path = write(tmp_path / "raw.txt", "\n".join(lines) + "\n")
    with pytest.raises(InputError) as caught:
        read_raw_recording(path)
    said = str(caught.value)
    assert "no samples from 1.5 to 1.52 s; the longest stretch without a gap is 1.52 to 4 s" in said
    assert caught.value.__notes__ == ["start=1.52, end=4"]
    raw = read_raw_recording(path, start=1.52, end=4.0)
    assert raw.duration == pytest.approx(2.48)
    assert raw.pressure[0] == pytest.approx(PRESSURE[1520 % len(PRESSURE)], abs=1e-4)


def test_columns_of_a_table_are_named_as_they_are_titled(tmp_path):
    t = np.arange(0.0, 2.0, 0.001)
    rows = "\n".join(f"{one:.3f},{1 + np.sin(60 * one):.4f},{9 + np.sin(60 * one):.4f}" for one in t)
    (tmp_path / "a.csv").write_text(f"Time [s],PAP [ml/s],Q in [mmHg]\n{rows}\n", "utf-8")
    raw = read_raw_recording(tmp_path / "a.csv", pressure="Q in", flow="PAP")
    assert (raw.flow.mean(), raw.pressure.mean()) == pytest.approx((1.0, 9.0), abs=0.1)
    with pytest.raises(InputError, match=r"no channel 'PAO' \(did you mean 'PAP'\?\).*it has: 'PAP' \[ml/s\], 'Q in'"):
        read_raw_recording(tmp_path / "a.csv", pressure="Q in", flow="PAO")


def test_two_pressures_must_be_told_apart_by_the_reader(tmp_path):
    path = write(tmp_path / "raw.txt", labchart_block().replace("PAP\tFlow", "Left pressure\tRight pressure"))
    with pytest.raises(InputError, match="2 channels may hold pressure"):
        read_raw_recording(path)
    with pytest.raises(InputError, match=r"block 1, channel 'Right pressure': 'ml/min' is not a unit of pressure"):
        read_raw_recording(path, pressure="Right pressure", flow="ECG", flow_unit="ml/s")


@pytest.mark.parametrize(
    ("titles", "units", "picked"),
    [
        ("Channel 1\tChannel 2\tChannel 3", "mmHg\tml/s\tmV", (0, 1, 2)),
        ("Pressure 1\tFlow PA\tLead II", "mmHg\tml/s\tmV", (0, 1, 2)),
        ("Ao pressure\tPressure PA\tTransonic", "mmHg\tmmHg\tml/s", (1, 2, None)),
        ("Paw\tCh 2\tFlow", "cmH2O\tmmHg\tml/s", (1, 2, None)),
        ("PAP_1\tQ1\tEKG", "mmHg\tml/s\tmV", (0, 1, 2)),
    ],
)
def test_channels_are_told_by_title_place_or_unit(titles, units, picked):
    channels = [SimpleNamespace(title=t, unit=u) for t, u in zip(titles.split("\t"), units.split("\t"), strict=True)]
    choice = choose(channels, dict.fromkeys(("pressure", "flow", "ecg")))
    assert choice.problems == ()
    found = [
        channels.index(choice.picked[name]) if name in choice.picked else None for name in ("pressure", "flow", "ecg")
    ]
    assert tuple(found) == picked


def test_a_pressure_of_another_place_is_read_only_when_it_is_named():
    channels = [SimpleNamespace(title=t, unit=u) for t, u in (("LV pressure", "mmHg"), ("Flow", "ml/s"))]
    assert choose(channels, {"pressure": None}).problems == (
        "no channel says that it holds pressure ('LV pressure' may be of another place than the pulmonary artery, by "
        "its title), name it",
    )
    assert choose(channels, {"pressure": "LV pressure"}).picked["pressure"].title == "LV pressure"


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.adicht", "CFWB", r"File > Export.*LabChart Text File"),
        ("a.txt", "Interval=\t0.001 s\nChannelTitle=\tPAP\n", "headers and no samples"),
    ],
)
def test_a_wrong_file_is_told_what_and_what_to_do(tmp_path, name, text, message):
    with pytest.raises(InputError, match=message):
        read_raw_recording(write(tmp_path / name, text))


@pytest.mark.parametrize(
    ("text", "rate", "words"),
    [
        ("pressure [mmHg],flow [ml/s]\n1,2\n3,4\n", None, ": no time column; say how many samples a second has"),
        ("x,flow\n0.5,2\n1.0,4\n1.5,4\n", 1000.0, ": column 'x' rises evenly by 0.5, as a time does; title it 'time"),
        ("time,flow\n0.5,2\n1.0,4\n", None, ": column 'time' has no unit; write it in the header ('time [s]'), or say"),
        ("time [s],flow\n0.5,2\n", None, ": one sample only; a continuous recording is needed"),
        ("time [s],flow\n0.5,2\n,3\n1.5,4\n", None, ", line 3, time: the cell is empty or no number"),
        ("time,flow\n1,2\n1,3\n1,4\n", 9.0, ", line 3, column 'time': time does not increase"),
        ("time [s],flow\n0.0,2\n0.1,3\n0.2,4\n", 10.02, ": the time column has 10 samples/s, given are 10.02"),
        ("time [s],flow\n0.0,2\n0.1,3\n0.15,4\n0.3,4\n0.4,1\n", None, ", line 4, column 'time': uneven sampling, a"),
        ("time [s],zeit [s],flow\n0,0,2\n", None, ": two columns are called 'time'; keep one of them"),
        ("time [s],flow\n", None, ": a header and no data"),
        ("", None, ": the file is empty"),
        ("1,2\n3,4\n", None, ": no header; the first line must read: time [s],pressure [mmHg],flow [ml/s],ecg [mV]"),
        ("a;b\n1,5;2\n1;2.5\n", 9.0, ", line 3: numbers with a decimal comma and with a decimal point in one file"),
        ("a,b\n1,2\n3\n", 9.0, ", line 3: 1 columns where 2 were expected; missing values: the line was cut"),
        ("a,b\n1,2\n3,4,5\n", 9.0, ", line 3: 3 columns where 2 were expected; surplus values: the line was cut"),
        ("a,b\n3,4,5\n", 9.0, ", line 2: 3 columns below a header of 2; if title lines stand above"),
        ("a,b\n1,2\n\n# x\n3,q\n", 9.0, ", line 5, column 'b': 'q' is not a number"),
    ],
)
def test_a_table_is_refused_with_line_column_and_cure(tmp_path, text, rate, words):
    with pytest.raises(InputError) as refused:
        read_raw_recording(write(tmp_path / "a.csv", text), sampling_rate=rate)
    assert str(refused.value).partition("a.csv")[2].startswith(words)


def test_a_stretch_keeps_the_samples_and_the_times_of_the_recording(tmp_path):
    text = labchart_block(remarks={400: "\t#* now"})
    part = read_raw_recording(write(tmp_path / "raw.txt", text)).between(0.25, 1.4)
    assert part.pressure[0] == pytest.approx(PRESSURE[250], abs=1e-5)
    assert part.comments[0].time == pytest.approx(0.4)
    assert part.time[0] == pytest.approx(0.25)
    with pytest.raises(InputError, match="does not lie in the recording"):
        part.between(0.5, 3.0)


@settings(max_examples=80, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(cut=st.integers(0, 3000), junk=st.binary(max_size=12), at=st.integers(0, 3000))
def test_a_damaged_export_is_read_or_refused_in_words(tmp_path, cut, junk, at):
    content = labchart_block(count=60).encode("cp1252", errors="replace")
    damaged = content[:at] + junk + content[at : max(at, len(content) - cut)]
    path = tmp_path / "damaged.txt"
    path.write_bytes(damaged)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VasowaveWarning)  # it may look cut off, too
        with pytest.raises(InputError):  # 60 samples are too short in any case
            read_raw_recording(path)


@pytest.mark.parametrize("title", ["Aortendruck", "arterieller Blutdruck", "pression systemique", "Ventrikeldruck"])
def test_a_title_of_another_place_in_another_language_is_not_taken_for_the_pulmonary_artery(tmp_path, title):
    path = tmp_path / "a.csv"
    rows = "\n".join(f"{i / 500:.3f};{i % 50};{i % 7}" for i in range(500))
    path.write_text(f"Zeit [s];{title} [mmHg];Fluss [ml/s]\n{rows}\n", encoding="utf-8")
    with pytest.raises(InputError, match=f"'{title}' may be of another place than the pulmonary artery"):
        read_raw_recording(path)


@pytest.mark.parametrize("missing", ["#NV", "NA", "n/a", "-", ""])
def test_the_pressure_of_the_lung_is_taken_by_its_title_in_another_language_and_no_value_is_a_gap(tmp_path, missing):
    path = tmp_path / "a.csv"
    rows = "\n".join(f"{i / 500:.3f};{i % 50};{missing if i == 100 else i % 7}" for i in range(2000))
    path.write_text(f"Zeit [s];Pulmonalarteriendruck [mmHg];Fluss [ml/s]\n{rows}\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"'Fluss': no samples from 0.2 to 0.202 s"):
        read_raw_recording(path)
    path.write_text(path.read_text("utf-8").replace(f"0.200;0;{missing}\n", "0.200;0;3\n"), encoding="utf-8")
    assert read_raw_recording(path).pressure.max() == 49
