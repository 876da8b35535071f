"""A panel is declared in one place: notebooks, workbench and report have it from there."""

import pytest

from made_cohort import bare_result
from vasowave.base import InputError
from vasowave.study.animal import FitPlots
from vasowave.study.figures import PANELS, fit_panel

desk = pytest.importorskip("vasowave.workbench.figures", reason="a study alone has no workbench")
ABOVE = ("workbench",)


@pytest.fixture
def rhythm():
    """Return a further panel, which is forgotten afterwards."""
    before = dict(PANELS)

    @fit_panel("rhythm", "rhythm of the heart", "Rhythm", "What a heart does.")
    def plot_rhythm(ax, result, color, shaded):
        """Draw a rhythm."""
        ax.set_title(result.name)
        return ax

    yield plot_rhythm
    PANELS.clear()
    PANELS.update(before)


def test_a_new_panel_is_drawn_saved_and_offered(rhythm, tmp_path):
    result = bare_result()
    assert result.plot.rhythm().get_title() == result.name
    assert "rhythm" in dir(result.plot)
    assert result.plot.panels()["rhythm"] == "Draw a rhythm."
    assert result.plot.save(tmp_path / "two.svg", ["rhythm", "rhythm"]).stat().st_size > 1000
    assert desk.Wish(animal=result.name, panels=["rhythm"]).panels == ["rhythm"]


def test_a_panel_that_there_is_none_of_is_named():
    plots = FitPlots(bare_result())
    with pytest.raises(AttributeError, match="there is no panel 'presure'"):
        _ = plots.presure
    with pytest.raises(InputError, match=r"no panel 'presure' \(did you mean 'pressure'\?\)"):
        plots.draw("presure")
    with pytest.raises(InputError, match="no panel 'presure'"):
        desk.Wish(animal="mouse", panels=["presure"])
