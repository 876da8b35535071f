"""Wall laws: ours by name, and those in files of a user's own, of which only what a study names is run: in a study."""

from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import pytest

from own_laws import EXPONENTIAL
from vasowave.base import InputError
from vasowave.pulse.model import (
    files_of,
    find_law,
    learn,
)
from vasowave.study.animal import Settings

NAME = "our_laws:ExponentialWall"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    (tmp_path / "our_laws.py").write_text(EXPONENTIAL, "utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_another_process_is_given_the_source_and_needs_no_file(folder):
    wall = Settings(walls=(NAME,)).walls[0]
    files = files_of([wall, "linear"])
    assert [file.path for file in files] == [str(folder / "our_laws.py")]
    (folder / "our_laws.py").unlink()
    with ProcessPoolExecutor(1, get_context("spawn"), learn, (files,)) as pool:
        assert pool.submit(_symbols, wall).result() == ["k", "m"]
    with pytest.raises(InputError, match=r"our_laws:ExponentialWall.*begin where its file lies"):
        find_law("our_laws@0000000000000000:ExponentialWall")


def _symbols(wall):
    return [one.symbol for one in find_law(wall).law().parameters]


@pytest.mark.parametrize("group", ["network", "ventricle", "laws"])
def test_a_law_that_is_called_like_a_group_of_the_stored_results_is_refused(folder, group):
    (folder / "our_laws.py").write_text(EXPONENTIAL.replace('Law("exponential"', f'Law("{group}"'), "utf-8")
    with pytest.raises(InputError, match=f"'{group}': a part of every result has this name"):
        Settings(walls=(NAME,))
