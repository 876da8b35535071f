"""Files of pressure and volume of a ventricle: channels, units, and a conductance that is not a volume yet."""

import numpy as np
import pytest
from openpyxl import Workbook

from vasowave.base import InputError
from vasowave.catheter import read_loops, read_raw_recording

TIME = np.arange(0, 3, 0.001)
TURN = 2 * np.pi * 8 * TIME
PRESSURE, VOLUME = 14 - 12 * np.cos(TURN - 1), 0.030 + 0.01 * np.cos(TURN)  # mmHg, ml
PARTS = {"artery": 20 + 3 * np.cos(TURN), "magnitude": 800 + np.cos(TURN), "phase": 5 + np.cos(TURN)}


def table(path, **columns):
    """Write a table whose titles have brackets in place of what names cannot hold."""
    titles = {"time [s]": TIME} | columns
    rows = "\n".join(",".join(f"{value:.7g}" for value in row) for row in zip(*titles.values(), strict=True))
    path.write_text(",".join(titles) + "\n" + rows + "\n", encoding="utf-8")
    return path


def labchart(path, units, titles=("RV Pressure", "PAP", "Volume", "Magnitude", "Phase"), scale=1000.0):
    head = "Interval=\t0.001 s\nTimeFormat=\tStartOfBlock\nChannelTitle=\t" + "\t".join(titles) + "\n"
    columns = (TIME, PRESSURE, PARTS["artery"], scale * VOLUME, PARTS["magnitude"], PARTS["phase"])
    rows = "\n".join("\t".join(f"{value:.7g}" for value in row) for row in zip(*columns, strict=True))
    path.write_text(head + "UnitName=\t" + "\t".join(units) + "\n" + rows + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("pressure", "volume", "scale"),
    [("LVP [mmHg]", "LVV [µL]", 1000), ("RVP [kPa]", "RV volume [ml]", 1), ("Pressure (mmHg)", "Volume (uL)", 1000),
     ("LV pressure [mmHg]", "Vol [mm3]", 1000), ("p_mmHg", "volume_ul", 1000)],
)  # fmt: skip
def test_titles_of_ventricles_and_units_of_volume_are_read(tmp_path, pressure, volume, scale):
    factor = 0.133322 if "kPa" in pressure else 1.0
    file = table(
        tmp_path / "v.csv", **{"PAP [mmHg]": PARTS["artery"], pressure: factor * PRESSURE, volume: scale * VOLUME}
    )
    found = read_loops(file)
    assert found.pressure == pytest.approx(PRESSURE, rel=1e-4, abs=1e-3)
    assert found.volume == pytest.approx(VOLUME, rel=1e-5)
    assert found.sampling_rate == pytest.approx(1000)


def test_labchart_with_an_artery_and_raw_conductance_beside_gives_the_ventricle(tmp_path):
    file = labchart(tmp_path / "lab.txt", ("mmHg", "mmHg", "µL", "µS", "deg"))
    found = read_loops(file, start=1.0, end=2.5)
    assert found.pressure == pytest.approx(PRESSURE[1000:2500], rel=1e-5)
    assert found.volume == pytest.approx(VOLUME[1000:2500], rel=1e-5)
    assert found.origin == 1.0


def test_a_workbook_is_read(tmp_path):
    book = Workbook()
    sheet = book.active
    sheet.append(["time [s]", "LVP [mmHg]", "LVV [µl]"])
    for row in zip(TIME[:1500], PRESSURE, 1000 * VOLUME, strict=False):
        sheet.append([float(value) for value in row])
    book.save(tmp_path / "v.xlsx")
    assert read_loops(tmp_path / "v.xlsx").volume == pytest.approx(VOLUME[:1500])


def test_relative_units_are_no_volume_until_their_gain_is_given(tmp_path):
    file = labchart(tmp_path / "lab.txt", ("mmHg", "mmHg", "RVU", "V", "V"), scale=100.0)
    with pytest.raises(InputError, match="RVU are relative units, no volume"):
        read_loops(file)
    found = read_loops(file, volume_gain=0.02, volume_offset=-0.003, parallel_volume=0.01, alpha=0.5)
    assert found.volume == pytest.approx((0.02 * 100 * VOLUME - 0.003 - 0.01) / 0.5)
    assert "loops.volume-calibrated" in [note.code for note in found.notes]


def test_a_volume_without_a_unit_is_asked_for_and_a_gain_beside_a_unit_is_refused(tmp_path):
    bare = table(tmp_path / "bare.csv", **{"LVP [mmHg]": PRESSURE, "Volume": 1000 * VOLUME})
    with pytest.raises(InputError, match="volume has no unit"):
        read_loops(bare)
    assert read_loops(bare, volume_unit="ul").volume == pytest.approx(VOLUME, rel=1e-5)
    united = table(tmp_path / "united.csv", **{"LVP [mmHg]": PRESSURE, "Volume [ul]": 1000 * VOLUME})
    with pytest.raises(InputError, match="is in ul already"):
        read_loops(united, volume_gain=2.0)
    with pytest.raises(InputError, match="belongs to its gain"):
        read_loops(united, volume_offset=2.0)
    assert read_loops(united, alpha=0.8).volume == pytest.approx(VOLUME / 0.8, rel=1e-5)


def test_two_ventricles_and_conductance_alone_are_asked_about(tmp_path):
    both = {"LVP [mmHg]": PRESSURE, "RVP [mmHg]": PRESSURE / 4, "LVV [ul]": 1000 * VOLUME}
    with pytest.raises(InputError, match="2 channels may hold pressure"):
        read_loops(table(tmp_path / "both.csv", **both))
    assert read_loops(tmp_path / "both.csv", pressure="RVP").pressure == pytest.approx(PRESSURE / 4, rel=1e-5)
    raw = {"LVP [mmHg]": PRESSURE, "Magnitude": PARTS["magnitude"], "Phase": PARTS["phase"]}
    with pytest.raises(InputError, match="no channel says that it holds volume"):
        read_loops(table(tmp_path / "raw.csv", **raw))


def test_an_artery_alone_is_not_taken_for_the_ventricle(tmp_path):
    with pytest.raises(InputError, match="no channel says that it holds pressure"):
        read_loops(table(tmp_path / "a.csv", **{"PAP [mmHg]": PARTS["artery"], "LVV [ul]": 1000 * VOLUME}))


def test_units_that_both_channels_lack_are_asked_for_together_and_no_flow_is_a_volume(tmp_path):
    bare = table(tmp_path / "bare.csv", **{"LVP": PRESSURE, "LVV": 1000 * VOLUME})
    with pytest.raises(InputError, match=r"(?s)pressure has no unit.*volume has no unit"):
        read_loops(bare)
    per_second = table(tmp_path / "mls.csv", **{"LVP_mmHg": PRESSURE, "LVV_mls": VOLUME})
    with pytest.raises(InputError, match="'ml/s' is not a unit of volume"):
        read_loops(per_second)
    assert read_loops(per_second, volume_unit="ml").volume == pytest.approx(VOLUME, rel=1e-5)
    beside = table(tmp_path / "beside.csv", **{"PAP_mmHg": PARTS["artery"], "LVV_mls": VOLUME})
    with pytest.raises(InputError, match="no channel says that it holds flow"):
        read_raw_recording(beside)


def test_what_a_file_holds_is_listed_with_the_raw_conductance(tmp_path):
    raw = table(tmp_path / "raw.csv", **{"LVP [mmHg]": PRESSURE, "Magnitude": PARTS["magnitude"]})
    with pytest.raises(InputError, match=r"it has: 'LVP' \[mmHg\], 'Magnitude' \[no unit\]"):
        read_loops(raw)


def test_two_files_are_joined_on_their_clocks(tmp_path):
    table(tmp_path / "pressure.csv", **{"LVP [mmHg]": PRESSURE})
    rows = "\n".join(f"{time:.4f},{volume:.7g}" for time, volume in zip(TIME[500:], 1000 * VOLUME[500:], strict=True))
    (tmp_path / "volume.csv").write_text(f"time [s],LVV [ul]\n{rows}\n", encoding="utf-8")
    joined = read_loops(tmp_path / "pressure.csv", tmp_path / "volume.csv")
    assert joined.pressure == pytest.approx(PRESSURE[500:], abs=1e-4)
    assert joined.volume == pytest.approx(VOLUME[500:], rel=1e-5)
    assert "recording.joined" in [note.code for note in joined.notes]


def test_a_volume_that_comes_late_is_made_earlier_by_its_delay(tmp_path):
    delay = 0.0124  # no whole number of samples
    late = 0.030 + 0.01 * np.cos(TURN - 2 * np.pi * 8 * delay)
    file = table(tmp_path / "late.csv", **{"LVP [mmHg]": PRESSURE, "LVV [ml]": late})
    advanced = read_loops(file, volume_delay=delay)
    assert advanced.volume[5:-5] == pytest.approx(VOLUME[5 : len(advanced.volume) - 5], abs=1e-5)
    assert advanced.pressure == pytest.approx(PRESSURE[: len(advanced.pressure)], abs=1e-4)
    early = read_loops(file, volume_delay=-delay)
    assert early.origin == pytest.approx(0.013)
    with pytest.raises(InputError, match="give s"):
        read_loops(file, volume_delay=12.4)
