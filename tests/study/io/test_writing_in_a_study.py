"""What a study from elsewhere may hold in the place of a file is neither followed nor opened, and modes are kept."""

import errno
import os
import stat

import numpy as np
import pytest

from vasowave.base import InputError
from vasowave.base.io import FOLDER_LOCK, alone_in
from vasowave.base.runtime import append
from vasowave.pulse.calibration import SearchEnd
from vasowave.study.folder import StudyFile
from vasowave.study.results import Journal, ResultStore, holder, locked, read_journal, write_results

END = SearchEnd(np.array([0.1]), 12.5, 31, True, "done", np.array([2.0]))
MINE = b"mine, and nobody else's\n"
POSIX = pytest.mark.skipif(os.name == "nt", reason="links, pipes and modes of POSIX")
KINDS = ("link", "second name", "pipe", "device", "folder")


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


@POSIX
@pytest.mark.parametrize("kind", KINDS)
def test_a_journal_that_is_no_file_of_its_own_is_neither_read_nor_added_to(tmp_path, mine, kind):
    place = planted(kind, tmp_path / "searches" / "a.jsonl", mine)
    with pytest.raises(OSError, match=r"a\.jsonl") as caught:
        append(place, b"line")
    assert caught.value.errno in {errno.ELOOP, errno.EMLINK, errno.ENXIO, errno.EISDIR}
    assert read_journal(place) == []
    Journal(place).searches("linear", 1).keep("start", 0, END)
    assert mine.read_bytes() == MINE


@POSIX
@pytest.mark.parametrize("kind", KINDS)
def test_locks_are_refused_in_words_where_something_else_stands_in_their_place(tmp_path, mine, kind):
    study = tmp_path / "study"
    planted(kind, study / FOLDER_LOCK, mine)
    with pytest.raises(InputError, match=r"\.vasowave\.lock: cannot be written: .*(remove it|name of a file)"), \
            alone_in(study):  # fmt: skip
        pass
    lock = planted(kind, study / "results" / "running.lock", mine)
    assert holder(lock) is None
    with pytest.raises(InputError, match=r"running\.lock: cannot be written: "), locked(lock):
        pass
    assert mine.read_bytes() == MINE


@POSIX
@pytest.mark.parametrize("name", ["results", "results/cache", "results/searches", "results/animals"])
def test_a_folder_that_becomes_a_link_while_a_study_runs_is_not_written_through(tmp_path, name):
    results, elsewhere = tmp_path / "study" / "results", tmp_path / "elsewhere"
    for folder in ("results/animals", "results/searches"):
        (tmp_path / "study" / folder).mkdir(parents=True)
        (elsewhere / folder.removeprefix(name).strip("/")).mkdir(parents=True, exist_ok=True)
    store, searches = ResultStore(results), Journal(results / "searches" / "a.jsonl").searches("linear", 4)
    (elsewhere / "cache").mkdir()
    piece = store.keep("a", b"a")
    content = piece.read_bytes()
    place = tmp_path / "study" / name
    place.rename(tmp_path / "aside")
    place.symlink_to(elsewhere)
    searches.keep("start", 0, END)
    tried = {
        "results/cache": lambda: store.keep("b", content),
        "results/animals": lambda: write_results(results, {}, (), StudyFile(), (), ()),
    }
    for folder, write in tried.items():
        if folder.startswith(name):
            with pytest.raises(InputError, match="leads out of"):
                write()
    assert not [file for file in elsewhere.rglob("*") if file.is_file()]
