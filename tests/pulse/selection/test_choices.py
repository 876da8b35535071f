"""Tables of what an analyst's choices change: a row for every fit, which says what its fit says."""

from dataclasses import replace

from choices import answers, answers_by_harmonics, answers_by_image_pressure
from made_fit import made_fit, made_recording
from vasowave.pulse.calibration import Search
from vasowave.pulse.model import Numerics
from vasowave.pulse.network import Network

NETWORK = Network(("1", "2", "3"), [-1, 0, 0], [0.4, 0.4, 0.5], [0.05, 0.035, 0.04])
QUICK = {"search": Search(starts=1, pressure_harmonics=8), "numerics": Numerics(cell_size=0.3)}


def test_a_law_is_fitted_to_every_choice_of_harmonics():
    table = answers_by_harmonics(NETWORK, made_recording(), ("linear",), (8, 10), **QUICK)
    assert table.index.tolist() == [(8, "linear"), (10, "linear")]
    assert table["N"].tolist() == [17, 21]
    assert table["R_T [mmHg s/ml]"].max() < 1.05 * table["R_T [mmHg s/ml]"].min()  # of one mean pressure and flow


def test_radii_that_belong_to_a_pressure_need_a_softer_wall_than_the_same_at_rest():
    image = replace(NETWORK, pressure=4.0)
    table = answers_by_image_pressure(image, made_recording(), ("linear",), **QUICK)
    assert table.index.tolist() == [(0.0, "linear"), (4.0, "linear")]
    beta = table["beta [mmHg]"].to_numpy()
    assert beta[0] > beta[1] + 4.0  # that of the nominal wall, and more, since the artery is narrower at rest


def test_answers_of_several_fits_have_their_differences_beside_them():
    fits = [made_fit("linear"), made_fit("tangent")]
    table = answers(fits, "independent")
    assert list(table.index) == ["linear", "tangent"]
    assert table["S [mmHg2]"].tolist() == [fit.S for fit in fits]
    assert table.loc["tangent", ["p1 [mmHg]", "gamma [1]"]].tolist() == [9.1, 1.6]
    assert table["AICc difference"].min() == 0.0
    assert "AICc difference" not in answers(fits[:1])
