"""Models, beds, narrowings and laws at the edge of their rules, and what all combinations give, as approved."""

import numpy as np
import pytest

from approval import approve, parts
from vasowave.errors import InputError
from vasowave.model import law_files, walls
from vasowave.model.blood import Blood, BoundaryLayer, Poiseuille, PowerLaw
from vasowave.model.law_files import LawFile, blamed, named
from vasowave.model.linear import linear_solution
from vasowave.model.losses import angle_losses, narrowed
from vasowave.model.model import Model
from vasowave.model.nominal import estimate_nominal, oddities, time_constant, upstroke, windkessels
from vasowave.model.outlets import Resistance, Windkessel
from vasowave.model.rational import bare, fitted, importance, joined, worth_fitting
from vasowave.model.shape import Shape
from vasowave.model.structured_tree import StructuredTree, relative_viscosity, unsteady
from vasowave.model.ventricle import Ventricle, activation, raised
from vasowave.model.walls import LinearWall, PowerWall, TangentWall, VeinWall
from vasowave.network.network import Network
from vasowave.recording import Inflow, InletPressure, Recording

T = np.arange(64) / 64
TREE = Network(tuple("abcde"), [-1, 0, 0, 1, 1], [0.75, 0.55, 0.35, 0.3, 0.4], [0.047, 0.037, 0.026, 0.024, 0.03])
RING = Network(tuple("abcde"), None, [0.6, 0.5, 0.7, 0.2, 0.4], [0.05, 0.035, 0.03, 0.02, 0.045],
               nodes=[[0, 1], [1, 2], [1, 3], [2, 3], [3, 4]])  # fmt: skip
FLOW = Inflow(0.17 * (1 + np.sin(2 * np.pi * T) + 0.3 * np.cos(4 * np.pi * T)), 0.11)
BEDS = windkessels(TREE, 76.0, 0.11, a=0.2)
WAVE = 2.0 * np.sin(2 * np.pi * T + 0.3)
SHAPE = Shape(np.exp(0.1 * np.sin(np.arange(15.0).reshape(5, 3))), np.exp(0.1 * np.cos(np.arange(10.0).reshape(5, 2))))

SPREAD = StructuredTree.of_factors(
    0.88, 0.68, root_radius=[0.018, 0.013], length_ratio=17.0, stiffness=60.0, hematocrit=0.45, stiffening=4.0,
    smallest=[0.004, 0.008],
).checked(("a", "b"))  # fmt: skip


def said(function, *given, **more):
    with pytest.raises(InputError) as error:
        function(*given, **more)
    return str(error.value)


MODELS = {
    "linear": (Model(TREE, LinearWall(57.0), BEDS), FLOW),
    "tangent, viscous, pressure behind": (
        Model(TREE, TangentWall(9.0, 4.0), BEDS, outlet_pressure=3.0, wall_viscosity=0.05), FLOW
    ),
    "power, Poiseuille": (Model(TREE, PowerWall(50.0, 1.2), BEDS, Blood(friction=Poiseuille())), FLOW),
    "shape, losses": (Model(TREE, LinearWall(57.0), BEDS, shape=SHAPE, loss=0.7), FLOW),
    "shape, static": (Model(TREE, TangentWall(9.0, 4.0), BEDS, shape=SHAPE, junctions="static"), FLOW),
    "pulsation": (Model(TREE, LinearWall(57.0), BEDS, outlet_pulsation=WAVE), FLOW),
    "ring, total": (
        Model(RING, LinearWall(57.0), Windkessel(*np.array([[20.0], [60.0], [1e-3]])), junctions="total"), FLOW
    ),
    "pressure": (Model(TREE, LinearWall(57.0), BEDS), InletPressure(12 + 4 * np.sin(2 * np.pi * T), 0.11)),
    "ventricle": (Model(TREE, LinearWall(57.0), BEDS), Ventricle.from_peak(1400.0, 100.0, 0.11, 4.0)),
    "profile": (Model(TREE, VeinWall(40.0), BEDS, Blood(friction=PowerLaw(5.0))), FLOW),
}  # fmt: skip


def test_approved_linear_solutions_of_every_kind_of_model():
    lines = []
    for name, (model, driven) in MODELS.items():
        found = linear_solution(model, driven, 8)
        x = 0.3 * model.network.length
        rows = np.arange(len(model.network))
        P, Q = found.at(rows, x)
        values = {
            "pressure": found.pressure, "flow": found.flow, "mean": found.mean_pressure,
            "resistance": found.resistance, "Z": found.input_impedance, "P": P, "Q": Q,
            "law": found.of_law(found.pressure), "time": found.in_time(found.pressure, 0.013),
            "cycle": found.over_cycle(found.flow, 40),
        }  # fmt: skip
        for key, value in values.items():
            value = np.asarray(value)
            split = {"re": value.real, "im": value.imag} if np.iscomplexobj(value) else {"of": value}
            for part, numbers in split.items():
                for row in range(numbers.shape[-1]):
                    lines += parts(f"{name}, {key} {part} {row}", numbers[..., row])
    approve("linear", lines, 1e-7, 2e-5)


def test_the_flow_enters_whole_and_leaves_divided_and_its_mean_falls_by_resistances():
    model, driven = MODELS["linear"]
    found = linear_solution(model, driven, 8)
    assert found.flow[:, 0] == pytest.approx(np.fft.rfft(driven.flow)[:9] / 64 * np.array([1, *[2] * 8]))
    assert found.input_impedance[:, 0] == pytest.approx(found.pressure[:, 0] / found.flow[:, 0], rel=1e-6)
    end, _ = found.at(np.arange(5), TREE.length)
    start, _ = found.at(np.arange(5), np.zeros(5))
    assert start == pytest.approx(found.pressure)
    for row, parent in ((1, 0), (2, 0), (3, 1), (4, 1)):
        assert start[:, row] == pytest.approx(end[:, parent])
    assert end[0].real == pytest.approx(found.pressure[0].real - found.resistance * TREE.length * found.flow[0].real)


def test_approved_beds_and_their_rational_functions():
    omega = 2 * np.pi / 0.11 * np.arange(9)
    lines = []
    for name, bed in (("windkessel", BEDS), ("resistance", Resistance(np.array([30.0, 40.0]))), ("tree", SPREAD)):
        rational = bed.rational(0.11)
        values = {
            "Z re": bed.impedance(omega).real, "Z im": bed.impedance(omega).imag,
            "fit re": rational.impedance(1j * omega).real, "fit im": rational.impedance(1j * omega).imag,
            "fast": bed.fast_resistance(), "tau": bed.time_constants(), "share": bed.resistance_ratio(),
            "total": bed.total_resistance(), "C": bed.weighted_compliance(),
        }  # fmt: skip
        for key, value in values.items():
            lines += parts(f"{name}, {key}", np.atleast_1d(np.asarray(value, float)))
    radius = np.array([2e-4, 1e-3, 1e-2])
    lines += parts("viscosity", relative_viscosity(radius, 0.45))
    lines += parts("unsteady re", unsteady(np.array([0.1, 1.0, 5.0, 20.0])).real)
    lines += parts("unsteady im", unsteady(np.array([0.1, 1.0, 5.0, 20.0])).imag)
    approve("beds", lines, 1e-9, 2e-4)


def test_a_structured_tree_sums_up_as_its_parts_do():
    R = SPREAD.impedance(np.zeros(1))[0].real
    assert SPREAD.total_resistance() == pytest.approx(1 / np.sum(1 / R))
    assert SPREAD.time_constants() == pytest.approx(R * SPREAD.weighted_compliance())
    assert SPREAD.resistance_ratio() == pytest.approx(np.mean(SPREAD.fast_resistance() / R))


def test_a_rational_function_of_three_modes_is_found_again():
    omega = np.linspace(0, 400, 25)
    s = 1j * omega
    Z = 12.0 + 800 / (s + 30) + 3e4 / (s + 900) + 200 / (s + 8)
    found = fitted(omega, Z, 3)
    assert found.impedance(s)[:, 0] == pytest.approx(Z, rel=1e-6)
    assert np.sort(found.poles.real.ravel()) == pytest.approx([-900, -30, -8], rel=1e-4)
    assert bare(np.array([3.0, 4.0])).impedance(s)[5].tolist() == [3, 4]
    both = joined([found, bare(np.array([7.0]))])
    assert both.impedance(s) == pytest.approx(np.column_stack([Z, np.full(25, 7.0)]), rel=1e-6)
    assert worth_fitting(5).tolist() == [0, 1, 2, 3, 4]
    assert importance(np.array([0.0, 16.0])).tolist() == [1.0, 0.5]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"wall": "linear"}, "'linear' is not a wall law; use one of `walls`, as in LinearWall(beta)"),
        ({"outlets": 3.0}, "3.0 is not an outlet; use Windkessel(R1, R2, C) or ImpedanceSpectrum(Z)"),
        ({"shape": 1.0}, "shape: 1.0 is no shape; give Shape(radius), as in Shape([1.0, 0.8])"),
        ({"shape": Shape(np.ones((4, 2)))}, "shape: give one row of points, or one for each of the 5 vessels"),
        ({"outlet_pressure": [1.0, 2.0]}, "outlet_pressure: give one number, or one for each of the 3 terminal"),
        ({"outlet_pressure": "x"}, "outlet_pressure: give one number"),
        ({"outlet_pressure": [1.0, np.nan, 2.0]}, "vessel 'd': the pressure behind its outlet is nan"),
        ({"junctions": "other"}, "junctions: 'other' is not known; give 'static' or 'total'"),
        ({"loss": [0, 0, -1.0, 0, 0]}, "vessel 'c': loss -1 is not valid"),
        ({"wall_viscosity": [0, 0, 0, 0, np.nan]}, "vessel 'e': wall_viscosity nan is not valid"),
        ({"wall": LinearWall([57.0, 57.0])}, "wall parameter beta has shape (2,); give one number or 5 values"),
        ({"wall": LinearWall([57.0, 57, 57, -1, 57])}, "vessel 'd'"),
        ({"outlet_pulsation": np.ones((8, 2))}, "outlet_pulsation"),
    ],
)  # fmt: skip
def test_a_model_of_parts_that_do_not_fit_is_refused(changes, words):
    given = {"network": TREE, "wall": LinearWall(57.0), "outlets": BEDS} | changes
    found = said(Model, **given)
    assert found.startswith(words) or words in found[:80], found


def test_what_a_model_says_of_itself_has_all_its_parts():
    model = Model(
        TREE, TangentWall(9.0, 4.0), BEDS, outlet_pressure=[1.0, 2.0, 3.0], outlet_pulsation=WAVE, shape=SHAPE
    )
    page = model._repr_html_()
    assert "4 mmHg" in page  # twice two
    assert "5, 2.35 cm long in all" in page
    assert "Windkessel at 3 terminals" in page
    assert "Shape(radius" in page
    plain = Model(TREE, LinearWall(57.0), BEDS)._repr_html_()
    assert "behind the outlets" not in plain
    assert "Shape" not in plain
    assert repr(Model(TREE, LinearWall(57.0), BEDS, wall_viscosity=0.05)).endswith("wall viscosity 0.05 mmHg s)")
    assert model.pulsation_before_beds(0.11).shape == (64, 3)
    assert Model(TREE, LinearWall(57.0), BEDS).pulsation_before_beds(0.11) is None


def test_parts_of_a_model_decide_what_junctions_share_and_which_vessels_change():
    plain, shaped = Model(TREE, LinearWall(57.0), BEDS), Model(TREE, LinearWall(57.0), BEDS, shape=SHAPE)
    assert [plain.total_pressure, plain.dynamic, shaped.total_pressure] == [False, False, True]
    assert plain.changed(loss=0.1).dynamic
    assert not shaped.changed(junctions="static").total_pressure
    assert plain.changed(junctions="total").dynamic
    one = Shape(
        np.array([[1, 1], [1.1, 0.9], [1, 1], [1, 1], [1, 1]]), np.array([[1, 1], [1, 1], [1, 1.2], [1, 1], [1, 1]])
    )
    some = plain.changed(shape=one)
    assert some.changing.tolist() == [False, True, True, False, False]
    assert some.stiffening.tolist() == [False, False, True, False, False]
    wall, area0 = some.at(np.array([1, 1, 2, 2]), np.array([0.0, 0.25, 0.0, 0.5]))
    assert wall.beta == pytest.approx([57, 57, 57, 57 * 1.1])
    assert area0 == pytest.approx(np.pi * np.array([0.037 * 1.1, 0.037 * 1.05, 0.026, 0.026]) ** 2)
    assert plain.changed(shape=Shape([1.0, 1.0])).profile is None


def test_a_narrowing_is_three_vessels_with_a_loss_behind_it():
    shape = Shape(np.array([[1, 1], [1, 1], [1.1, 0.9], [1, 1], [1, 1]]), 1.0)
    loss = np.array([0.0, 0.5, 0.1, 0.0, 0.2])
    model = Model(
        TREE, LinearWall(np.arange(50.0, 55)), BEDS, loss=loss, wall_viscosity=np.arange(5) / 100, shape=shape
    )
    found = narrowed(model, "b", area_lost=0.75, length=0.1, place=0.4, stiffer=3.0)
    assert found.network.name == ("a", "b", "b narrow", "b beyond", "c", "d", "e")
    assert found.network.length[1:4] == pytest.approx([0.17, 0.1, 0.28])
    assert found.network.radius[1:4] == pytest.approx([0.037, 0.0185, 0.037])
    assert found.network.parent.tolist() == [-1, 0, 1, 2, 0, 3, 3]
    assert found.loss == pytest.approx([0, 0.5, 0, 1.52 * 9, 0.1, 0, 0.2])
    assert found.wall.beta == pytest.approx([50, 51, 153, 51, 52, 53, 54])
    assert found.wall_viscosity == pytest.approx([0, 0.01, 0.01, 0.01, 0.02, 0.03, 0.04])
    assert found.shape.radius[4].tolist() == [1.1, 0.9]
    assert np.asarray(found.shape.stiffness).shape == (1, 1)
    again = narrowed(found, "b beyond", area_lost=0.5, length=0.02)
    assert again.network.name[3:6] == ("b beyond", "b beyond narrow", "b beyond beyond")
    twice = narrowed(narrowed(model, "a", 0.5, 0.1), "a", 0.5, 0.1)
    assert twice.network.name[:5] == ("a", "a narrow 2", "a beyond 2", "a narrow", "a beyond")
    ring = Model(RING, LinearWall(57.0), Windkessel(*np.array([[20.0], [60.0], [1e-3]])))
    cut = narrowed(ring, "c", area_lost=0.5, length=0.1).network
    assert cut.nodes.tolist() == [[0, 1], [1, 2], [1, 5], [5, 6], [6, 3], [2, 3], [3, 4]]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"vessel": "x"}, "the network has no vessel 'x'"),
        ({"vessel": "c"}, "vessel 'c' changes along its way; a narrowing needs a straight one"),
        ({"area_lost": 0.0}, "a narrowing that closes 0 of the area; give the share that is closed, above 0 and below"),
        ({"area_lost": 1.0}, "a narrowing that closes 1 of the area"),
        ({"stiffer": 0.0}, "a narrowing that is 0 times as stiff; give a positive number"),
        ({"stiffer": np.inf}, "a narrowing that is inf times as stiff"),
        ({"length": 0.0}, "a narrowing of 0 cm; give its length, above 0 cm"),
        ({"length": 0.55}, "a narrowing of 0.55 cm at 0.5 of its length does not fit into vessel 'b', which is 0.55"),
        ({"place": 0.05}, "a narrowing of 0.1 cm at 0.05 of its length does not fit"),
        ({"place": 0.95}, "a narrowing of 0.1 cm at 0.95 of its length does not fit"),
    ],
)  # fmt: skip
def test_a_narrowing_that_does_not_fit_is_refused(changes, words):
    shape = Shape(np.array([[1, 1], [1, 1], [1.1, 0.9], [1, 1], [1, 1]]), 1.0)
    given = {"vessel": "b", "area_lost": 0.5, "length": 0.1} | changes
    assert said(narrowed, Model(TREE, LinearWall(57.0), BEDS, shape=shape), **given).startswith(words)
    assert said(narrowed, TREE, **given) == "Network was given where a Model is needed"


def test_an_angle_loses_the_square_of_the_change_of_velocity():
    found = angle_losses(TREE, np.array([0.0, 40.0, 90.0, 0.0, 180.0]))
    u = TREE.flow_fraction / TREE.area
    expected = [0.0]
    for row, parent, angle in ((1, 0, 40.0), (2, 0, 90.0), (3, 1, 0.0), (4, 1, 180.0)):
        r = u[parent] / u[row]
        expected.append(1 + r**2 - 2 * r * np.cos(0.75 * np.radians(angle)))
    assert found == pytest.approx(expected)


def test_every_law_and_its_inverse_and_slope_at_numbers_by_hand():
    """Linear: 60 (√1.44 - 1) = 12; power with m = 2: 60/4 (1.5² - 1) = 18.75, below 0 linear; tangent: 9 tan(π/4)."""
    assert walls.pressure(LinearWall(60.0), 1.44, 1.0) == pytest.approx(12.0)
    assert walls.pressure(PowerWall(60.0, 2.0), 3.0, 2.0) == pytest.approx(18.75)
    assert walls.pressure(PowerWall(60.0, 2.0), 0.64, 1.0) == pytest.approx(-12.0)
    assert walls.pressure(TangentWall(9.0, 4.0), 2.0, 1.0) == pytest.approx(9.0)
    assert walls.pressure(VeinWall(23.0), 0.25, 1.0) == pytest.approx(0.25**10 - 8)
    assert walls.stiffness(TangentWall(9.0, 4.0)) == pytest.approx(2 * np.pi * 9 / 4)
    for law in (LinearWall(60.0), PowerWall(60.0, 2.0), TangentWall(9.0, 4.0), VeinWall(23.0)):
        assert walls.stiffness(law) == pytest.approx(2 / law.slope_at(0.0, *law))
        for p in (-6.0, 0.0, 7.5):
            a = law.ratio_at(p, *law)
            assert law.pressure_at(a, *law) == pytest.approx(p, abs=1e-9)
            step = (law.ratio_at(p + 1e-5, *law) - law.ratio_at(p - 1e-5, *law)) / 2e-5
            assert law.slope_at(p, *law) == pytest.approx(step, rel=1e-6)
            assert walls.area(law, p, 2.0) == pytest.approx(2 * a)
            assert walls.area_compliance(law, p, 2.0) == pytest.approx(2 * step, rel=1e-6)
            assert walls.wave_speed(law, p, 8e-4) == pytest.approx(np.sqrt(a / (8e-4 * step)), rel=1e-6)
        assert walls.wave_speed_at_rest(law, 8e-4) == pytest.approx(walls.wave_speed(law, 0.0, 8e-4))
    assert TangentWall(9.0, 4.0).limits(9.0, 4.0) == (0.0, 3.0)
    assert TangentWall(9.0, 1.0).limits(9.0, 1.0) == (0.5, 1.5)
    for law in (LinearWall, VeinWall):
        assert law.limits(3.0) == (0.0, np.inf)
    assert PowerWall.limits(3.0, 2.0) == (0.0, np.inf)


def ejection(level=0.0):
    flow = np.where(T < 0.4, np.sin(np.pi * np.clip(T / 0.4, 0, 1)), 0.0) + level
    pressure = 5 + 12 * np.exp(-np.clip(T - 0.3, 0, 1) / 0.5) * np.minimum(1, T / 0.3 + 0.2)
    return Recording(pressure, flow, 0.11, "made")


def test_nominal_values_of_a_made_cycle():
    cycle = ejection()
    found = estimate_nominal(TREE, cycle)
    assert found.total_resistance == pytest.approx(cycle.pressure.mean() / cycle.flow.mean())
    q, p = upstroke(cycle)
    assert found.characteristic_impedance == pytest.approx(np.polyfit(q, p, 1)[0])
    area, rho = np.pi * 0.047**2, Blood().inertia
    assert found.beta == pytest.approx(2 * (area * found.characteristic_impedance) ** 2 / rho)
    assert found.wall(TangentWall) == pytest.approx((found.beta / np.pi, 2.0))
    assert repr(found).startswith(f"Nominal(Z_c {found.characteristic_impedance:.4g} mmHg s/ml, beta0 {found.beta:.4g}")
    time = np.linspace(0, 0.05, 20)
    assert time_constant(time, 8 * np.exp(-time / 0.03), "x") == pytest.approx(0.03)
    assert [one.code for one in oddities(found, ejection(0.2).flow)][-1] == "nominal.flow-never-stops"
    assert dict(oddities(found, ejection(0.2).flow)[-1].values)["percent"] == pytest.approx(100 * 0.2 / 1.2, rel=0.01)


def test_a_heart_rises_and_falls_by_two_hills():
    wave = activation(np.arange(1000) / 1000, 0.35)
    assert wave.max() == pytest.approx(1.0, abs=1e-6)
    assert np.argmax(wave) == pytest.approx(350, abs=2)
    assert raised(np.array([1.0]), 2.0, 20.0, 1.0)[0] == pytest.approx(1.0, abs=0.05)
    heart = Ventricle.from_peak(1400.0, 100.0, 0.11, 4.0)
    assert heart.filled == pytest.approx(4.0 / heart.elastance[0])
    assert heart.elastance.max() == pytest.approx(1400, rel=1e-3)
    assert said(Ventricle.from_peak, 100.0, 100.0, 0.11, 4.0).startswith("the elastance at rest, 100, is positive and")
    assert said(Ventricle.from_peak, 100.0, 0.0, 0.11, 4.0).startswith("the elastance at rest, 0, is positive and")
    for at in (0.0, 1.0):
        assert said(Ventricle.from_peak, 100.0, 9.0, 0.11, 4.0, at=at).startswith(f"at = {at:g}: the peak lies between")


def test_blood_has_the_friction_of_its_profile():
    blood = Blood()
    assert blood.inertia == pytest.approx(blood.density / 1333.22, rel=1e-4)
    layer = np.sqrt(0.03 * 0.11 / (2 * np.pi))
    assert BoundaryLayer().coefficients(0.03, 0.11) == pytest.approx((0.0, 2 * np.sqrt(np.pi) * 0.03 / layer))
    assert Poiseuille().coefficients(0.03, 0.11) == pytest.approx(PowerLaw(2.0).coefficients(0.03, 0.11))
    k0, k1 = PowerLaw(5.0).coefficients(0.03, 0.11)
    assert (k0, k1) == pytest.approx((2 * np.pi * 7 * 0.03, 0.0))


def test_an_error_in_a_law_is_blamed_on_its_file_and_line(monkeypatch):
    monkeypatch.setattr(law_files, "_known", {"l": LawFile("l", "/x/law.py", b"")})
    error = SyntaxError("invalid syntax", ("/x/law.py", 7, 1, "", None, None))
    assert str(blamed(error)) == "/x/law.py, line 7: invalid syntax; correct the law"
    found = blamed(RuntimeError('File "law.py", line 12:\nx'))
    assert found is not None
    assert str(found).startswith("/x/law.py, line 12: the compiler of the solver cannot translate it (RuntimeError:")
    assert blamed(ValueError("no")) is None
    assert named("linear") == "linear"
    assert said(named, 3).startswith("3 is no name; write one name")
