"""Tables as statistics programs, digitizers and further recorders write them, by the numbers that went into them."""

import json

import numpy as np
import pytest

from vasowave.base import InputError, VasowaveWarning
from vasowave.catheter.read import describe_recording, read_raw_recording, read_recording

RATE, COUNT = 1000, 3000
TIME = np.arange(COUNT) / RATE
PRESSURE = 15 + 5 * np.cos(2 * np.pi * 9 * TIME)
FLOW = 0.2 + 0.15 * np.sin(2 * np.pi * 9 * TIME)


def rows(row):
    return "".join(f"{row(*values)}\n" for values in zip(range(COUNT), TIME, PRESSURE, FLOW, strict=True))


def r_data_frame():
    return '"","Time..s.","PAP..mmHg.","Flow..mL.min."\n' + rows(
        lambda i, t, p, q: f'"{i}",{t:.3f},{p:.5f},{60 * q:.5f}'
    )


def matlab_timetable():
    return "Time,PAP_mmHg,PAflow_mlmin\n" + rows(lambda i, t, p, q: f"{t:.5g} sec,{p:.9f},{60 * q:.9f}")


def matlab_names_of_titles_in_brackets():
    return "Time_s_,PAP_mmHg_,PAFlow_mL_min_\n" + rows(lambda i, t, p, q: f"{t:.5g},{p:.9f},{60 * q:.9f}")


def milliseconds_since_1970():
    return "timestamp_ms,pap_mmhg,flow_mlmin\n" + rows(lambda i, t, p, q: f"{1773310522000 + i},{p:.5f},{60 * q:.5f}")


def milliseconds_as_durations():
    return "Time;PAP_mmHg;Flow_mls\n" + rows(lambda i, t, p, q: f"{1e3 * t:.0f} ms;{p:.5f};{q:.6f}")


def time_beside_a_clock():
    head = "Time\tTOD\tPAP (mmHg)\tFlow (ml/s)\tMarks\n"
    return head + rows(
        lambda i, t, p, q: f"{t:.3f}\t13:59:{57 + t:06.3f}\t{p:.5f}\t{q:.6f}\t{'baseline' * (i == 2500)}"
    )


def rates_below_the_units():
    head = "Zeit  1 - Standard-Messrate\tDruck A. pulmonalis\tFluss A. pulmonalis\ns\tmmHg\tml/s\n"
    head += "\t".join(["Messrate: 1000 Hz"] * 3) + "\n"
    return head + rows(lambda i, t, p, q: f"{t:.3f}\t{p:.5f}\t{q:.6f}".replace(".", ","))


def titles_behind_a_word_without_time():
    head = '"FILE ID","8847"\n"HORZ_UNITS","S"\n"VERT_UNITS","mmHg","mL/s"\n"SIGNAL","PA press","PA flow"\n"DATA"\n'
    return head + rows(lambda i, t, p, q: f"{t:+.4E},{p:+.6E},{q:+.6E}")


def numbered_columns_with_their_units():
    head = "# Start: 3/12/2021 10:15\n# Col: 0,Time,s\n# Col: 1,PAP,mmHg\n# Col: 2,PA flow,ml/s\n# Time,PAP,PA flow\n"
    return head + rows(lambda i, t, p, q: f"{t:.3f},{p:.5f},{q:.6f}")


def a_remark_beside_a_clock_in_the_first_row():
    head = "datetime,PAP_mmHg,PA flow [ml/s],note\n"
    return head + rows(lambda i, t, p, q: f"2024-03-01T09:15:{t:06.3f},{p:.5f},{q:.6f},{'start' * (i == 0)}")


def levels_of_titles_of_pandas():
    head = "signal,PAP,PA flow\nunit,mmHg,ml/s\ntime_s,,\n"
    return head + rows(lambda i, t, p, q: f"{t:.3f},{p:.5f},{q:.6f}")


def remarks_below_the_units():
    head = "Time\tPA pressure\tPA flow\ns\tmmHg\tml/s\n\tbaseline\tbaseline\n"
    return head + rows(lambda i, t, p, q: f"{t:.3f}\t{p:.5f}\t{q:.6f}")


def a_remark_in_the_first_row_in_french():
    head = "Acquisition;Rat 31;;\nDate;14/03/2024;;\n;;;\nTemps;Pression AP;Débit AP;Remarques\n(s);(mmHg);(ml/s);\n"
    row = rows(lambda i, t, p, q: f"{t:.3f};{p:.5f};{q:.6f};{'début' * (i == 0)}")
    return head + row.replace(".", ",")


def units_that_are_spelled():
    head = "x-axis,PA pressure,PA flow\nsecond,mmHg,ml/second\n"
    return head + rows(lambda i, t, p, q: f"{t:+.6E},{p:+.6E},{q:+.6E}")


FORMS = [r_data_frame, remarks_below_the_units, a_remark_in_the_first_row_in_french, units_that_are_spelled,
         matlab_timetable, matlab_names_of_titles_in_brackets, milliseconds_since_1970,
         milliseconds_as_durations, time_beside_a_clock, rates_below_the_units,
         titles_behind_a_word_without_time, levels_of_titles_of_pandas, numbered_columns_with_their_units,
         a_remark_beside_a_clock_in_the_first_row]  # fmt: skip


@pytest.mark.parametrize("form", FORMS, ids=lambda form: form.__name__)
def test_a_table_of_another_program_is_read_without_a_word_beside_it(tmp_path, form):
    (tmp_path / "a.csv").write_text(form())
    recording = read_raw_recording(tmp_path / "a.csv")
    assert recording.sampling_rate == pytest.approx(RATE)
    assert recording.pressure == pytest.approx(PRESSURE, abs=1e-4)
    assert recording.flow == pytest.approx(FLOW, abs=1e-4)


@pytest.mark.parametrize("slow", [1, 2, 5])
def test_signals_with_columns_of_times_of_their_own_have_their_own_rates(tmp_path, slow):
    lines = [f"{t:.3f},{p:.5f}," for t, p in zip(TIME, PRESSURE, strict=True)]
    slower = [f",{t:.3f},{q:.6f}" for t, q in zip(TIME[::slow], FLOW[::slow], strict=True)]
    slower += [",,"] * (COUNT - len(slower))
    text = "".join(f"{a}{b}\n" for a, b in zip(lines, slower, strict=True))
    (tmp_path / "a.csv").write_text("Time (s),PAP (mmHg),,Time (s),Flow (ml/s)\n" + text)
    recording = read_raw_recording(tmp_path / "a.csv")
    inner = slice(50, 2900)  # splines have no neighbors at the ends
    assert recording.sampling_rate == pytest.approx(RATE)
    assert recording.pressure[inner] == pytest.approx(PRESSURE[inner], abs=1e-4)
    assert recording.flow[inner] == pytest.approx(FLOW[inner], abs=2e-3)


def test_columns_of_times_that_begin_apart_are_refused_with_their_beginnings(tmp_path):
    text = rows(lambda i, t, p, q: f"{t:.3f},{p:.5f},{t + 0.5:.3f},{q:.6f}")
    (tmp_path / "a.csv").write_text("Time (s),PAP (mmHg),Time (s),Flow (ml/s)\n" + text)
    with pytest.raises(InputError, match=r"begin apart \('PAP' at 0 s, 'Flow' at 0\.5 s\)"):
        read_raw_recording(tmp_path / "a.csv")


def test_two_columns_of_times_side_by_side_are_refused(tmp_path):
    text = rows(lambda i, t, p, q: f"{t:.3f},{t:.3f},{p:.5f},{q:.6f}")
    (tmp_path / "a.csv").write_text("Time (s),Time (s),PAP (mmHg),Flow (ml/s)\n" + text)
    with pytest.raises(InputError, match="two columns are called 'time'"):
        read_raw_recording(tmp_path / "a.csv")


def test_a_digitized_cycle_has_its_own_x_for_each_curve(tmp_path):
    period = 0.84
    cells = []
    for count, mean, amplitude in ((80, 16.0, 6.0), (100, 90.0, 60.0)):
        phase = np.arange(count) / count
        cells.append([f"{period * x:.6f},{mean + amplitude * np.sin(2 * np.pi * x):.6f}" for x in phase])
    cells[0] += [","] * 20
    text = "".join(f"{a},{b}\n" for a, b in zip(*cells, strict=True))
    (tmp_path / "a.csv").write_text("Pressure (mmHg),,Flow (mL/s),\nX,Y,X,Y\n" + text)
    recording = read_recording(tmp_path / "a.csv")
    assert recording.period == pytest.approx(period, rel=1e-4)
    assert (recording.pressure.mean(), recording.flow.mean()) == pytest.approx((16, 90), rel=1e-3)
    assert (np.ptp(recording.pressure), np.ptp(recording.flow)) == pytest.approx((12, 120), rel=1e-2)
    assert [str(note) for note in recording.notes if note.code == "recording.times-in-seconds"]


def test_raw_numbers_of_opensignals_are_called_by_their_titles_and_asked_for_units(tmp_path):
    head = {"00:07": {"column": ["nSeq", "DI", "CH1", "CH2"], "sampling rate": RATE, "resolution": [16, 16]}}
    text = rows(lambda i, t, p, q: f"{i}\t0\t{32768 + 500 * p:.0f}\t{32768 + 1e4 * q:.0f}\t")
    (tmp_path / "a.txt").write_text(f"# OpenSignals Text File Format\n# {json.dumps(head)}\n# EndOfHeader\n{text}")
    with pytest.raises(InputError, match=r"no channel says that it holds pressure.*'CH1' \[no unit\]"):
        read_raw_recording(tmp_path / "a.txt")
    typed = {"pressure": "CH1", "flow": "CH2", "pressure_unit": "Pa", "flow_unit": "ml/s"}
    assert read_raw_recording(tmp_path / "a.txt", **typed).sampling_rate == RATE


@pytest.mark.parametrize("names", [("p", "q"), ("PAP", "PAflow")])
def test_a_structure_whose_fields_are_letters_or_joined_words_is_read(tmp_path, names):
    from scipy.io import savemat

    savemat(tmp_path / "a.mat", {"Data": {"t": TIME, names[0]: PRESSURE, names[1]: FLOW}})
    units = {"pressure_unit": "mmHg", "flow_unit": "ml/s"}
    recording = read_raw_recording(tmp_path / "a.mat", **units)
    assert recording.pressure == pytest.approx(PRESSURE)
    assert recording.flow == pytest.approx(FLOW)


def test_a_table_of_means_is_refused_for_its_rate_before_anything_is_asked(tmp_path):
    head = "Elapsed (s),Sys PAP (mmHg),Dia PAP (mmHg),Mean PAP (mmHg),Mean flow (ml/min)\n"
    (tmp_path / "a.csv").write_text(head + "".join(f"{10 * i},24.1,9.2,15.{i % 10},12.{i % 7}\n" for i in range(60)))
    with pytest.raises(InputError, match=r"0\.1 samples/s.*not their means"):
        read_raw_recording(tmp_path / "a.csv")


def record(folder, checksums):
    numbers = np.column_stack([np.rint(values * 100) for values in (PRESSURE, FLOW * 10)]).astype("<i2")
    (folder / "mouse 4 base.dat").write_bytes(numbers.tobytes())
    texts = [f"mouse 4 base.dat 16 {gain}(0)/{unit} 16 0 {first} {total} 0 {title}\n"
             for gain, unit, first, total, title in zip((100, 1000), ("mmHg", "ml/s"), numbers[0],
             checksums or np.sum(numbers, 0, dtype="i2"), ("PAP", "Flow"), strict=True)]  # fmt: skip
    (folder / "mouse 4 base.hea").write_text(f"mouse 4 base 2 {RATE} {COUNT}\n{''.join(texts)}")
    return folder / "mouse 4 base.hea"


def test_a_wfdb_record_with_blanks_in_its_name_is_read_and_its_checksums_agree(tmp_path):
    path = record(tmp_path, None)
    assert read_raw_recording(path).pressure == pytest.approx(PRESSURE, abs=0.006)
    assert not describe_recording(path).suspicions


def test_a_wfdb_header_that_lost_its_rate_is_refused(tmp_path):
    path = record(tmp_path, None)
    path.write_text(path.read_text().replace(f" {RATE} {COUNT}", f" {COUNT} 10:00:00 01/02/2020"))
    with pytest.raises(InputError, match="no sound header"):
        read_raw_recording(path)


def test_a_wfdb_record_whose_numbers_were_changed_is_told_by_its_checksum(tmp_path):
    path = record(tmp_path, [1234, 0])
    assert [finding.code for finding in describe_recording(path).suspicions] == ["recording.checksum-differs"]
    with pytest.warns(VasowaveWarning, match="'PAP' do not add up"):
        read_raw_recording(path)


def labview_with_times_of_each():
    head = "LabVIEW Measurement\t\nX_Columns\tMulti\n***End_of_Header***\t\nChannels\t2\t\t\t\n"
    head += f"Samples\t{COUNT}\t\t{COUNT // 2}\t\nY_Unit_Label\tmmHg\t\tml/s\t\nDelta_X\t0.001\t\t0.002\t\n"
    head += "***End_of_Header***\t\t\t\t\nX_Value\tPAP\tX_Value\tPA flow\tComment\n"
    return head + rows(lambda i, t, p, q: f"{t:.6f}\t{p:.6f}\t" + (
        f"{TIME[2 * i]:.6f}\t{FLOW[2 * i]:.6f}" if 2 * i < COUNT else "\t"))  # fmt: skip


def test_labviews_signals_with_their_own_times_are_read_at_their_own_rates_without_a_doubt(tmp_path):
    (tmp_path / "a.lvm").write_text(labview_with_times_of_each())
    recording = read_raw_recording(tmp_path / "a.lvm")
    assert recording.flow[50:2900] == pytest.approx(FLOW[50:2900], abs=2e-3)
    assert not describe_recording(tmp_path / "a.lvm").suspicions


def test_channels_of_one_title_are_told_apart_by_their_units(tmp_path):
    head = 'ATF\t1.0\n7\t3     \n"AcquisitionMode=Gap Free"\n"Comment="\n"YTop=100,100"\n"YBottom=-100,-100"\n'
    head += '"SweepStartTimesMS=0.000"\n"SignalsExported=PAP,PA flow"\n"Signals="\t"PAP"\t"PA flow"\n'
    head += '"Time (s)"\t"Trace #1 (mmHg)"\t"Trace #1 (mL/s)"\n'
    (tmp_path / "a.atf").write_text(head + rows(lambda i, t, p, q: f"{t:.4f}\t{p:.5f}\t{q:.6f}"))
    recording = read_raw_recording(tmp_path / "a.atf", pressure="Trace #1", flow="Trace #1")
    assert recording.pressure == pytest.approx(PRESSURE, abs=1e-4)
    assert recording.flow == pytest.approx(FLOW, abs=1e-5)
