from collections.abc import Callable
from pathlib import Path

import pytest
from small_study import SETTINGS, make_study_in

from vasowave.pulse.cycle import Recording
from vasowave.pulse.examples import virtual_mouse


@pytest.fixture(scope="session")
def mice() -> list[Recording]:
    return [virtual_mouse(seed=seed) for seed in range(3)]


@pytest.fixture
def make_study(tmp_path: Path, mice: list[Recording]) -> Callable[..., Path]:
    """Return what writes a small study."""

    def make(name: str = "study", animals: int = 3, settings: str = SETTINGS) -> Path:
        return make_study_in(tmp_path / name, mice[:animals], settings)

    return make
