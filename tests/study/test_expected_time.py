"""How long a study is said to take before it runs."""

import pytest

from vasowave.study.animal import Calibration
from vasowave.study.folder import StudyFile
from vasowave.study.results import AnimalRead, expected_seconds


def test_the_time_that_is_told_counts_posteriors():
    """One takes 3 to 8 s of a processor (docs/performance.md); here are 16 of each law, on two cores."""
    read = [AnimalRead("A", "CTL", 22, "cycle", 0.0, (0, 0), 500.0, 14.0, 0.18, 0.0)] * 16
    laws = Calibration(walls=("linear", "tangent"), starts=4)
    fits, first, every = (
        expected_seconds(read, StudyFile(calibration=laws, inference=what), 2)
        for what in ("intervals", "reference", "posterior")
    )
    assert fits < 34
    assert 24 < first - fits < 64
    assert every - first == pytest.approx(first - fits)
