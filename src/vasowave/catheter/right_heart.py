"""What the numbers of a right-heart catheter with cardiac output alone determine, and what they do not."""

import math
from dataclasses import dataclass, fields
from pathlib import Path
from typing import NamedTuple

from vasowave.base import units
from vasowave.base.errors import InputError, of_file
from vasowave.base.io.cells import GAPS
from vasowave.base.io.columns import Columns, number, read_columns
from vasowave.catheter.signals.signal import WEDGE_TITLES

_TITLES = {
    "systolic": "systolic", "spap": "systolic", "pasp": "systolic", "diastolic": "diastolic", "dpap": "diastolic",
    "padp": "diastolic", "mean": "mean", "mpap": "mean", "co": "cardiac output", "cardiac output": "cardiac output",
    "hr": "heart rate", "heart rate": "heart rate", "subject": "animal", "patient": "animal", "name": "animal",
    "id": "animal", "systolisch": "systolic", "diastolisch": "diastolic", "mittel": "mean", "hzv": "cardiac output",
    "herzzeitvolumen": "cardiac output", "hf": "heart rate", "herzfrequenz": "heart rate", "tier": "animal",
    "systolique": "systolic", "diastolique": "diastolic", "moyenne": "mean", "débit cardiaque": "cardiac output",
    "fréquence cardiaque": "heart rate", "sistólica": "systolic", "diastólica": "diastolic", "media": "mean",
    "gasto cardíaco": "cardiac output", "frecuencia cardíaca": "heart rate",
}  # fmt: skip
_TITLES |= dict.fromkeys(WEDGE_TITLES, "wedge")
_TITLES |= {f"pap {title}": name for title, name in tuple(_TITLES.items()) if name in ("systolic", "diastolic", "mean")}
_RATES = ("1/min", "/min", "bpm", "beats/min", "min-1")
_TABLE = "a table of 'quantity,value,unit', or of the titles 'mean [mmHg],cardiac output [l/min],…'"
_DYNES = units.MMHG  # dyn s/cm⁵ in one mmHg s/ml
_WOOD = 1e3 / 60.0  # mmHg min/l in one mmHg s/ml

NOT_DETERMINED = (
    "impedance, characteristic impedance and wave reflection (they need pressure and flow over the beat)",
    "the law and the stiffness of the walls, pulse wave velocity and a fit of the model (they need these waves and the "
    "vessels)",
)
"""What no such numbers determine."""
_HIGH_WEDGE = (
    "the wedge is above the diastolic pressure, as with large v waves or a catheter that is not wedged: PVR is then "
    "too low; read the wedge at end-expiration, between its waves"
)


class Derived(NamedTuple):
    """A quantity that follows from the numbers: value and unit, by which formula and whose."""

    name: str
    value: float
    unit: str
    formula: str


@dataclass(frozen=True)
class RightHeart:
    """Numbers of a right-heart catheter.

    Parameters
    ----------
    mean, systolic, diastolic, wedge : float
        Pressures in the pulmonary artery and the pressure behind it, mmHg; None where not measured, but for `mean`.
    cardiac_output : float
        ml/s.
    heart_rate : float, optional
        beats/min.
    name : str

    Raises
    ------
    InputError
        Pressures that contradict each other, an output or a rate that is not positive.

    Examples
    --------
    >>> from vasowave.catheter import RightHeart
    >>> numbers = RightHeart(mean=38, cardiac_output=4600 / 60, systolic=62, diastolic=24, wedge=11, heart_rate=78)
    >>> {item.name: round(item.value, 3) for item in numbers.derived()}["PVR"]
    0.352
    """

    mean: float
    cardiac_output: float
    systolic: float | None = None
    diastolic: float | None = None
    wedge: float | None = None
    heart_rate: float | None = None
    name: str = ""

    def __post_init__(self) -> None:
        """Refuse what no catheter reads."""
        numbers = (self.mean, self.cardiac_output, self.systolic, self.diastolic, self.wedge, self.heart_rate)
        if not all(number is None or math.isfinite(number) for number in numbers) or not self.mean > 0:
            raise InputError("the mean is above 0 and all numbers are finite; correct them")
        low, high = self.diastolic, self.systolic
        if not (low is None or low <= self.mean) or not (high is None or self.mean <= high):
            raise InputError(f"a mean of {self.mean:g} mmHg does not lie between diastolic {low} and systolic {high}")
        if self.wedge is not None and self.wedge > self.mean:
            raise InputError(
                f"a wedge of {self.wedge:g} mmHg is above the mean, {self.mean:g}; exchange or correct them"
            )
        if not self.cardiac_output > 0 or not (self.heart_rate is None or self.heart_rate > 0):
            raise InputError("cardiac output and heart rate are above 0; correct them")

    def derived(self) -> tuple[Derived, ...]:
        """Return all that follows from what was measured.

        PVR, TPG and DPG as Humbert et al. (2022), stroke volume over pulse pressure as Mahapatra et al. (2006), the RC
        time as Lankhaar et al. (2008).
        """
        flow = self.cardiac_output
        items = [
            Derived("mean flow", flow, "ml/s", "CO"),
            Derived("R_T", self.mean / flow, "mmHg s/ml", "mean / CO, from the artery to 0 mmHg"),
        ]
        resistance = pulse = stroke = None
        if self.wedge is not None:
            resistance = (self.mean - self.wedge) / flow
            items += [
                Derived("TPG", self.mean - self.wedge, "mmHg", "mean - wedge (Humbert 2022)"),
                Derived("PVR", resistance, "mmHg s/ml", "TPG / CO (Humbert 2022)"),
                Derived("PVR in Wood units", resistance * _WOOD, "mmHg min/l", "the same"),
                Derived("PVR in dynes", resistance * _DYNES, "dyn s/cm5", "the same"),
            ]
            if self.diastolic is not None:
                items.append(Derived("DPG", self.diastolic - self.wedge, "mmHg", "diastolic - wedge (Humbert 2022)"))
        if self.systolic is not None and self.diastolic is not None:
            pulse = self.systolic - self.diastolic
            items.append(Derived("pulse pressure", pulse, "mmHg", "systolic - diastolic"))
        if self.heart_rate is not None:
            stroke = 60.0 * flow / self.heart_rate
            items.append(Derived("stroke volume", stroke, "ml", "CO / HR"))
        if stroke is not None and pulse:
            capacitance = "SV / pulse pressure (Mahapatra 2006): above C, since blood runs off while it is ejected"
            items.append(Derived("C", stroke / pulse, "ml/mmHg", capacitance))
            if resistance is not None:
                items.append(Derived("RC time", resistance * stroke / pulse, "s", "PVR x C (Lankhaar 2008)"))
        return tuple(items)

    def __str__(self) -> str:
        """Return what follows, line by line, what was not given for more, and what such numbers cannot tell."""
        lines = [f"{item.name:18} {item.value:10.4g} {item.unit:11} {item.formula}" for item in self.derived()]
        if self.wedge is not None and self.diastolic is not None and self.diastolic < self.wedge:
            lines.append(_HIGH_WEDGE)
        missing = [field.name.replace("_", " ") for field in fields(self) if getattr(self, field.name) is None]
        lines += [f"not given, and what needs it left out: {', '.join(missing)}"] if missing else []
        return "\n".join([*([self.name] if self.name else []), *lines, f"Not determined: {'; '.join(NOT_DETERMINED)}"])


def read_right_heart(path: str | Path) -> tuple[RightHeart, ...]:
    """Read the numbers of right-heart catheters: a row a quantity (quantity, value, unit), or a row an animal.

    Raises
    ------
    InputError
        File and line of: no mean or no cardiac output, a quantity that is not known, a unit that is missing or another
        quantity's, a cell that is not a number; what `RightHeart` refuses.

    Examples
    --------
    >>> import vasowave as vw
    >>> from pathlib import Path
    >>> rows = ["animal,mean [mmHg],wedge [mmHg],CO [ml/s],HR [1/min]", "pig 3,38,10,60,82", ""]
    >>> _ = Path("catheter.csv").write_text("\\n".join(rows))
    >>> vw.read_right_heart("catheter.csv")[0].mean
    38.0
    """
    table = read_columns(path, _TITLES)
    table.warn()
    if table.find("quantity") is not None:
        return (_of_rows(table),)
    if lacking := [name for name in ("mean", "cardiac output") if table.find(name) is None]:
        titles = ", ".join(f"'{name}'" for name in table.names)
        raise InputError(f"{table.source}: no column says {' or '.join(lacking)}; it has {titles}; give {_TABLE}")
    return tuple(_of_row(table, row) for row in range(len(table.cells)))


def _of_rows(table: Columns) -> RightHeart:
    places = [table.require(name) for name in ("quantity", "value", "unit")]
    values: dict[str, float | str] = {}
    for line, cells in zip(table.lines, table.cells, strict=True):
        title, text, unit = (cells[place].strip() for place in places)
        quantity = _TITLES.get(title.lower(), "")
        if quantity and text.upper() in GAPS:
            continue
        if not quantity or quantity in values:
            reason = "stands twice" if quantity else f"is not known; known are {', '.join(_TITLES)}"
            raise InputError(f"{table.source}, line {line}: '{title}' {reason}")
        values[quantity] = _value(f"{table.source}, line {line}", quantity, text, unit)
    return _made(table.source, values)


def _of_row(table: Columns, row: int) -> RightHeart:
    where, values = f"{table.source}, line {table.lines[row]}", dict[str, float | str]()
    for name, unit, text in zip(table.names, table.units, table.cells[row], strict=True):
        if name in _TITLES.values() and text.strip().upper() not in GAPS:
            values[name] = _value(where, name, text.strip(), unit)
    return _made(where, values)


def _value(where: str, quantity: str, text: str, unit: str) -> float | str:
    if quantity == "animal":
        return text
    kind = {"cardiac output": "flow", "heart rate": "rate, such as 1/min"}.get(quantity, "pressure")
    if not unit or (quantity == "heart rate" and unit.lower() not in _RATES):
        raise InputError(f"{where}: {quantity} needs its unit, one of {kind}; it has '{unit}'")
    with of_file(f"{where}, {quantity}"):
        scale = 1.0 if quantity == "heart rate" else units.factor(unit, kind)
    try:
        return number(text) * scale
    except ValueError:
        raise InputError(f"{where}, {quantity}: '{text}' is not a number") from None


def _made(where: str, values: dict[str, float | str]) -> RightHeart:
    lacking = [name for name in ("mean", "cardiac output") if name not in values]
    if lacking:
        raise InputError(f"{where}: no {' and no '.join(lacking)}; give {_TABLE}")
    arguments = {name.replace(" ", "_"): value for name, value in values.items() if name != "animal"}
    with of_file(where):
        return RightHeart(name=str(values.get("animal", "")), **arguments)  # type: ignore[arg-type]
