"""What was found in files is remembered, but not more of it than a machine has room for."""

import os
from dataclasses import dataclass

import numpy as np
import pytest

from vasowave.base.io import remembered as room


class Plain:
    def __init__(self, values):
        self.values = values


@dataclass(frozen=True)
class Declared:
    values: np.ndarray


@pytest.mark.parametrize("holds", [Plain, Declared, lambda values: (values,), lambda values: {"values": values}])
def test_what_was_found_first_is_forgotten_when_the_room_is_full(tmp_path, monkeypatch, holds):
    monkeypatch.setattr(room, "MOST", 2_500_000)
    asked = []

    @room.remembered
    def read(path):
        asked.append(path.name)
        return holds(np.zeros(125_000))  # a megabyte

    paths = [tmp_path / name for name in "abc"]
    for path in paths:
        path.write_text(path.name, "utf-8")
        os.utime(path, (1e9, 1e9))  # an old file, whose times tell whether it changed
    for path in (*paths, paths[2], paths[0]):
        read(path)
    assert asked == ["a", "b", "c", "a"]
