"""What several files of this folder ask for: one animal, and its report."""

import pytest

from made_cohort import made_results
from vasowave.study.report import write_report


@pytest.fixture(scope="session")
def lone_animal():
    """Return the result of one animal with a continuous recording."""
    (only,) = made_results({"sham": 1}, raw=1)
    return only


@pytest.fixture(scope="session")
def lone_report(lone_animal, tmp_path_factory):
    """Return the folder of its report, without PDF."""
    return write_report([lone_animal], tmp_path_factory.mktemp("lone") / "animal", pdf=False).parent
