"""The paper's practice by one word, in a study and on the command line."""

import numpy as np
import pytest

from vasowave.errors import InputError
from vasowave.network_formats import read_network
from vasowave.solver.practice import PAPER
from vasowave.study.loading import load_animal
from vasowave.study.plan import read_study
from vasowave.study.settings import animal_settings


def test_the_papers_practice_is_one_word(make_study):
    folder = make_study(settings="groups: [CTL, HPH]\npractice: paper\n")
    study = read_study(folder)
    settings = animal_settings(study.settings)
    assert (settings.numerics, settings.blood) == (PAPER.numerics, PAPER.blood)
    assert settings.pressure_harmonics == "all"
    assert settings.paper_bounds
    animal = load_animal(study.animals[0], study.settings, folder)
    cells = animal.network.length / 0.025
    np.testing.assert_allclose(cells, np.rint(cells), atol=1e-9)
    assert np.all(animal.network.length <= read_network(folder / "n.csv").length + 1e-9)


@pytest.mark.parametrize(
    ("own", "named"),
    [("blood: {density: 1.06}", "blood"), ("calibration: {pressure_harmonics: 9}", r"calibration\.pressure_harmonics")],
)
def test_a_practice_and_what_it_sets_itself_are_refused_together(make_study, own, named):
    folder = make_study(settings=f"practice: paper\n{own}\n")
    with pytest.raises(InputError, match=f"practice 'paper' sets {named} itself"):
        read_study(folder)
