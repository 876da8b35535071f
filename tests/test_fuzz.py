"""Damaged files of every format: a short run of the fuzzer, and what no format may do."""

from collections import Counter
from pathlib import Path

import pytest

import fuzz

MANY = {"labchart mat": 2, "cycle mat": 2, "cycle mat 7.3": 2}  # each mutant of theirs starts a process


@pytest.mark.parametrize("name", fuzz.FORMS)
def test_damage_is_refused_told_or_seen_in_the_values_only(tmp_path, name):
    count = MANY.get(name, 20)
    found = Counter(fuzz.mutants(name, range(count), 1, tmp_path))
    assert sum(found.values()) == count
    assert not fuzz.is_bad(name, found)


def test_the_fuzzer_sees_a_reader_that_fails_a_silent_change_and_a_lost_sample(tmp_path):
    form = fuzz.FORMS["cycle table"]
    form.write(tmp_path)
    sound = form.read(tmp_path / form.opened)

    def broken(path: Path) -> None:
        raise KeyError(path)

    assert fuzz.outcome(form._replace(read=broken), tmp_path, sound) == "foreign"
    assert fuzz.outcome(form, tmp_path, sound) == "same"
    assert fuzz.outcome(form, tmp_path, sound.resampled(64)) in ("told", "other structure")
