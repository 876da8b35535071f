import pytest

from vasowave.study.figures import new_figure, style


@pytest.fixture
def in_style():
    """Draw as the figures of a report are drawn."""
    with style():
        yield


@pytest.fixture
def ax(in_style):
    return new_figure(8.5, 6.0).subplots()
