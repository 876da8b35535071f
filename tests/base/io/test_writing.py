"""What a study from elsewhere may hold in the place of a file is neither followed nor opened, and modes are kept."""

import errno
import os
import stat
import threading

import pytest

from vasowave.base import InputError
from vasowave.base.io import alone_in, check_file, content_of, lies_inside, write_file, write_files
from vasowave.base.runtime import PART, append

MINE = b"mine, and nobody else's\n"
POSIX = pytest.mark.skipif(os.name == "nt", reason="links, pipes and modes of POSIX")


@pytest.fixture
def mine(tmp_path):
    """A file outside of the study."""
    path = tmp_path / "mine"
    path.write_bytes(MINE)
    return path


def planted(kind, place, mine):
    """Put something that is not a file of the study's own into a place."""
    place.parent.mkdir(parents=True, exist_ok=True)
    if kind == "link":
        place.symlink_to(mine)
    elif kind == "second name":
        os.link(mine, place)
    elif kind == "pipe":
        os.mkfifo(place)
    elif kind == "folder":
        place.mkdir()
    else:
        place.symlink_to("/dev/zero") if os.geteuid() else os.mknod(place, 0o600 | stat.S_IFCHR, os.makedev(1, 5))
    return place


def mode(path):
    return stat.S_IMODE(path.stat().st_mode)


@POSIX
@pytest.mark.parametrize("kind", ["pipe", "device"])
def test_a_file_is_not_put_in_the_place_of_a_pipe_or_a_device(tmp_path, mine, kind):
    place = planted(kind, tmp_path / "table.csv", mine)
    if place.is_symlink():
        pytest.skip("only root makes devices")
    with pytest.raises(InputError, match="pipe or a device"):
        write_file(place, "text")
    with pytest.raises(InputError, match="pipe or a device"):
        check_file(place)
    with pytest.raises(InputError, match="pipe or a device"):
        content_of(place)
    assert not place.is_file()
    assert not list(tmp_path.glob(f"{PART}*"))


@POSIX
def test_a_file_has_the_mode_of_the_users_mask_and_keeps_the_one_that_it_had(tmp_path):
    before = os.umask(0o077)
    try:
        assert mode(write_file(tmp_path / "new.csv", "a")) == 0o600
        (tmp_path / "shared.csv").write_text("b")
        (tmp_path / "shared.csv").chmod(0o664)
        assert mode(write_file(tmp_path / "shared.csv", "c")) == 0o664
        write_files({tmp_path / "new.csv": "d", tmp_path / "shared.csv": "e"})
        assert (mode(tmp_path / "new.csv"), mode(tmp_path / "shared.csv")) == (0o600, 0o664)
    finally:
        os.umask(before)
    assert mode(write_file(tmp_path / "other.csv", "a")) == 0o666 & ~before


@POSIX
@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write everything")
def test_a_file_that_was_made_read_only_is_not_replaced(tmp_path):
    path = write_file(tmp_path / "table.csv", "old")
    path.chmod(0o444)
    with pytest.raises(InputError, match="no permission"):
        write_file(path, "new")
    assert path.read_text() == "old"


def test_files_are_written_together_or_not_at_all_and_not_over_what_another_wrote(tmp_path, monkeypatch):
    one, two, gone = (tmp_path / name for name in ("one", "two", "gone"))
    write_files({one: "1", two: "1", gone: "1"})
    seen = {path: content_of(path) for path in (one, two)}
    two.write_text("an editor's")
    with pytest.raises(InputError, match=r"two was changed elsewhere meanwhile; nothing was written"):
        write_files({one: "2", two: "2"}, seen)
    assert [path.read_text() for path in (one, two)] == ["1", "an editor's"]
    write_files({one: "2", two: b"2", gone: None}, {one: b"1", two: b"an editor's", gone: b"1"})
    assert [path.read_text() for path in (one, two)] == ["2", "2"]
    assert not gone.exists()
    moved, replace = [], os.replace

    def fail_at_the_second(source, target):
        moved.append(target)
        if len(moved) == 2:
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        replace(source, target)

    monkeypatch.setattr(os, "replace", fail_at_the_second)
    with pytest.raises(InputError, match=r"(?i)input/output error"):
        write_files({one: "3", two: "3", gone: "3"})
    assert [path.read_text() for path in (one, two)] == ["2", "2"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["one", "two"]


def test_a_line_behind_one_that_was_cut_off_is_a_line_of_its_own(tmp_path):
    path = tmp_path / "a.jsonl"
    append(path, b"one")
    with path.open("ab") as file:
        file.write(b"half")
    append(path, b"two")
    assert path.read_bytes() == b"one\nhalf\ntwo\n"


def test_the_same_thread_enters_a_study_twice_and_another_waits(tmp_path):
    order, entered, leave = [], threading.Event(), threading.Event()

    def other():
        entered.wait(10)
        leave.set()
        with alone_in(tmp_path):
            order.append("other")

    thread = threading.Thread(target=other)
    thread.start()
    with alone_in(tmp_path):
        entered.set()
        leave.wait(10)
        with alone_in(tmp_path / "." / "x" / ".."):
            order.append("within")
        order.append("out")
    thread.join()
    assert order == ["within", "out", "other"]


@POSIX
def test_names_and_links_that_lead_out_of_a_folder_are_told(tmp_path, mine):
    study = tmp_path / "study"
    study.mkdir()
    (study / "out.csv").symlink_to(mine)
    (study / "loop").symlink_to("loop")
    (study / "in.csv").symlink_to("real.csv")
    inside = {name: lies_inside(study, name) for name in ("a/b.csv", "in.csv", "../x", "out.csv", ".", "a\0b", "/etc")}
    assert [name for name, good in inside.items() if good] == ["a/b.csv", "in.csv"]
    assert not lies_inside(study, "loop/x")
