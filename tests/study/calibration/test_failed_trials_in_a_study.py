"""A trial point that cannot be is a failed point of its search; a start or a law that fails leaves the others."""

import numpy as np
import pytest

from made_fit import made_recording
from vasowave.base import InputError, NumericalError
from vasowave.pulse.calibration import Search, calibrate
from vasowave.pulse.cycle import Recording
from vasowave.pulse.examples import control_network
from vasowave.pulse.model import Numerics
from vasowave.study.animal import (
    Animal,
    AnimalResult,
    Failure,
    Settings,
    Stage,
    analyze,
    attempted,
    failures_in,
    from_bytes,
    to_bytes,
    write_result,
)

FAST = Numerics(cell_size=0.3, tolerance=1e-6)


@pytest.fixture
def animal():
    return Animal("mouse 9", "HPH", control_network(), made_recording(count=128), synthetic=True)


def settings(*walls, **more):
    return Settings(walls=walls, starts=1, model_selection=False, numerics=FAST, **more)


def test_a_law_that_fails_leaves_the_others_stored_with_the_reason(animal, tmp_path):
    result = analyze(animal, settings("own_laws:Broken", "linear"))
    assert list(result.laws) == ["linear"]
    (failed,) = AnimalResult.from_datatree(from_bytes(to_bytes(result.to_datatree()))).failures
    assert (failed.animal, failed.group, failed.law, failed.stage) == ("mouse 9", "HPH", "broken", Stage.FIT)
    assert "by nothing" in failed.reason
    assert failed.mean_pressure == pytest.approx(animal.recording.mean_pressure)
    assert not failed.is_total
    write_result(result, tmp_path / "a.nc")
    assert failures_in(tmp_path / "a.nc") == (failed,)


def test_where_every_law_fails_what_was_measured_stays(animal):
    result = analyze(animal, settings("own_laws:Broken"))
    assert not result.laws
    assert float(result.measured.quantities["mPAP"]) == pytest.approx(animal.recording.mean_pressure)
    assert [one.stage for one in result.failures] == [Stage.FIT]


def test_a_posterior_that_fails_leaves_its_fit(animal, monkeypatch):
    def failing(*given, **more):
        raise NumericalError("most models near the mode cannot be simulated")

    monkeypatch.setattr("vasowave.study.animal.pipeline.posterior", failing)
    result = analyze(animal, settings("linear", inference="posterior"))
    assert list(result.laws) == ["linear"]
    assert result.laws["linear"].posterior is None
    (failed,) = result.failures
    assert str(failed) == "linear wall, posterior: most models near the mode cannot be simulated"


@pytest.mark.parametrize("error", [MemoryError(), OSError(28, "No space left on device")])
def test_a_full_disk_and_a_lack_of_memory_are_no_failures_of_an_animal(error):
    def work():
        try:
            raise error
        except OSError as full:
            raise InputError("no space left") from full

    told = []
    with pytest.raises((MemoryError, InputError)):
        attempted(work, told.append)
    assert told == []


def test_a_failure_says_what_failed_and_an_unforeseen_one_where():
    told = []
    assert attempted(lambda: np.array([1.0])[7], told.append) is None
    assert "unexpected IndexError" in told[0]
    assert "test_failed_trials_in_a_study.py" in told[0]
    assert Failure("a", "CTL", "", Stage.READING, "a gap").is_total
    assert str(Failure("a", "CTL", "", Stage.READING, "a gap")) == "reading: a gap"


@pytest.mark.weekly
def test_no_sick_animal_and_no_law_of_one_is_lost_without_a_reason(shared):
    """A few of those of `benchmarks/stiff_animals.py`; of measured mouse C6 with these factors tangent searches left
    their law.
    """
    from stiff_animals import MOUSE, came, summary
    from vasowave.catheter.read import read_recording

    measured = read_recording(MOUSE / "pC6_1024.dat", MOUSE / "qC6_1024.dat", period=0.11)
    stiff = Recording(2.8 * measured.pressure, 0.65 * measured.flow, 0.11)
    fit = calibrate(control_network(), stiff, "tangent", search=Search(starts=3), numerics=FAST)
    linear = calibrate(control_network(), stiff, "linear", search=Search(starts=1), numerics=FAST)
    assert fit.S < 1.05 * linear.S
    tree = came("trees", 0)
    assert (tree.lost, tree.reasons) == ("", {}), summary([tree])
    assert tree.RMSE["tangent"] < 0.4  # mmHg; the noise of the truth is 0.22


@pytest.mark.validation
def test_a_sick_animal_with_a_law_of_its_users_is_not_lost(shared):
    from stiff_animals import came, summary

    animal = came("own", 0)
    assert (animal.lost, animal.reasons) == ("", {}), summary([animal])
