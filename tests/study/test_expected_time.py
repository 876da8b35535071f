"""How long a study is said to take before it runs."""

from vasowave.study.animal import Calibration
from vasowave.study.folder import StudyFile
from vasowave.study.results import AnimalRead, expected_seconds


def test_the_time_that_is_told_counts_posteriors():
    """On two cores: 16 posteriors of a linear wall took 142 s beside fits of 34 s."""
    read = [AnimalRead("A", "CTL", 22, "cycle", 0.0, (0, 0), 500.0, 14.0, 0.18, 0.0)] * 16
    law = Calibration(walls=("linear",), starts=4)
    fits, both = (
        expected_seconds(read, StudyFile(calibration=law, inference=what), 2) for what in ("intervals", "posterior")
    )
    assert fits < 34
    assert 100 < both - fits < 200
