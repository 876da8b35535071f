"""Damaged recordings of every format: a short run of the fuzzer, and what no format may do."""

import importlib.util
import sys
from pathlib import Path

import pytest

TOOL = Path(__file__).parents[1] / "tools" / "fuzz_recordings.py"


@pytest.fixture(scope="module")
def fuzzer():
    spec = importlib.util.spec_from_file_location("fuzz_recordings", TOOL)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(
    ("form", "mutants"),
    [
        ("table, commas", 30),
        ("table, decimal commas", 30),
        ("labchart text", 30),
        ("edf", 60),
        ("cycle table", 60),
        ("labchart mat", 2),
        ("cycle mat", 2),
    ],
)
def test_damage_is_refused_told_or_seen_in_the_values_only(fuzzer, tmp_path, form, mutants):
    found = fuzzer.fuzz(form, mutants, 1, tmp_path)
    assert sum(found.values()) == mutants
    assert found["foreign"] == found["hang"] == 0
    if fuzzer.FORMATS[form].mutate is fuzzer.mutate_text:
        assert found["refused"] > 0
        assert found["other structure"] == 0


def test_the_fuzzer_sees_a_reader_that_fails_a_silent_change_and_a_lost_sample(fuzzer, tmp_path):
    form = fuzzer.FORMATS["cycle table"]
    path = tmp_path / "sound.csv"
    form.write(path)
    sound = form.read(path)

    def broken(path):
        raise KeyError(path)

    assert fuzzer.outcome(form._replace(read=broken), path, sound) == "foreign"
    assert fuzzer.outcome(form, path, sound) == "same"
    shorter = sound.resampled(64)
    assert fuzzer.outcome(form, path, shorter) in ("told", "other structure")
