"""Every single number of an animal: unit, symbol, meaning, equation, a few words, and its formula from a model.

All that calls, computes, averages or explains a quantity reads it here; a wall law and the outlets describe their own
parameters, see `animal.quantities.quantities_of`.
"""

from typing import Any, NamedTuple

import numpy as np

from vasowave.base.descriptions import Quantity
from vasowave.pulse.analysis.compliances import Compliance, compliance
from vasowave.pulse.analysis.ventricular_function import VENTRICULAR
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.outlets import Outlets
from vasowave.pulse.model.walls import area_compliance, stiffness, wave_speed

INDICES = ("HR", "CO", "mPAP", "sPAP", "dPAP", "pPAP", "PVR")
"""The measured indices of Table 1, which `Recording.indices` returns."""

COUPLING = ("E_es", "E_a", "coupling")
"""What the pressure in the ventricle tells beside the recording, see `analysis.ventricle_coupling`."""

RECORDED = {"measured_Z_c": "Z_c", "measured_C_T": "C_T", "measured_tau": "tau", "measured_I_R": "I_R"}
"""What recording and model both tell, by the recording alone, and the name under which each of both keeps its own."""

EJECTION = (
    "SV", "ejection_time", "acceleration_time", "dp_dt_max", "dp_dt_min", "notch", "E_a_artery",
    "augmentation", "power", "steady_power", "oscillatory_power", "oscillatory_share", "incident_energy",
    "reflected_energy", "stroke_work",
)  # fmt: skip
"""What one cycle tells without a model, see `analysis.ejection`; the work where the ventricle was recorded."""

HYDRAULIC_POWER = "power"
"""Name of the quantity, which is no wall law's."""

LOOPS: dict[str, Quantity] = {
    f"loops_{name}": quantity._replace(
        symbol=f"{quantity.symbol} (loops)", meaning=f"{quantity.meaning}; by loops of pressure and volume",
        words=quantity.words or quantity.meaning,
    )
    for name, quantity in VENTRICULAR.items()
}  # fmt: skip
"""What loops of pressure and volume tell, by names that no other source of the same numbers has."""

MEASURED = (*INDICES, "pPAP_over_SV", "RC", *EJECTION, *COUPLING, *LOOPS, *RECORDED)
"""Quantities that are no law's, and need no image of vessels."""

ACROSS_LAWS = ("wave_speed", "area_compliance", "R_T", "a", "C_p")
"""Quantities that are averaged over wall laws: those of the beds, and those of the wall where pressure was measured."""

SHARES = ("a", "C_p_over_C_T", "C_p_over_C_T_plain")
"""Quantities that cannot exceed 1."""

OF_PARAMETERS = ("stiffness", *ACROSS_LAWS)
"""Quantities that follow from a model without a simulation."""

QUESTIONS: dict[str, tuple[str, ...]] = {
    "Pressure and flow": INDICES,
    "Large arteries": ("measured_Z_c", "pPAP_over_SV", "stiffness", "wave_speed", "C_v", "C_v_plain"),
    "Small vessels": ("measured_C_T", "measured_tau", "RC", "R_T", "C_p", "C_T", "C_T_plain", "tau", "tau_plain", "a"),
    "Waves": ("measured_I_R", "I_R"),
    "Ventricle and artery": COUPLING,
    "Ejection and power": EJECTION,
    "Ventricle by loops": tuple(LOOPS),
}
"""What a quantity tells of; a quantity that is none of these tells of itself."""

PRIMARY = (
    "mPAP", "CO", "PVR", "measured_Z_c", "pPAP_over_SV", "stiffness", "wave_speed", "measured_C_T", "C_p", "tau",
    "a", "measured_I_R", "I_R",
)  # fmt: skip
"""Quantities that groups are compared by if a study names no others: a few for each question."""

OF_ONE_ANIMAL = ("stiffness", "wave_speed", "R_T", "C_p", "tau", "a", "I_R")
"""Quantities of a model that the page of a single animal tells."""

COMPARED = ("R_T", "C_T", "C_v", "C_p", "tau", "I_R", "a")
"""Quantities of a model that are compared beside the stiffness of its wall law: the paper's "ParAll_change"."""

OPTIMIZED = ("wave_speed", "R_T", "C_T", "C_p_over_C_T", "tau", "I_R", "a", "S", "RMSE")
"""Quantities that stand beside the parameters in the table of fits."""

MEANS = ("R_T", "C_T", "C_p_over_C_T", "tau", "a"), ("wave_speed", "I_R", "S")
"""Quantities whose means are drawn before and behind the stiffness: the paper's "ParOpt"."""

OF_NETWORK = ("C_v", "C_v_plain")
"""Quantities that are sums over vessels at their diastolic pressure, and stand with these."""

_STIFFER, _STRONGER = ("stiffer", "softer", "large arteries"), ("stronger", "weaker", "")
_LONGER, _LARGER = ("longer", "shorter", ""), ("larger", "smaller", "")
_RESISTANCE, _COMPLIANCE, _ELASTANCE = "mmHg s/ml", "ml/mmHg", "mmHg/ml"


class At(NamedTuple):
    """A model where its quantities are taken.

    Attributes
    ----------
    model : Model
    wall : wall law
        Of the root vessel.
    mean : float
        Measured mean pressure, mmHg.
    diastole : Compliance, optional
        At the diastolic pressure of every vessel.
    """

    model: Model
    wall: Any
    mean: float
    diastole: Compliance


QUANTITIES: dict[str, Quantity] = {
    "HR": VENTRICULAR["HR"],
    "CO": Quantity("ml/s", "CO", "cardiac output", "Table 1"),
    "mPAP": Quantity("mmHg", "mPAP", "mean pressure", "Table 1"),
    "sPAP": Quantity("mmHg", "sPAP", "systolic pressure", "Table 1"),
    "dPAP": Quantity("mmHg", "dPAP", "diastolic pressure", "Table 1"),
    "pPAP": Quantity("mmHg", "pPAP", "pulse pressure", "Table 1"),
    "PVR": Quantity(
        _RESISTANCE, "PVR", "vascular resistance, mean pressure above the wedge pressure over mean flow", "Table 1",
        "vascular resistance",
    ),
    "pPAP_over_SV": Quantity(
        _ELASTANCE, "PP/SV", "pulse pressure over stroke volume", "", "pulse pressure / stroke volume",
    ),
    "RC": Quantity(
        "s", "RC", "RC time, PVR times stroke volume over pulse pressure", "", "RC time", comparatives=_LONGER,
    ),
    "SV": VENTRICULAR["SV"],
    "ejection_time": Quantity("s", "ET", "ejection time, from the onset of flow to its end", "", "ejection time",
                              comparatives=_LONGER),
    "acceleration_time": Quantity("s", "AT", "acceleration time, from the onset of flow to its peak", "",
                                  "acceleration time", comparatives=_LONGER),
    "dp_dt_max": VENTRICULAR["dp_dt_max"],
    "dp_dt_min": VENTRICULAR["dp_dt_min"],
    "notch": Quantity("mmHg", "p_notch", "pressure of the dicrotic notch"),
    "E_a_artery": Quantity(
        _ELASTANCE, "E_a (artery)",
        "effective elastance by the artery's pressure at the end of ejection over stroke volume", "",
        "elastance by the artery alone",
    ),
    "augmentation": Quantity(
        "1", "AIx", "augmentation index, share of the pulse pressure that comes after the peak of the flow", "",
        "augmentation",
    ),
    "power": Quantity("mW", "W", "hydraulic power, mean of pressure times flow", "", "hydraulic power"),
    "steady_power": Quantity("mW", "W_s", "steady power, mean pressure times mean flow", "", "steady power"),
    "oscillatory_power": Quantity("mW", "W_o", "oscillatory power, the rest of the hydraulic power", "",
                                  "oscillatory power"),
    "oscillatory_share": Quantity("1", "W_o/W", "share of the oscillatory power", comparatives=_LARGER),
    "incident_energy": Quantity(
        "mJ", "E₊", "energy of the incident wave, a beat, by Z_c to half the upstroke", "", "incident energy",
    ),
    "reflected_energy": Quantity(
        "mJ", "E₋", "energy of the reflected wave, a beat, by Z_c to half the upstroke", "", "reflected energy",
    ),
    "stroke_work": VENTRICULAR["stroke_work"],
    "Z_c": Quantity(_RESISTANCE, "Z_c", "characteristic impedance, up-slope", "8"),
    "Z_0": Quantity(_RESISTANCE, "Z_0", "impedance at zero frequency, mean pressure over mean flow", "19"),
    "I_R": Quantity(
        "1", "I_R", "wave reflection coefficient", "17", "model wave reflection",
        comparatives=_STRONGER,
    ),
    "E_es": VENTRICULAR["E_es"],
    "E_a": VENTRICULAR["E_a"],
    "coupling": VENTRICULAR["coupling"],
    "beta": Quantity(
        "mmHg", "β", "wall stiffness", "3",
        comparatives=_STIFFER,
    ),
    "stiffness": Quantity(
        "mmHg", "β(0)", "stiffness β of the linear law with the same slope at zero pressure", "24", "wall stiffness",
        lambda point: stiffness(point.wall),
        rests_on="wall", comparatives=_STIFFER,
    ),
    "wave_speed": Quantity(
        "cm/s", "c", "wave speed in the root at the measured mean pressure", "31, 32", "wave speed",
        lambda point: wave_speed(point.wall, point.mean, point.model.blood.inertia),
        rests_on="wall", comparatives=("faster", "slower", "waves"),
    ),
    "area_compliance": Quantity(
        "cm2/mmHg", "dA/dp", "area compliance of the root at the measured mean pressure", "26, 27", "",
        lambda point: area_compliance(point.wall, point.mean, point.model.area0[point.model.network.root]),
        rests_on="wall",
    ),
    "R_T": Quantity(
        _RESISTANCE, "R_T", "total resistance of the vascular beds", "11", "resistance of the beds",
        lambda point: point.model.outlets.total_resistance(),
        rests_on="bed",
    ),
    "a": Quantity(
        "1", "a = R_1/R_T", "resistance ratio", "7", "proximal resistance share",
        lambda point: point.model.outlets.resistance_ratio(),
        rests_on="bed", comparatives=_LARGER,
    ),
    "C_p": Quantity(
        _COMPLIANCE, "C_p", "compliance of the vascular beds, each weighted by R2/(R1 + R2)", "30",
        "compliance of the beds",
        lambda point: np.sum(point.model.outlets.weighted_compliance()),
        rests_on="bed",
    ),
    "C_v": Quantity(
        _COMPLIANCE, "C_v", "compliance of the network, series/parallel rule", "28, 29", "compliance of the network",
        lambda point: point.diastole.network_published,
        rests_on="wall",
    ),
    "C_v_plain": Quantity(
        _COMPLIANCE, "ΣC", "compliance of the network, sum over vessels", "25", "",
        lambda point: point.diastole.network_sum,
        rests_on="wall",
    ),
    "C_T": Quantity(
        _COMPLIANCE, "C_T", "total compliance, with C_v by the series/parallel rule", "30", "total compliance",
        lambda point: point.diastole.total(),
    ),
    "C_T_plain": Quantity(
        _COMPLIANCE, "C_T (sum)", "total compliance, with the sum over vessels", "30", "",
        lambda point: point.diastole.total(published=False),
    ),
    "C_p_over_C_T": Quantity(
        "1", "C_p/C_T", "share of the beds in the total compliance", "30", "",
        lambda point: point.diastole.peripheral_share(),
    ),
    "C_p_over_C_T_plain": Quantity(
        "1", "C_p/C_T (sum)", "share of the beds, with the sum over vessels", "30", "",
        lambda point: point.diastole.peripheral_share(published=False),
    ),
    "tau": Quantity(
        "s", "R_T C_T", "time constant R_T C_T of a model, with C_v by the series/parallel rule", "12",
        "model time constant",
        lambda point: point.diastole.time_constant(),
        comparatives=_LONGER,
    ),
    "tau_plain": Quantity(
        "s", "R_T C_T (sum)", "time constant R_T C_T, with the sum over vessels", "12", "",
        lambda point: point.diastole.time_constant(published=False),
        comparatives=_LONGER,
    ),
    "measured_Z_c": Quantity(
        _RESISTANCE, "Z_c (measured)",
        "characteristic impedance of the recording, up-slope; before beds that store much 20 to 45 % high", "8",
        "characteristic impedance",
    ),
    "measured_C_T": Quantity(
        _COMPLIANCE, "C_T (measured)",
        "compliance of the recording, τ of the diastolic decay over PVR; of a Windkessel low by Z_c/PVR", "12",
        "total compliance",
    ),
    "measured_tau": Quantity("s", "τ (measured)", "time constant of the diastolic decay", "12", "time constant"),
    "measured_I_R": Quantity(
        "1", "I_R (measured)", "wave reflection coefficient of the recording", "17", "wave reflection",
        comparatives=_STRONGER,
    ),
    "pressure_drop": Quantity("mmHg", "Δp", "fall of the mean pressure to the terminals, their average"),
    "S": Quantity("mmHg2", "S", "objective at the optimum", "14"),
    "RMSE": Quantity("mmHg", "RMSE", "root-mean-square residual"),
    **LOOPS,
}  # fmt: skip
"""All quantities by the name of their variable, in the order of tables."""


def described(name: str) -> Quantity:
    """Return the description of a quantity; of a parameter, which its law describes, an empty one."""
    return QUANTITIES.get(name, Quantity("", "", ""))


def network_sums(diastole: Compliance) -> dict[str, float]:
    """Return the quantities `OF_NETWORK`."""
    point = At(None, None, np.nan, diastole)  # type: ignore[arg-type]
    return {name: formula(point) for name in OF_NETWORK if (formula := QUANTITIES[name].formula) is not None}


def question_of(name: str) -> str:
    """Return what a quantity tells of."""
    return next((question for question, names in QUESTIONS.items() if name in names), name)


def short_symbol(name: str) -> str:
    """Return the symbol of a quantity, without what it is equal to; a name that is none stays as it is."""
    return QUANTITIES[name].symbol.split(" = ")[0] if name in QUANTITIES else name


def lacking(outlets: Outlets) -> frozenset[str]:
    """Return the quantities that beds do not have: a ratio where one resistance is all, shares of no compliance."""
    split, compliant = outlets.resistance_ratio() not in (0, 1), np.sum(outlets.weighted_compliance()) > 0
    absent = frozenset() if split else frozenset({"a"})
    return absent if compliant else absent | {"C_p", "C_p_over_C_T", "C_p_over_C_T_plain"}


def derived(model: Model, mean: float, diastolic: np.ndarray | None = None) -> dict[str, float]:
    """Return what follows from a model without a simulation and its beds are not `lacking`, in the order of tables.

    Parameters
    ----------
    model : Model
    mean : float
        Pressure at which wave speed and area compliance are taken, mmHg.
    diastolic : array, shape (vessel,), optional
        Diastolic pressure of the vessels, mmHg, at which their compliance is taken; without it only `OF_PARAMETERS`.
    """
    wall = type(model.wall)(*(value[model.network.root] for value in model.wall))
    absent = lacking(model.outlets)
    names = [name for name in (QUANTITIES if diastolic is not None else OF_PARAMETERS) if name not in absent]
    point = At(model, wall, mean, compliance(model, diastolic) if diastolic is not None else None)  # type: ignore[arg-type]
    return {name: float(formula(point)) for name in names if (formula := QUANTITIES[name].formula) is not None}
