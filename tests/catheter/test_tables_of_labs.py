"""Tables as labs keep them: thousands with marks, a row a sample, animals beside each other, rows below the numbers."""

import io
import zipfile

import numpy as np
import pytest
from scipy.io import savemat

from made_workbook import saved
from vasowave.base import InputError
from vasowave.catheter import read_raw_recording, read_recording
from vasowave.catheter.read import kind_of

TIME = np.arange(4000) / 1000.0
PRESSURE = 900.0 + 400.0 * np.sin(2 * np.pi * 8.0 * TIME)  # Pa
FLOW = 9000.0 + 5000.0 * np.sin(2 * np.pi * 8.0 * TIME)  # ul/min
ROWS = list(zip(TIME, PRESSURE, FLOW, strict=True))


def is_read(raw):
    np.testing.assert_allclose(raw.pressure, PRESSURE * 10 / 1333.22, rtol=1e-3)
    np.testing.assert_allclose(raw.flow, FLOW * 1e-3 / 60, rtol=1e-3)
    assert raw.sampling_rate == pytest.approx(1000.0)


def exchanged(text, thousand, decimal):
    return text.replace(",", "t").replace(".", decimal).replace("t", thousand)


@pytest.mark.parametrize(("thousand", "decimal"), [(",", "."), (".", ","), ("'", "."), ("\u00a0", ","), (" ", ",")])
@pytest.mark.parametrize("separator", ["\t", ";"])
def test_marks_between_thousands_are_left_out(tmp_path, thousand, decimal, separator):
    cells = [[exchanged(f"{value:,.3f}", thousand, decimal) for value in row] for row in ROWS]
    head = separator.join(["time [s]", "pressure [Pa]", "flow [ul/min]"])
    file = tmp_path / "a.txt"
    file.write_text("\n".join([head, *map(separator.join, cells), ""]), encoding="utf-8")
    is_read(read_raw_recording(file))


@pytest.mark.parametrize(("thousand", "decimal"), [(",", "."), (".", ",")])
def test_marks_between_thousands_of_whole_times_are_told_by_the_decimals_of_other_columns(tmp_path, thousand, decimal):
    head = "time [ms];pressure [Pa];flow [ul/min]"
    rows = [";".join(exchanged(text, thousand, decimal) for text in (f"{1000 * t:,.0f}", f"{p:.2f}", f"{q:.2f}"))
            for t, p, q in ROWS]  # fmt: skip
    (tmp_path / "a.csv").write_text("\n".join([head, *rows, ""]))
    is_read(read_raw_recording(tmp_path / "a.csv"))


@pytest.mark.parametrize(("step", "unit"), [(0.001, "in seconds"), (1, "in ms")])
def test_a_long_table_whose_times_name_no_unit_is_a_recording_and_asks_for_what_alone_it_can_be(tmp_path, step, unit):
    rows = [f"{i * step:g},{20 + i % 10}.5,0.{i % 10}" for i in range(3000)]
    (tmp_path / "a.csv").write_text("\n".join(["time,pressure [mmHg],flow [ml/s]", *rows, ""]))
    assert kind_of([tmp_path / "a.csv"]) == "raw"
    with pytest.raises(InputError, match=rf"'time' has no unit.* If its times are {unit}, these are 1000\n") as error:
        read_raw_recording(tmp_path / "a.csv")
    assert [cure.cells for cure in error.value.cures] == [(("sampling rate [1/s]", "1000"),)]


def test_commas_separate_thousands_between_quotation_marks_and_columns_elsewhere(tmp_path):
    quoted = ['"time [s]","pressure [Pa]","flow [ul/min]"']
    quoted += [",".join(f'"{value:,.3f}"' for value in row) for row in ROWS]
    (tmp_path / "quoted.csv").write_text("\n".join([*quoted, ""]))
    is_read(read_raw_recording(tmp_path / "quoted.csv"))
    plain = ["time [ms],flow [ul/s]", *(f"{i},{200 + 100 * (i % 10) + 0.5}" for i in range(4000))]
    (tmp_path / "plain.csv").write_text("\n".join([*plain, ""]))
    (tmp_path / "p.csv").write_text(
        "\n".join(["time [ms],pressure [mmHg]", *(f"{i},{i % 10}.5" for i in range(4000)), ""])
    )
    flow = read_raw_recording(tmp_path / "p.csv", tmp_path / "plain.csv").flow
    assert flow[:3] == pytest.approx([0.2005, 0.3005, 0.4005])


def test_marks_both_ways_round_are_no_thousands(tmp_path):
    rows = [
        "time [s]\tpressure [mmHg]\tflow [ml/s]",
        "0\t1,234.5\t2.345,6",
        *(f"{i}\t{i}.5\t{i}.5" for i in range(1, 9)),
        "",
    ]
    (tmp_path / "a.txt").write_text("\n".join(rows))
    with pytest.raises(InputError, match="decimal comma"):
        read_raw_recording(tmp_path / "a.txt")


def test_a_row_a_sample_of_one_signal_is_a_column_a_signal(tmp_path):
    signals = (("PA pressure", "Pa", PRESSURE), ("PA flow", "ul/min", FLOW))
    rows = [f'"{i}","KO5",{t:.3f},"{name}",{value:.4f},"{unit}"' for name, unit, values in signals
            for i, (t, value) in enumerate(zip(TIME, values, strict=True))]  # fmt: skip
    (tmp_path / "a.csv").write_text("\n".join(['"","animal","time_s","signal","value","unit"', *rows, ""]))
    is_read(read_raw_recording(tmp_path / "a.csv"))


def cycle(mean):
    return mean + 5.0 * np.sin(2 * np.pi * np.arange(40) / 40)


def test_of_several_animals_in_a_long_table_one_is_asked_for_by_name(tmp_path):
    rows = [["mouse", "time_ms", "variable", "value", "unit"]]
    for number, (name, period) in enumerate((("WT1", 120), ("WT2", 110))):
        for i, pressure in enumerate(cycle(15 + number)):
            rows += [
                [name, i * period / 40, "pressure", pressure, "mmHg"],
                [name, i * period / 40, "flow", pressure / 100, "ml/s"],
            ]
    file = saved(tmp_path / "a.xlsx", A=rows)
    with pytest.raises(InputError, match="wt1, wt2; name the subject"):
        read_recording(file)
    one = read_recording(file, subject_row="WT2")
    assert (one.period, one.mean_pressure, one.flow.mean()) == pytest.approx((0.11, 16.0, 0.16))


def test_animals_beside_each_other_below_titles_of_their_own_are_read_by_name(tmp_path):
    rows = [["time", "Rat 1", "", "Rat 2", ""], ["ms", *["P (mmHg)", "Q (ml/s)"] * 2]]
    rows += [[3 * i, p, p / 10, p + 4, p / 20] for i, p in enumerate(cycle(20.0))]
    file = saved(tmp_path / "a.xlsx", A=rows)
    second = read_recording(file, subject_row="rat 2")
    assert (second.mean_pressure, second.flow.mean()) == pytest.approx((24.0, 1.0))
    with pytest.raises(InputError, match="no columns of 'rat 3'"):
        read_recording(file, subject_row="rat 3")


def test_the_flow_of_the_animal_whose_pressure_is_named_is_read(tmp_path):
    head = "time [s],P rat1 [Pa],P rat2 [Pa],Q rat1 [ul/min],Q rat2 [ul/min]"
    rows = [f"{t:.3f},{p / 2:.3f},{p:.3f},{q / 2:.3f},{q:.3f}" for t, p, q in ROWS]
    (tmp_path / "a.csv").write_text("\n".join([head, *rows, ""]))
    is_read(read_raw_recording(tmp_path / "a.csv", pressure="P rat2"))


def test_rows_below_the_numbers_are_left_out_and_named_but_not_those_between(tmp_path):
    head, rows = "time [s];pressure [Pa];flow [ul/min]", [f"{t:.3f};{p:.3f};{q:.3f}" for t, p, q in ROWS]
    below = ["Mean;900;9000", "End of recording"]
    (tmp_path / "a.csv").write_text("\n".join([head, *rows, *below, ""]))
    raw = read_raw_recording(tmp_path / "a.csv")
    is_read(raw)
    assert any("'Mean', 'End of recording'" in str(note) for note in raw.notes)
    (tmp_path / "b.csv").write_text("\n".join([head, *rows[:2000], *below, *rows[2000:], ""]))
    with pytest.raises(InputError, match="line 2002"):
        read_raw_recording(tmp_path / "b.csv")


def test_names_of_matlab_say_their_units(tmp_path):
    fields = {"fs": 1000.0, "PAP_Pa": PRESSURE / 1e3, "Flow_uLmin": FLOW}
    savemat(tmp_path / "a.mat", {"rec": {"fs": 1000.0, "PAP_kPa": fields["PAP_Pa"], "Flow_uL_per_min": FLOW}})
    is_read(read_raw_recording(tmp_path / "a.mat"))
    savemat(tmp_path / "b.mat", {"t_ms": 3.0 * np.arange(40), "p_kPa": 0.133322 * cycle(15.0), "q_mLmin": cycle(60.0)})
    one = read_recording(tmp_path / "b.mat")
    assert (one.period, one.mean_pressure, one.flow.mean()) == pytest.approx((0.12, 15.0, 1.0))


def test_numbered_columns_without_a_unit_are_called_as_they_are_in_the_file(tmp_path):
    head = ",".join(["id", *(f"p_{i}" for i in range(40)), *(f"q_{i} [ml/s]" for i in range(40))])
    (tmp_path / "a.csv").write_text("\n".join([head, ",".join(["m1", *map(str, [*cycle(15.0), *cycle(10.0)])]), ""]))
    with pytest.raises(InputError, match="'p_0 to p_39' has no unit"):
        read_recording(tmp_path / "a.csv", subject_row="m1", period=0.1)


def test_an_archive_is_named_by_what_it_holds(tmp_path):
    with zipfile.ZipFile(tmp_path / "a.zip", "w") as archive:
        archive.writestr("pig/raw.csv", "time [s],pressure [mmHg]\n")
        archive.writestr("__MACOSX/raw.csv", "x")
    with pytest.raises(InputError, match=r"holds pig/raw\.csv; unpack it"):
        read_raw_recording(tmp_path / "a.zip")
    import gzip

    (tmp_path / "a.csv.gz").write_bytes(gzip.compress(io.BytesIO(b"time\n" * 99).read()))
    with pytest.raises(InputError, match="gzip; unpack it"):
        read_raw_recording(tmp_path / "a.csv.gz")


def long_rows():
    return [f"{name},{t:.3f},{value:.4f},{unit}"
            for name, unit, values in (("pressure", "Pa", PRESSURE), ("flow", "ul/min", FLOW))
            for t, value in zip(TIME, values, strict=True)]  # fmt: skip


@pytest.mark.parametrize(("damaged", "words"), [("flow,0.1", "2 columns where 4"), ('"flow,0.1,1', "quotation")])
def test_a_damaged_row_of_a_long_table_is_named_by_its_line(tmp_path, damaged, words):
    rows = ["signal,time [s],value,unit", *long_rows()]
    rows[101] = damaged
    (tmp_path / "a.csv").write_text("\n".join([*rows, ""]))
    with pytest.raises(InputError, match=f"line 102: .*{words}"):
        read_raw_recording(tmp_path / "a.csv")


def test_of_a_long_table_that_is_cut_off_the_last_row_is_left_out_and_that_is_noted(tmp_path):
    (tmp_path / "a.csv").write_text("\n".join(["signal,time [s],value,unit", *long_rows(), "flow,4.0"]))
    with pytest.warns(match="cut off"):
        raw = read_raw_recording(tmp_path / "a.csv")
    is_read(raw)


def test_of_two_pressures_of_one_animal_none_is_taken(tmp_path):
    head = "time [ms],R05 P [mmHg],R05 PAP [mmHg],R05 flow [ml/s],R06 P [mmHg],R06 flow [ml/s]"
    rows = [f"{3 * i},{p},{p + 40},{p / 10},{p + 4},{p / 20}" for i, p in enumerate(cycle(20.0))]
    (tmp_path / "a.csv").write_text("\n".join([head, *rows, ""]))
    with pytest.raises(InputError, match=r"'R05 P \[mmHg\]' and 'R05 PAP \[mmHg\]' are each a pressure of 'R05'"):
        read_recording(tmp_path / "a.csv", subject_row="R05")
    assert read_recording(tmp_path / "a.csv", subject_row="r06").mean_pressure == pytest.approx(24.0)


def test_the_flow_of_another_animal_is_not_taken(tmp_path):
    head = "time [s],rat 1 P [Pa],rat 1 Q [ul/min],rat 2 P [Pa]"
    rows = [f"{t:.3f},{p:.3f},{q:.3f},{p:.3f}" for t, p, q in ROWS]
    (tmp_path / "a.csv").write_text("\n".join([head, *rows, ""]))
    with pytest.raises(InputError, match="no channel says that it holds flow"):
        read_raw_recording(tmp_path / "a.csv", pressure="rat 2 P")
    is_read(read_raw_recording(tmp_path / "a.csv", pressure="rat 1 P"))


@pytest.mark.parametrize("title", ["animal", "Maus", "nr"])
@pytest.mark.parametrize("timed", [True, False])
def test_numbered_animals_of_a_long_table_are_not_joined(tmp_path, title, timed):
    rows = [row.split(",") for row in ("signal,time [s],value,unit", *long_rows())]
    head, *rows = [",".join(row if timed else [row[0], *row[2:]]) for row in rows]
    rows = [f"{title},{head}", *(f"{animal},{row}" for animal in (1, 2) for row in rows)]
    (tmp_path / "a.csv").write_text("\n".join([*rows, ""]))
    rate = None if timed else 1000.0
    with pytest.raises(InputError, match=f"it has: '{title.lower()} 1 pressure'"):
        read_raw_recording(tmp_path / "a.csv", sampling_rate=rate)
    is_read(read_raw_recording(tmp_path / "a.csv", pressure=f"{title} 2 pressure", sampling_rate=rate))


def test_numbered_stretches_of_a_long_table_whose_times_go_on_are_joined(tmp_path):
    rows = [f"{i // 1000 % 4},{row}" for i, row in enumerate(long_rows())]
    (tmp_path / "a.csv").write_text("\n".join(["beat,signal,time [s],value,unit", *rows, ""]))
    is_read(read_raw_recording(tmp_path / "a.csv"))


@pytest.mark.parametrize("time", ["0.123", "12.34"])
def test_a_mark_where_no_thousands_end_is_before_decimals(tmp_path, time):
    rows = ["time [s];pressure [Pa];flow [ml/s]", *(f"{time};1.234,{i};5" for i in range(40)), ""]
    (tmp_path / "a.csv").write_text("\n".join(rows))
    with pytest.raises(InputError, match=r"'1\.234,0'"):
        read_recording(tmp_path / "a.csv")


@pytest.mark.parametrize(
    ("head", "order"),
    [
        ("R05 P [mmHg],R05 Q [ml/s],R06 P [mmHg],R06 Q [ml/s],time [ms]", (2, 3, 4, 5, 1)),
        ("R05 t [ms],R06 time [ms],R05 P [mmHg],R05 Q [ml/s],R06 P [mmHg],R06 Q [ml/s]", (0, 1, 2, 3, 4, 5)),
        ("time [ms],R05 P [mmHg],R05 Q [ml/s],time2 [ms],R06 P [mmHg],R06 Q [ml/s]", (0, 2, 3, 1, 4, 5)),
    ],
)
def test_the_time_of_an_animal_is_read_wherever_it_stands(tmp_path, head, order):
    rows = [(2 * i, 3 * i, p, p / 10, p + 4, p / 20) for i, p in enumerate(cycle(20.0))]
    (tmp_path / "a.csv").write_text("\n".join([head, *(",".join(str(row[i]) for i in order) for row in rows), ""]))
    second = read_recording(tmp_path / "a.csv", subject_row="R06")
    assert (second.period, second.mean_pressure, second.flow.mean()) == pytest.approx((0.12, 24.0, 1.0))


def test_of_two_times_beside_each_other_none_is_guessed_and_faults_are_named_by_their_lines(tmp_path):
    head = "P R05 [mmHg],Q R05 [ml/s],P R06 [mmHg],Q R06 [ml/s]"
    rows = [f"{3 * i},{3 * i},{p},{p / 10},{p + 4},{p / 20}" for i, p in enumerate(cycle(20.0))]
    (tmp_path / "a.csv").write_text("\n".join([f"time [ms],time 2 [ms],{head}", *rows, ""]))
    with pytest.raises(InputError, match=r"'time \[ms\]' and 'time 2 \[ms\]' may both be times of 'r06'"):
        read_recording(tmp_path / "a.csv", subject_row="R06")
    rows = ["0,,,1,1", "0,20,x,1,1", "1,20,1,1,1"]
    (tmp_path / "b.csv").write_text("\n".join([f"time [ms],{head}", *rows, ""]))
    with pytest.raises(InputError, match="line 3, column 'flow'"):
        read_recording(tmp_path / "b.csv", subject_row="R05")


@pytest.mark.parametrize("in_blocks", [True, False])
def test_animals_below_each_other_are_told_apart_by_the_column_that_numbers_them(tmp_path, in_blocks):
    rows = [(t, number, p / number, q / number) for number in (1, 2) for t, p, q in ROWS]
    rows = rows if in_blocks else sorted(rows)
    text = "".join(f"{t:.3f},{number},male,{p:.4f},{q:.4f}\n" for t, number, p, q in rows)
    (tmp_path / "a.csv").write_text("time [s],mouse,sex,pressure [Pa],flow [ul/min]\n" + text)
    with pytest.raises(InputError, match="'mouse 2 pressure'"):
        read_raw_recording(tmp_path / "a.csv")
    is_read(read_raw_recording(tmp_path / "a.csv", pressure="mouse 1 pressure"))


def test_the_name_of_the_animal_in_every_row_is_no_signal(tmp_path):
    text = "".join(f"{t:.3f},KO9,{p:.4f},{q:.4f}\n" for t, p, q in ROWS)
    (tmp_path / "a.csv").write_text("time [s],mouse,pressure [Pa],flow [ul/min]\n" + text)
    is_read(read_raw_recording(tmp_path / "a.csv"))


def test_an_id_that_counts_packets_is_no_animal(tmp_path):
    text = "".join(f"{t:.3f},{i // 10},{p:.4f},{q:.4f}\n" for i, (t, p, q) in enumerate(ROWS))
    (tmp_path / "a.csv").write_text("time [s],id,pressure [Pa],flow [ul/min]\n" + text)
    is_read(read_raw_recording(tmp_path / "a.csv"))


MATRIX = np.column_stack([TIME, PRESSURE, FLOW])
LABELS, UNITS = ["Time", "PA pressure", "Q PA"], ["s", "Pa", "ul/min"]


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("inside", [False, True])
def test_the_columns_of_a_matrix_are_called_as_the_labels_beside_it(tmp_path, turned, inside):
    content = {"signals": MATRIX.T if turned else MATRIX, "names": np.array(LABELS, object), "units": np.array(UNITS)}
    savemat(tmp_path / "a.mat", {"rec": content} if inside else content)
    is_read(read_raw_recording(tmp_path / "a.mat"))


def test_labels_of_which_two_kinds_fit_name_no_columns(tmp_path):
    savemat(tmp_path / "a.mat", {"signals": MATRIX, "names": np.array(LABELS), "more": np.array(["a", "b", "c"])})
    with pytest.raises(InputError, match="no vectors"):
        read_raw_recording(tmp_path / "a.mat")


def test_what_a_table_without_any_unit_lacks_is_asked_for_at_once(tmp_path):
    rows = [f"{t:.3f},{p:.2f},{q:.4f}" for t, p, q in ROWS]
    (tmp_path / "a.csv").write_text("\n".join(["Time,SNUADC/PAP,SNUADC/PA_FLOW", *rows, ""]))
    with pytest.raises(InputError, match=r"(?s)'time' has no unit.*pressure has no unit.*flow has no unit") as caught:
        read_raw_recording(tmp_path / "a.csv")
    answers = dict(caught.value.cures[0].cells)
    assert set(answers) == {"sampling rate [1/s]", "pressure unit", "flow unit"}
    with pytest.raises(InputError) as caught:
        read_raw_recording(tmp_path / "a.csv", pressure_unit="Pa", flow_unit="ul/min")
    assert {title for cure in caught.value.cures for title, _ in cure.cells} == {"sampling rate [1/s]"}
