"""The exponent that answers the wall question, and quantities averaged over wall laws by their weights: in a study."""

from dataclasses import replace

import pytest

from made_fit import made_fit
from vasowave.base import OTHER, texts
from vasowave.pulse import ACROSS_LAWS
from vasowave.study.animal import Animal, AnimalResult, Settings, from_bytes, result_of, to_bytes


def three_fits():
    return [made_fit(wall) for wall in ("linear", "tangent", "power")]


@pytest.mark.validation
def test_an_animals_tree_holds_the_average_and_how_the_wall_stiffens():
    fits = three_fits()
    animal = Animal("mouse", "CTL", fits[0].model.network, fits[0].recording, synthetic=True)
    made = result_of(animal, fits, Settings(walls=("linear", "tangent", "power")))
    stored = AnimalResult.from_datatree(from_bytes(to_bytes(made.to_datatree())))
    averages = stored.averages
    for name in ACROSS_LAWS:
        each = [float(stored.laws[wall].quantities[name]) for wall in ("linear", "tangent", "power")]
        value, attrs = float(averages[name]), averages[name].attrs
        assert min(each) * (1 - 1e-9) <= value <= max(each) * (1 + 1e-9)
        assert attrs["interval_low"] < value < attrs["interval_high"]
        assert 0 <= attrs["between_laws"] <= 1
        assert attrs["units"] == stored.laws["linear"].quantities[name].attrs["units"]
    assert averages.attrs["covariance"] == stored.selection.attrs["preferred_covariance"]
    assert stored.laws["power"].stiffening.attrs["verdict"] in ("more", "less", "open")
    assert stored.laws["linear"].stiffening is None


def test_what_all_laws_share_is_said_once_and_the_rest_with_the_name_of_its_law():
    fits = [
        replace(made_fit(wall), findings=(OTHER(text="about the image"), OTHER(text=f"about {wall}")))
        for wall in ("linear", "tangent")
    ]
    animal = Animal("mouse", "CTL", fits[0].model.network, fits[0].recording, synthetic=True)
    notes = texts(result_of(animal, fits, Settings(model_selection=False)).findings)
    assert notes.count("about the image") == 1
    assert "tangent wall: about tangent" in notes
    assert not any("wall: about the image" in note for note in notes)
