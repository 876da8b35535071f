"""One namespace of parameters: a law of ours may call a field as it likes, and a clash that is left is an error."""

import pickle
import re
from typing import NamedTuple

import numpy as np
import pytest

import vasowave as vw
from vasowave.base import InputError, Parameter
from vasowave.pulse.calibration import ParameterLimits, fitted_parameters, parameter_space
from vasowave.pulse.inference import Priors, Unknowns
from vasowave.pulse.model import BEDS, LAWS, LinearWall, Numerics, ParameterName, changed_model, estimate_nominal
from vasowave.study.animal import quantities_of

COARSE = Numerics(cell_size=0.3, samples=64)


def linear_law(name: str, field: str, *further: str) -> type:
    """Return the linear law as a class whose stiffness is called `field`, with further fields that do nothing."""
    count = len(further)
    fields = [(each, float) for each in (field, *further)]
    parameters = (LinearWall.law().parameters[0],) + count * (
        Parameter("1", "n", "nothing", "", 1.0, (0.5, 2.0), held=True),
    )
    law = NamedTuple(name.capitalize(), fields)
    law.law = staticmethod(lambda: LinearWall.law()._replace(name=name, parameters=parameters, stiffness="stiffness"))
    law.pressure_at = staticmethod(lambda a, k, *rest: k * (np.sqrt(a) - 1.0))
    law.ratio_at = staticmethod(lambda p, k, *rest: (1.0 + p / k) ** 2)
    law.slope_at = staticmethod(lambda p, k, *rest: 2.0 / k * (1.0 + p / k))
    law.limits = staticmethod(lambda k, *rest: (0.0 * k, 0.0 * k + np.inf))
    return law


class SpringWall(NamedTuple):
    """The linear law, whose stiffness is called as the exponent of the stiffness along the tree is."""

    k: float

    @staticmethod
    def law():
        k = LinearWall.law().parameters[0]
        return LinearWall.law()._replace(name="spring", parameters=(k,), stiffness="k")

    @staticmethod
    def pressure_at(a, k):
        return k * (np.sqrt(a) - 1.0)

    @staticmethod
    def ratio_at(p, k):
        s = 1.0 + p / k
        return s * s

    @staticmethod
    def slope_at(p, k):
        return 2.0 / k * (1.0 + p / k)

    @staticmethod
    def limits(k):
        return 0.0 * k, 0.0 * k + np.inf


@pytest.fixture
def ours(monkeypatch):
    """Return what makes a law one of ours."""
    return lambda law: monkeypatch.setitem(LAWS, law.law().name, law) or law


@pytest.fixture
def mouse():
    network, cycle = vw.control_network(), vw.virtual_mouse()
    return network, cycle, estimate_nominal(network, cycle)


def test_no_two_numbers_of_a_law_of_ours_and_its_beds_have_one_name():
    for law in LAWS.values():
        for bed in BEDS.values():
            fitted = fitted_parameters(law, bed, viscous=True)
            assert len({name.full for name in fitted}) == len(fitted)
            assert set(fitted) <= set(quantities_of(law, bed, viscous=True))


@pytest.mark.parametrize("field", ["k", "zero", "viscosity", "r1", "C", "R_T", "a", "tau", "radius", "wall_viscosity"])
def test_a_field_that_another_number_is_called_by_lends_the_name_of_its_law(ours, mouse, field):
    law, (network, cycle, nominal) = ours(linear_law("plain", field)), mouse
    space = parameter_space("plain", network, nominal, vw.Blood(), ParameterLimits(viscous=True))
    unknowns = Unknowns(space, nominal, Priors(flow_zero_sd=0.1), cycle)
    assert space.names[0] == f"plain.{field}"
    assert space.names[0].full == f"wall.{field}"
    assert len({name.full for name in unknowns.all}) == len(unknowns.all)
    assert set(space.names) < set(unknowns.all)
    softer = unknowns.model(unknowns.scores({f"plain.{field}": 30.0}))
    assert softer.wall[0] == pytest.approx(30.0)
    assert changed_model(softer, {f"wall.{field}": 40.0}).wall[0] == pytest.approx(40.0)
    assert f"plain.{field}" in quantities_of(law, type(nominal.outlets))


def test_a_field_that_a_quantity_is_called_by_is_an_error_that_names_both(ours):
    law = ours(linear_law("plain", "wave_speed"))
    with pytest.raises(InputError, match=r"'wave_speed' is the name of two numbers.*wall\.wave_speed.*rename"):
        quantities_of(law, BEDS["windkessel"])


def test_bounds_and_priors_may_be_written_in_full(mouse):
    network, cycle, nominal = mouse
    limits = ParameterLimits({"wall.beta": (30.0, 90.0)}, {"bed.r1": 0.8})
    space = parameter_space("linear", network, nominal, vw.Blood(), limits)
    assert (space.lower[0], space.upper[0], space.nominal[1]) == (30.0, 90.0, 0.8)
    assert Unknowns(space, nominal, Priors(parameters={"wall.beta": (50.0, 0.2)}), cycle).all["beta"].spread == 0.2
    with pytest.raises(InputError, match=r"beta is given twice"):
        parameter_space(
            "linear", network, nominal, vw.Blood(), ParameterLimits(fixed={"beta": 50.0, "wall.beta": 60.0})
        )


def test_a_name_is_the_same_in_another_process():
    name = pickle.loads(pickle.dumps(ParameterName("wall", "k", "spring.k")))
    assert (name, name.owner, name.field, name.full) == ("spring.k", "wall", "k", "wall.k")


@pytest.mark.validation
def test_a_law_of_ours_with_a_field_k_is_fitted_sampled_and_stands_on_the_page(ours, mouse, tmp_path):
    ours(SpringWall)
    network, cycle, _ = mouse
    search = vw.Search(starts=1, fixed={"r1": 1.0, "c1": 1.0}, pressure_harmonics=8)
    spring, linear = (
        vw.calibrate(network, cycle, wall, search=search, numerics=COARSE) for wall in ("spring", "linear")
    )
    assert spring.parameters.loc["spring.k", "value"] == pytest.approx(linear.parameters.loc["beta", "value"], rel=1e-6)
    drawn = spring.sample(draws=40, numerics=COARSE)
    assert drawn.summary.loc["spring.k", "unit"] == "mmHg"
    assert drawn.summary.loc["k", "unit"] == "1"  # the exponent along the tree
    page = spring.report(tmp_path / "report")
    text = re.sub(r"\s+", " ", re.sub("<[^>]*>", " ", page.read_text("utf-8")))
    told = re.search(r"stiffness β\(0\): ([\d.]+) \[[\d.]+, [\d.]+\] mmHg \(spring wall\)", text)
    assert told is not None
    assert float(told[1]) == pytest.approx(float(spring.parameters.loc["spring.k", "value"]), rel=0.02)
