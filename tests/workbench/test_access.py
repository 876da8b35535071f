"""Whoever is not the page on this machine is refused, and the server lives on."""

import json
import re
import socket
import stat
import time
from contextlib import suppress
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from served import served

from vasowave.base import InputError
from vasowave.base.io import FOLDER_LOCK
from vasowave.workbench import Desk, access, in_a_browser, server

PAGE = Path(server.__file__).parent / "page"


@pytest.fixture(scope="module")
def door(kept_study):
    with served(kept_study) as one:
        yield one


def alive(door):
    return door.get("state")["study"]


@pytest.fixture
def impatient(monkeypatch):
    """A server that waits half a second where it waits twenty."""
    monkeypatch.setattr(access, "_PATIENCE", 0.5)


def test_the_page_answers_whoever_has_the_address(door):
    status, headers, body = door.raw("GET", door.root)
    assert (status, headers["content-type"]) == (200, "text/html; charset=utf-8")
    assert b"main.js" in body


def test_every_opening_has_another_key(kept_study, door):
    with served(kept_study) as one:
        assert one.root != door.root
        assert min(len(one.root), len(door.root)) > 32  # 24 bytes by chance


def test_without_the_key_or_with_one_that_is_nearly_right_there_is_nothing(door):
    root = door.root.rstrip("/")
    nearly = (root[:-1] + "/state", root + "x/state", root.swapcase() + "/state", root)
    for path in ("/", "/wrong/", "/wrong/state", "//state", "/%00/state", *nearly):
        status, _, body = door.raw("GET", path)
        assert (status, b"Open the address" in body) == (404, True), path


def test_a_browser_that_asks_for_an_icon_before_it_knows_the_key_gets_it_and_nothing_else(door):
    status, _, body = door.raw("GET", "/favicon.ico")
    assert (status, body[:4]) == (200, b"<svg")
    assert door.raw("POST", "/favicon.ico", b"{}")[0] in (403, 404)


def test_a_port_that_is_taken_is_named(kept_study, door):
    with pytest.raises(InputError, match=f"port {door.port}: address already in use; give another"):
        server.serve(kept_study, door.port, lambda *opened: None)


def test_a_browser_is_started_with_a_file_of_its_user_alone_and_without_the_key(door, started):
    file = in_a_browser(door.address, "#lung", door.guard)
    assert started == [file.as_uri()]
    assert door.root.strip("/") not in started[0] + file.read_text()
    assert stat.S_IMODE(file.stat().st_mode) == 0o600


def test_the_files_address_leads_to_the_page_once_and_the_file_is_gone_then(door, started):
    file = in_a_browser(door.address, "#recording/a", door.guard)
    ticket = urlsplit(re.search('url=([^"]*)"', file.read_text())[1]).path
    status, _, body = door.raw("GET", ticket, Sec_Fetch_Site="cross-site")  # a file's link is of another site
    assert (status, file.exists()) == (200, False)
    assert re.search(b'url=([^"]*)"', body)[1].decode() == f"{door.root}#recording/a"
    assert door.raw("GET", ticket)[0] == 404


def test_a_ticket_is_none_for_another_host_or_origin_or_anything_but_a_look(door):
    path = door.guard.ticket("", lambda: None)
    assert door.raw("GET", path, Host="evil.example")[0] == 421
    assert door.raw("GET", path, Origin="http://evil.example")[0] == 403
    assert door.raw("POST", path, b"{}")[0] == 404
    assert door.raw("GET", path + "state")[0] == 404
    assert door.raw("GET", path)[0] == 200


def test_where_the_users_folder_cannot_be_written_the_file_lies_elsewhere(door, started, monkeypatch, tmp_path):
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path / "file"))
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    assert in_a_browser(door.address, "", door.guard).parent == tmp_path / "state" / "vasowave"


@pytest.mark.parametrize(
    "host", ["evil.example", "127.0.0.1", "127.0.0.1:1", "evil.example:{port}", "", None, ["127.0.0.1:{port}", "evil"]]
)
def test_another_host_is_refused_and_so_is_a_second(door, host):
    """A page of another site whose name leads here (DNS rebinding) asks under its own name."""
    given = [one and one.format(port=door.port) for one in (host if isinstance(host, list) else [host])]
    assert door.raw("GET", door.root + "state", Host=given)[0] in (400, 421)


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "null", "http://127.0.0.1:1", "https://127.0.0.1:{port}", None]
)
def test_another_origin_changes_nothing(door, origin):
    given = origin.format(port=door.port) if origin else origin
    body = json.dumps({"do": "set-groups", "groups": ["A"]}).encode()
    assert door.raw("POST", door.root + "act", body, Origin=given)[0] == 403
    assert door.get("study")["groups"] == ["control", "hypoxic"]
    assert door.raw("GET", door.root + "state", Sec_Fetch_Site="cross-site")[0] == 403


def test_a_websocket_is_no_way_in(door):
    upgrade = {
        "Connection": "Upgrade",
        "Upgrade": "websocket",
        "Sec_WebSocket_Key": "x" * 22 + "==",
        "Sec_WebSocket_Version": "13",
    }
    assert door.raw("GET", "/wrong/", **upgrade)[0] in (400, 403, 404, 426)
    assert alive(door)


@pytest.mark.parametrize(
    "path",
    ["report/../study.yaml", "report/%2e%2e/study.yaml", "report/..%2fstudy.yaml", "report//etc/passwd",
     "report/%2fetc%2fpasswd", "page/../server.py", "page/%2e%2e%2fserver.py", "page/..", "report/%00",
     "report/" + "a/" * 3000],
)  # fmt: skip
def test_no_path_leads_out_of_the_study_or_the_page(door, path):
    status, _, body = door.raw("GET", (door.of_report if path.startswith("report/") else door.root) + path)
    assert status in (400, 404)
    assert b"groups" not in body
    assert b"root:" not in body
    assert b"import" not in body


def test_no_link_out_of_a_study_is_read_or_written_through(study):
    (study / "report").mkdir()
    (study.parent / "secret.html").write_text("secret", encoding="utf-8")
    (study / "report" / "report.html").symlink_to(study.parent / "secret.html")
    (study / "report" / "inner.html").symlink_to(study / "study.yaml")
    (study / "report" / "second.html").hardlink_to(study.parent / "secret.html")
    (study.parent / "elsewhere").mkdir()
    (study / "edits").symlink_to(study.parent / "elsewhere")
    with served(study) as door:
        for name in ("second", "report", "inner"):
            assert door.raw("GET", f"{door.of_report}report/{name}.html")[0] == 404
        status, answer = door.post("act", beats(["reject", 3.0, None]))
    assert (status, list((study.parent / "elsewhere").iterdir())) == (400, [])
    assert "inside this study" in answer["error"]


@pytest.mark.parametrize(
    "name", ["../out.csv", "/etc/passwd", "..", ".", "a/../../out.csv", "away/out.csv", "a\0b", "loop/x"]
)
def test_no_name_and_no_link_of_a_study_leads_out_of_it(study, name):
    (study.parent / "out.csv").write_text("1\n", encoding="utf-8")
    (study / "away").symlink_to(study.parent)
    (study / "loop").symlink_to("loop")
    with pytest.raises(InputError, match="not a file inside this study"):
        Desk(study).inside(name)


@pytest.mark.parametrize(
    "name",
    ["../evil.txt", "/etc/evil.txt", "a/../../evil.txt", "..", "", ".hidden.txt", "a/.git/b.txt", "a\0b.txt",
     "a\\b.txt", "con:x.txt", "x.exe", "x.html", "study.yaml", " a.txt", "a" * 300 + ".txt",
     "a/" * 20 + "b.txt", "<img>.txt"],
)  # fmt: skip
def test_a_name_that_leads_out_is_hidden_or_is_none_is_not_uploaded(study, name):
    before = sorted(study.parent.rglob("*"))
    with served(study) as door:
        status, answer = door.put(name, b"1 2\n3 4\n")
        assert status == 400
        assert answer["error"]
        assert sorted(study.parent.rglob("*")) == before


def test_a_dropped_file_never_replaces_another(asker, study):
    path = study / "recordings" / "control" / "mouse_c1.txt"
    before = path.read_bytes()
    status, answer = asker.put("control/mouse_c1.txt", b"other content\n")
    assert (status, path.read_bytes()) == (400, before)
    assert "another file of this name" in answer["error"]
    assert asker.put("control/mouse_c1.txt", before) == (200, {"name": "recordings/control/mouse_c1.txt"})


def test_what_is_too_large_is_refused_before_it_comes_and_cut_off_where_it_does_not_say_so(door):
    assert door.raw("PUT", door.root + "upload?name=big.txt", Content_Length=str(10 << 30))[0] == 413
    assert door.raw("POST", door.root + "act", Content_Length=str((4 << 20) + 1))[0] == 413
    body = json.dumps({"do": "undo", "more": "x" * (4 << 20)}).encode()
    chunks = b"".join(b"%x\r\n%b\r\n" % (len(part), part) for part in (body[:9000], body[9000:])) + b"0\r\n\r\n"
    assert door.raw("POST", door.root + "act", chunks, Transfer_Encoding="chunked")[0] == 413
    assert alive(door)


def cells(**given):
    return {
        "do": "set-cells",
        "animal": "mouse_c1",
        "cells": {name.replace("_", " "): text for name, text in given.items()},
    }


def beats(*edits):
    return {"do": "edit-beats", "animal": "mouse_c1", "edits": edits}


NO_MESSAGES = [b"", b"{", b"[]", b'"do"', b"\xff\xfe", b"[" * 100_000, b'{"do": "undo", "title": "\\ud800"}']
MALFORMED = [
    {"do": "rm"},
    {"do": "set-cells", "animal": 5, "cells": []},
    cells(group=5),
    cells(__class__="x"),
    cells(recording="../../../etc/passwd"),
    beats(["reject", float("nan"), None]),
    beats(["reject", -1, None]),
    beats(["burn", 1.0, None]),
    {"do": "set-zero", "animal": "mouse_c1", "start": 500.0, "end": 600.0},
    {"do": "set-setting", "key": "../x", "value": "1"},
    {"do": "set-setting", "key": "calibration.starts", "value": "1\nx: 2"},
    {"do": "set-groups", "groups": ["$(x)"]},
    {"do": "add-files", "files": ["../../etc/passwd"]},
    {"do": "add-files", "files": ["/etc/passwd"]},
    {"do": "undo", "more": 1},
    {"do": "new-study"},
]
BODIES = [*NO_MESSAGES, *(json.dumps(one).encode() for one in MALFORMED)]


def content(folder):
    files = (path for path in folder.rglob("*") if path.is_file() and path.name != FOLDER_LOCK)
    return {path: path.read_bytes() for path in files}


@pytest.mark.parametrize("body", BODIES, ids=range(len(BODIES)))
def test_a_malformed_message_is_refused_in_a_sentence_and_changes_no_file(door, kept_study, body):
    before = content(kept_study)
    status, _, answer = door.raw("POST", door.root + "act", body)
    assert status == 400, answer
    assert 10 < len(json.loads(answer)["error"]) < 600
    assert content(kept_study) == before


@pytest.mark.parametrize(
    "what",
    [
        "trace?animal=mouse_c1",
        "trace?animal=x&signal=y&start=a&end=b&width=c",
        "trace?animal=mouse_c1&signal=flow&start=0&end=nan&width=100",
        "trace?animal=mouse_c1&signal=flow&start=0&end=9&width=100000000",
        "recording?animal=no",
        "model?animal=x&law=y",
        "results",
    ],
)
def test_a_question_that_makes_no_sense_is_answered_by_a_sentence(door, what):
    status, _, answer = door.raw("GET", door.root + what)
    assert status == 400
    assert json.loads(answer)["error"]


def ended(one):
    """Whether the server has closed a connection that has asked nothing."""
    one.setblocking(False)
    try:
        return one.recv(1) == b""
    except BlockingIOError:
        return False
    except OSError:
        return True


def test_a_thousand_sockets_do_not_end_it(door):
    import resource

    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(hard, max(soft, 4096)), hard))
    sockets = []
    try:
        for _ in range(1000):
            sockets.append(socket.create_connection(("127.0.0.1", door.port), timeout=10))
        end = time.monotonic() + 10
        while sum(map(ended, sockets)) < 790:  # a browser opens six, and two hundred are let in
            assert time.monotonic() < end
            time.sleep(0.05)
        assert alive(door)
    finally:
        for one in sockets:
            one.close()
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
    end = time.monotonic() + 10
    while True:  # it takes a moment until all of them are forgotten
        try:
            assert alive(door)
            return
        except OSError:
            assert time.monotonic() < end
            time.sleep(0.05)


def test_every_answer_forbids_what_the_page_does_not_need(door):
    for path in ("", "state", "page/main.js", "wrong"):
        _, headers, _ = door.raw("GET", door.root + path)
        assert "default-src 'none'" in headers["content-security-policy"]
        assert "unsafe" not in headers["content-security-policy"]
        assert headers["referrer-policy"] == "no-referrer"
        assert headers["x-content-type-options"] == "nosniff"


def test_a_report_stands_at_an_address_with_which_nothing_else_can_be_asked(study):
    (study / "report").mkdir()
    (study / "report" / "a b.html").write_text("all", encoding="utf-8")
    with served(study) as door:
        status, headers, _ = door.raw("GET", door.root + "report/a%20b.html")
        policy = door.raw("GET", door.of_report + "report/a%20b.html")[1]["content-security-policy"]
        assert "default-src 'none'" in policy
        assert "sandbox" in policy
        assert "allow-same-origin" not in policy
        assert (status, headers["location"]) == (307, door.of_report + "report/a%20b.html")
        assert door.raw("GET", headers["location"])[::2] == (200, b"all")
        key = door.of_report
        assert door.root.strip("/") not in headers["location"]
        encoded = door.raw("GET", f"{door.root.rstrip('/')}%2freport%2fa%20b.html")
        assert (encoded[0], encoded[1]["location"]) == (307, door.of_report + "report/a%20b.html")
        for path in ("state", "", "page/ask.js", "report/../state", "reports/"):
            assert door.raw("GET", key + path)[0] == 404, path
        for method, path in (("POST", "act"), ("PUT", "upload"), ("POST", "report/a%20b.html")):
            assert door.raw(method, key + path, b"{}")[0] == 404, path


def test_the_page_has_no_script_or_style_within_and_names_no_other_address():
    for path in PAGE.iterdir():
        text = path.read_text(encoding="utf-8").replace("http://www.w3.org/2000/svg", "")
        assert (
            re.findall(r"https?://|innerHTML|outerHTML|insertAdjacentHTML|document\.write|eval\(|new Function", text)
            == []
        )
        if path.suffix == ".html":
            assert re.findall(r"<script(?![^>]*src)|<style|\sstyle=|\son\w+=", text) == []


def sending(door, method, what):
    """Return a connection on which a body of 100 000 bytes is announced, and nothing of it has come."""
    one = socket.create_connection(("127.0.0.1", door.port), timeout=20)
    head = f"{method} {door.root}{what} HTTP/1.1\r\nHost: 127.0.0.1:{door.port}\r\nOrigin: {door.origin}\r\n"
    one.sendall(f"{head}Content-Length: 100000\r\n\r\n".encode())
    return one


@pytest.mark.parametrize(("method", "what"), [("PUT", "upload?name=slow.txt"), ("POST", "act"), ("POST", "nothing")])
def test_a_body_of_which_nothing_more_comes_is_given_up(study, impatient, method, what):
    with served(study) as door:
        before = sorted(study.rglob("*"))
        with sending(door, method, what) as one:
            one.sendall(b"1 2\n")
            answer = b"".join(iter(lambda: one.recv(1000), b""))
        assert (b" 404 " if what == "nothing" else b" 408 ") in answer[:20]
        assert (b"too little of this came" in answer) == (what != "nothing")
        assert sorted(study.rglob("*")) == before
        assert alive(door)


def test_a_hundred_and_fifty_uploads_that_trickle_are_ended_and_the_page_is_answered_beside_them(study, impatient):
    with served(study) as door:
        before, begun, slow = sorted(study.rglob("*")), time.monotonic(), []
        try:
            slow += [sending(door, "PUT", f"upload?name=slow{i}.txt") for i in range(150)]
            assert alive(door)
            while not all(map(ended_with_word, slow)):  # a byte each, well within the patience
                assert time.monotonic() - begun < 60
                time.sleep(0.2)
            assert alive(door)
        finally:
            for one in slow:
                one.close()
        assert sorted(study.rglob("*")) == before


def ended_with_word(one):
    """Send a byte more; whether the server has answered before all came."""
    try:
        one.setblocking(False)
        one.send(b"1")
        return b" 408 " in one.recv(100, socket.MSG_PEEK)
    except BlockingIOError:
        return False
    except OSError:  # closed since
        return True


def test_what_comes_slowly_but_steadily_is_taken(study, impatient):
    """For three times as long as nothing may come."""
    with served(study) as door, sending(door, "PUT", "upload?name=steady.txt") as one:
        for _ in range(10):
            one.sendall(10_000 * b"1")
            time.sleep(0.15)
        assert b" 200 " in one.recv(20)
    assert (study / "recordings" / "steady.txt").stat().st_size == 100_000


def test_an_answer_that_nobody_takes_is_given_up(study, impatient):
    (study / "report").mkdir()
    with (study / "report" / "large.pdf").open("wb") as file:
        file.truncate(200 << 20)  # more than a system holds for a connection
    with served(study) as door, socket.create_connection(("127.0.0.1", door.port), timeout=20) as one:
        one.sendall(f"GET {door.of_report}report/large.pdf HTTP/1.1\r\nHost: 127.0.0.1:{door.port}\r\n\r\n".encode())
        time.sleep(2.0)
        came = 0
        with suppress(ConnectionResetError):
            while part := one.recv(1 << 20):
                came += len(part)
        assert came < 200 << 20
        assert alive(door)


@pytest.mark.parametrize("before", ["", "GET {root}page/no HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n"])
def test_a_connection_that_asks_nothing_or_nothing_more_is_closed(kept_study, impatient, before):
    with served(kept_study) as door, socket.create_connection(("127.0.0.1", door.port), timeout=10) as one:
        if before:
            one.sendall(before.format(root=door.root, port=door.port).encode())
            assert b" 404 " in one.recv(2000)
        one.sendall(b"GET / HTTP/1.1\r\nX-Slow: ")
        begun = time.monotonic()
        assert one.recv(10) == b""
        assert time.monotonic() - begun < 8
        assert alive(door)
