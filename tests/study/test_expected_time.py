"""How long a study is said to take before it runs."""

import pytest

from vasowave.study.animal import Calibration
from vasowave.study.folder import StudyFile
from vasowave.study.results import AnimalRead, expected_seconds


def animals(count, kind="cycle"):
    return [AnimalRead("A", "CTL", 21, kind, 0.0, (0, 0), 500.0, 14.0, 0.18, 0.0)] * count


def seconds(read, cores=2, starts=4, inference="intervals"):
    laws = Calibration(walls=("linear", "tangent"), starts=starts)
    return expected_seconds(read, StudyFile(calibration=laws, inference=inference), cores)


def test_the_time_that_is_told_counts_posteriors():
    """One takes 3 to 8 s of a processor (docs/performance.md); here are 16 of each law, on two cores."""
    fits, first, every = (seconds(animals(16), inference=what) for what in ("intervals", "reference", "posterior"))
    assert 24 < first - fits < 64
    assert every - first == pytest.approx(first - fits)


@pytest.mark.parametrize(
    ("read", "starts", "processor"),
    [(animals(12, "raw"), 4, 60 + 49), (animals(6), 20, 51)],  # s, of the demo and of three rats recorded twice
)
def test_the_time_that_is_told_is_that_of_the_processor_with_the_report(read, starts, processor):
    assert 1 / 1.5 < seconds(read, starts=starts) / (processor / 2) < 1.5
    assert seconds(read, cores=1, starts=starts) > 1.5 * seconds(read, starts=starts)
