"""Tables of what an analyst's choices change: which fits are asked for, and what each row says of its fit."""

from dataclasses import replace

import numpy as np
import pytest

from made_fit import made_fit, made_recording
from vasowave.calibration import Search
from vasowave.calibration.calibrate import NUMERICS
from vasowave.calibration.compared import compared_part
from vasowave.datasets import control_network
from vasowave.model.blood import Blood
from vasowave.selection import choices

WALLS = ("linear", "tangent")


@pytest.fixture
def asked(monkeypatch):
    """Return what `calibrate` is asked for; in place of a search, fits made from formulas answer."""
    calls = []

    def calibrate(network, recording, wall, search, **more):
        calls.append((network, wall, search, more))
        fit = made_fit(wall, recording=recording, network=network)
        return replace(fit, compared=compared_part(recording, search.pressure_harmonics))

    monkeypatch.setattr(choices, "calibrate", calibrate)
    monkeypatch.setattr(choices, "answers", lambda fits, covariance: choices.pd.DataFrame(
        [choices.answer(fit) for fit in fits], choices.pd.Index([fit.wall for fit in fits], name="wall")))  # fmt: skip
    return calls


def test_every_law_is_fitted_to_every_choice_of_harmonics_and_each_row_says_what_its_fit_says(asked):
    heard = []
    table = choices.answers_by_harmonics(
        control_network(), made_recording(), WALLS, (10, 20), search=Search(starts=3),
        progress=lambda done, all_: heard.append((done, all_)),
    )  # fmt: skip
    assert [(wall, search.pressure_harmonics, search.starts) for _, wall, search, _ in asked] == [
        (wall, number, 3) for number in (10, 20) for wall in WALLS
    ]
    assert heard == [(1, 4), (2, 4), (3, 4), (4, 4)]
    assert asked[0][3] == {"blood": Blood(), "numerics": NUMERICS}
    assert table.index.tolist() == [(number, wall) for number in (10, 20) for wall in WALLS]
    fit = made_fit("tangent")
    row = table.loc[(20, "tangent")]
    assert row["N"] == len(fit.residual) == 128
    assert row["S [mmHg2]"] == fit.S
    assert row["mean square [mmHg2]"] == pytest.approx(fit.S / 128)
    assert row["gamma [1]"] == 1.6
    assert row["p1 [mmHg]"] == 9.1
    outlets = fit.model.outlets
    assert row["R_T [mmHg s/ml]"] == pytest.approx(1 / np.sum(1 / (outlets.R1 + outlets.R2)))


@pytest.mark.parametrize(("pressure", "expected"), [(0.0, [0.0, 6.3]), (4.0, [0.0, 4.0])])
def test_radii_are_taken_at_zero_and_at_the_pressure_of_the_image_or_the_papers(asked, pressure, expected):
    network = replace(control_network(), pressure=pressure)
    table = choices.answers_by_image_pressure(network, made_recording(), ("linear",))
    assert [one.pressure for one, *_ in asked] == expected
    assert table.index.names == ["image pressure [mmHg]", "wall"]
    assert table.index.tolist() == [(one, "linear") for one in expected]
    asked.clear()
    choices.answers_by_image_pressure(network, made_recording(), ("linear",), (2.0,), blood=Blood(viscosity=0.05))
    assert [(one.pressure, more["blood"].viscosity) for one, _, _, more in asked] == [(2.0, 0.05)]
