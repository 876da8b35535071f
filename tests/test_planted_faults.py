"""The planted faults fit the present source: a fault whose text is gone would never be planted again."""

import importlib.util
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


def harness():
    spec = importlib.util.spec_from_file_location("planted_faults", ROOT / "benchmarks" / "planted_faults.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("fault", harness().FAULTS, ids=lambda fault: fault.name)
def test_every_planted_fault_fits_the_source_and_changes_it(fault):
    source = (ROOT / "src" / "vasowave" / fault.file).read_text(encoding="utf-8")
    assert harness().broken(source, fault) != source
