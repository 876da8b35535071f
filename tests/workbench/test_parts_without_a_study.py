"""Parts of the workbench by themselves: what is kept in memory, what a door refuses, what an error becomes."""

import asyncio
import errno
import json
import socket
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from vasowave.errors import InputError
from vasowave.recording import RawRecording
from vasowave.workbench import figures, recordings, server
from vasowave.workbench.access import Guarded

RATE = 1000.0


def raw(count, origin=0.0, beside=(), level=10.0):
    values = level + np.arange(count) / 1000
    return RawRecording(values, 0.1 * values, RATE, origin=origin, beside=beside)


def row(tmp_path, name="one.txt", **more):
    path = tmp_path / name
    path.write_text("x")
    given = {"start": None, "end": None, "zero": None, "pressure_gain": None, "flow_gain": None, "animal": name}
    return SimpleNamespace(recordings=(path,), **(given | more))


def opened_as(monkeypatch, recording):
    monkeypatch.setattr(recordings, "read_stretch", lambda row: recording)
    monkeypatch.setattr(recordings, "replace", lambda row, **more: row)
    monkeypatch.setattr(recordings, "_channels", lambda row: {})
    return recordings._opened(SimpleNamespace())


def test_pieces_of_a_recording_stand_where_they_were_recorded_and_nothing_between_them(monkeypatch):
    other = raw(1000, origin=1.5, level=20.0)
    opened = opened_as(monkeypatch, raw(1100, origin=0.1, beside=(other,)))
    values = opened.traces["pressure"].values
    assert (len(values), opened.duration, opened.whole) == (2500, 2.5, None)
    assert np.isnan(values[:100]).all()
    assert values[100:1200] == pytest.approx(10 + np.arange(1100) / 1000)
    assert np.isnan(values[1200:1500]).all()
    assert values[1500:] == pytest.approx(20 + np.arange(1000) / 1000)
    assert set(opened.traces) == {"pressure", "flow"}
    late = opened_as(monkeypatch, raw(1000, origin=0.1))
    assert (late.duration, late.whole) == (1.1, None)
    whole = raw(1000)
    assert opened_as(monkeypatch, whole).whole is whole


def test_few_recordings_are_kept_and_fewer_of_long_ones_the_last_looked_at_first(monkeypatch, tmp_path):
    made = []
    monkeypatch.setattr(
        recordings, "_opened", lambda row: made.append(row.animal) or SimpleNamespace(duration=1.0, rate=RATE)
    )
    kept = recordings.Recordings()
    rows = [row(tmp_path, f"{name}.txt") for name in "abcd"]
    kept.opened(rows[0])
    for one in (rows[1], rows[2], rows[0], rows[3], rows[0], rows[2], rows[1]):
        kept.opened(one)
    assert made == ["a.txt", "b.txt", "c.txt", "d.txt", "b.txt"]
    monkeypatch.setattr(recordings, "_MOST", 2000)
    kept.opened(rows[3])
    assert len(kept._opened) == 2
    monkeypatch.setattr(recordings, "_MOST", 1999)
    kept.opened(rows[0])
    assert len(kept._opened) == 1


def test_a_recording_is_read_anew_when_its_file_or_what_the_row_says_of_it_changes(monkeypatch, tmp_path):
    made = []
    monkeypatch.setattr(recordings, "_opened", lambda row: made.append(1) or SimpleNamespace(duration=1.0, rate=RATE))
    kept, one = recordings.Recordings(), row(tmp_path)
    for change in ({}, {"start": 1.0}, {"zero": 2.0}, {"pressure_gain": 2.0}):
        kept.opened(SimpleNamespace(**(vars(one) | change)))
    assert len(made) == 1
    kept.opened(SimpleNamespace(**(vars(one) | {"channel": "x"})))
    one.recordings[0].write_text("xy")
    kept.opened(one)
    assert len(made) == 3


@pytest.mark.parametrize(
    ("start", "end", "width"), [(1.0, 1.0, 10), (2.0, 1.0, 10), (0.0, 1.0, 0), (0.0, 1.0, 4001), (0.0, np.inf, 10)]
)
def test_a_stretch_that_is_none_is_refused(start, end, width):
    with pytest.raises(InputError, match="a stretch begins before it ends"):
        recordings.Recordings().trace(None, "a", "pressure", start, end, width)


@pytest.mark.parametrize("count", [1, 31, 32, 33, 129, 5000])
def test_lowest_and_highest_values_of_parts_are_those_of_their_samples(count):
    """By every sample that a part touches: parts wider than two blocks are looked up in the blocks around them."""
    values = np.random.default_rng(count).normal(0, 1, count).astype(np.float32)
    trace = recordings.Trace(values, RATE)
    for start, end, width in ((0.0, count / RATE, 7), (-0.01, count / RATE + 0.01, 5), (0.0, count / RATE / 3, 3)):
        found = trace.between(start, end, width)
        edges = np.linspace(start, end, width + 1) * RATE
        block = max([1, *(n for n, _ in trace.levels if 2 * n <= (edges[-1] - edges[0]) / width)])
        for part, (low, high) in enumerate(pairwise(edges)):
            first = max(int(np.floor(low / block)), 0) * block
            last = max(int(np.ceil(high / block)), int(np.floor(low / block)) + 1) * block
            own = values[first : max(last, 0)] if high > 0 else values[:0]
            expected = (own.min(), own.max()) if len(own) else (np.nan, np.nan)
            assert found[:, part] == pytest.approx(expected, nan_ok=True), (start, part)


def test_levels_of_a_trace_hold_32_samples_and_then_four_times_as_many():
    assert [count for count, _ in recordings.Trace(np.zeros(32), RATE).levels] == []
    assert [count for count, _ in recordings.Trace(np.zeros(33), RATE).levels] == [32]
    assert [count for count, _ in recordings.Trace(np.zeros(129), RATE).levels] == [32, 128]
    assert [one.shape for _, one in recordings.Trace(np.zeros(129), RATE).levels] == [(2, 5), (2, 2)]


def test_a_websocket_is_closed_and_other_protocols_are_not_answered():
    sent = []

    async def send(message):
        sent.append(message)

    guarded = Guarded(None, "token", 1)
    asyncio.run(guarded({"type": "websocket"}, None, send))
    assert sent == [{"type": "websocket.close", "code": 1008}]
    asyncio.run(guarded({"type": "lifespan"}, None, send))
    assert len(sent) == 1


def test_what_nobody_foresaw_is_told_and_a_full_disk_by_its_own_number():
    full = asyncio.run(server._unforeseen(None, OSError(errno.ENOSPC, "no space")))
    assert (full.status_code, json.loads(full.body)["error"][:26]) == (507, "no space left on the disk;")
    other = asyncio.run(server._unforeseen(None, ValueError("odd")))
    assert other.status_code == 500
    assert json.loads(other.body)["error"].startswith("the workbench failed here (ValueError: odd)")
    assert asyncio.run(server._refused(None, InputError("no"))).status_code == 400


def test_messages_and_sizes_that_are_none_are_refused():
    assert server._size("") is None
    assert server._size("0.002") == 0.002
    with pytest.raises(InputError, match=f"'{'x' * 40}' is no size"):
        server._size("x" * 50)
    assert server._message(b'{"do": 1}') == {"do": 1}
    for body in (b"[1]", b"{", b"\xff", b"[" * 100_000):
        with pytest.raises(InputError, match="no message"):
            server._message(body)


def test_a_port_that_is_taken_is_named():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(InputError, match=f"port {port}: address already in use; give another"), server._door(port):
            pass


def test_the_line_of_python_beside_a_figure_writes_the_same(tmp_path):
    place = SimpleNamespace(folder=tmp_path)
    wish = figures.Wish(animal="CTL 1", panels=["pressure"], width=90.0, font=7.5, format="pdf")
    assert figures.line_of(place, wish) == (
        f"import vasowave as vw; vw.read_results('{tmp_path}')['CTL 1'].plot.save('figure.pdf', ['pressure'], "
        "width=90, height=60, font=7.5, family='sans-serif', color='#00a7c4')"
    )
    line = figures.line_of(place, replace(wish, animal="", group="HPH"))
    assert line == f"import vasowave as vw; vw.read_results('{tmp_path}').compare('HPH').save('figure.pdf')"
