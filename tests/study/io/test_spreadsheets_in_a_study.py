"""Excel workbooks wherever a table is read: in a study."""

import warnings

import numpy as np
import openpyxl
import pytest

import vasowave as vw
from vasowave.base import InputError
from vasowave.catheter.read import kind_of
from vasowave.study.folder import read_animals


def saved(path, *rows, **sheets):
    """Save rows with openpyxl, an independent implementation of the format."""
    book = openpyxl.Workbook()
    for row in rows:
        book.active.append(row)
    for title, more in sheets.items():
        page = book.create_sheet(title)
        for row in more:
            page.append(row)
    book.save(path)
    return path


HEADER = ("name", "parent", "length [mm]", "radius [mm]")
NETWORK = [HEADER, ("main", None, 4.1, 0.47), ("left", "main", 4.5, 0.26), ("right", "main", 4.4, 0.2)]


def test_a_network_typed_into_a_spreadsheet_is_read_to_the_last_bit(tmp_path):
    network = vw.read_network(saved(tmp_path / "lung.xlsx", *NETWORK))
    assert network.name == ("main", "left", "right")
    assert network.radius.tolist() == [0.1 * 0.47, 0.1 * 0.26, 0.1 * 0.2]


def test_vessels_numbered_as_numbers_keep_their_names(tmp_path):
    rows = [NETWORK[0], (1, None, 4.1, 0.47), (2, 1, 4.5, 0.26), (2.1, 1, 4.4, 0.2)]
    network = vw.read_network(saved(tmp_path / "lung.xlsx", *rows))
    assert network.name == ("1", "2", "2.1")
    assert network.parent.tolist() == [-1, 0, 0]


def test_an_averaged_cycle_and_a_continuous_recording_are_read_and_told_apart(tmp_path):
    mouse = vw.virtual_mouse()
    head = ("time [s]", "pressure [mmHg]", "flow [ml/s]")
    rows = list(zip(*(values.tolist() for values in (mouse.time, mouse.pressure, mouse.flow)), strict=True))
    cycle = saved(tmp_path / "cycle.xlsx", head, *rows)
    again = vw.read_recording(cycle)
    np.testing.assert_allclose(again.pressure, mouse.pressure, rtol=1e-14)  # openpyxl writes 16 digits
    np.testing.assert_allclose(again.flow, mouse.flow, rtol=1e-12, atol=1e-15)
    t = np.round(np.arange(4000) * 1e-3, 3).tolist()
    long = saved(tmp_path / "long.xlsx", head, *((one, 20.0 + one, 0.2) for one in t))
    raw = vw.read_raw_recording(long)
    np.testing.assert_allclose(raw.pressure, 20.0 + np.array(t), rtol=1e-14)
    assert raw.sampling_rate == pytest.approx(1000)
    assert (kind_of([cycle]), kind_of([long])) == ("cycle", "raw")


def test_the_table_of_animals_may_be_a_spreadsheet(tmp_path):
    saved(tmp_path / "lung.xlsx", *NETWORK)
    (tmp_path / "c.csv").write_text("")
    rows = [("animal", "group", "network", "recording", "period [s]"), ("mouse 6", "CTL", "lung.xlsx", "c.csv", 0.11)]
    animals, problems = read_animals(saved(tmp_path / "animals.xlsx", *rows), ["CTL"])
    assert not [one for one in problems if one.error]
    assert (animals[0].animal, animals[0].period, animals[0].line) == ("mouse 6", 0.11, 2)


def test_every_cut_and_every_flipped_byte_of_a_workbook_is_read_or_refused(tmp_path):
    whole = saved(tmp_path / "t.xlsx", *NETWORK).read_bytes()
    rng = np.random.default_rng(4)
    refused = 0
    for trial in range(300):
        raw = bytearray(whole)
        for at in rng.integers(0, len(raw), 1 + trial % 4):
            raw[at] = rng.integers(256)
        (tmp_path / "d.xlsx").write_bytes(raw[: rng.integers(1, len(raw))] if trial % 5 == 0 else raw)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                network = vw.read_network(tmp_path / "d.xlsx")
        except InputError:
            refused += 1
        else:  # what was hit was of no consequence
            assert network.radius.tolist() == [0.1 * 0.47, 0.1 * 0.26, 0.1 * 0.2]
    assert refused > 100
