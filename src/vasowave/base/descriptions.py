"""Descriptions of numbers, wall laws and beds: units, symbols, words, equations; where a fit starts and may go."""

from collections.abc import Callable
from typing import Any, Literal, NamedTuple

LEVEL = 0.95
"""Level of all intervals."""

NORMAL = 1.959964
"""Half width of such an interval of a normal distribution, in standard errors."""

TAILS = (0.025, 0.5, 0.975)
"""Shares below the lower end of such an interval, the median, and the upper end."""

MOST_LEFT = 0.1
"""Share of the pulse pressure; a model that leaves more of it as root-mean-square residual misses its data."""

CLEAR_EVIDENCE_RATIO = 20.0
"""Ratio of two evidences from which one law is called clearly likelier: with equal chances before, 95 % after."""

MAX_LOG_DISTANCE = 200.0
"""Farthest end of an interval, in the logarithm: an endless interval stays a finite number."""

FORBIDDEN, AT_BOUND, OPEN = "*", "†", "‡"
"""Marks behind a number that must not be used, that rests on a parameter at a bound of its search, or that the data do
not determine."""

ROUNDING = 1e-9
"""Share of a value by which an end of its interval may differ from it by rounding alone."""


def parameter_mark(free: bool, at_bound: bool, determined: bool) -> str:
    """Return the mark behind a parameter: at a bound, free and not determined, or none."""
    return AT_BOUND if at_bound else OPEN if free and not determined else ""


class Quantity(NamedTuple):
    """The description of a number.

    Attributes
    ----------
    unit : str
        As `units` writes it; "1" for a pure number.
    symbol : str
        With ``_`` before a subscript.
    meaning : str
        In words.
    equation : str
        Number of the paper's equation, or its table.
    words : str
        The meaning in a few words, where `meaning` is long.
    formula : callable, optional
        Returns the number for a model, see `quantities.At`.
    rests_on : str
        The parameters that it rests on: those of the ``wall``, of the ``bed``; empty: all.
    comparatives : (str, str, str)
        How a higher and a lower value are called, and of what where that is not the quantity itself.
    """

    unit: str
    symbol: str
    meaning: str
    equation: str = ""
    words: str = ""
    formula: Callable[[Any], Any] | None = None
    rests_on: Literal["", "wall", "bed"] = ""
    comparatives: tuple[str, str, str] = ("higher", "lower", "")


class Parameter(NamedTuple):
    """A number that is fitted. Pressures are multiples of the nominal stiffness β0 (eq. 9), viscosities of β0
    times 1 s; pure numbers are plain.

    Attributes
    ----------
    unit, symbol, meaning, equation : str
        As in `Quantity`.
    nominal : float
        Where a search starts.
    bounds : (float, float)
        Bounds that only keep a search among possible animals.
    paper_bounds : (float, float), optional
        The paper's (Table "Bounds"); `bounds` where it has none.
    spread : float
        SD of the logarithm around the nominal value before the recording is seen, for a posterior.
    held : bool
        Held at its nominal value unless bounds are given for it.
    """

    unit: str
    symbol: str
    meaning: str
    equation: str
    nominal: float
    bounds: tuple[float, float]
    paper_bounds: tuple[float, float] | None = None
    spread: float = 1.0  # right within a factor of 7 (95 %)
    held: bool = False

    def scale(self, beta0: float) -> float:
        """Return the number that turns multiples into values: β0 for a pressure or a viscosity, 1 otherwise."""
        return beta0 if self.unit in ("mmHg", "mmHg s") else 1.0

    def limits(self, paper: bool) -> tuple[float, float]:
        """Return the paper's bounds, or the wide ones."""
        return self.paper_bounds if paper and self.paper_bounds is not None else self.bounds


class Law(NamedTuple):
    """The description of a wall law.

    Attributes
    ----------
    name : str
        One word, by which it is chosen and under which its results stand.
    title : str
        In words, as in "a linear elastic law".
    formula : str
        Pressure as a function of A/A₀.
    equation : str
        Number of the paper's equation, empty if it has none.
    parameters : tuple of Parameter
        In the order of the class's fields.
    stiffness : str
        Quantity that stands for the stiffness in tables: a parameter, a name in `ratio`, or "stiffness".
    ratio : (str, Quantity), optional
        Name and description of first over second parameter, where the data determine it better than either.
    linear_at : (str, float), optional
        A parameter that says how the wall stiffens, and its value at which the law is the linear one.
    lowest : float
        Transmural pressure, mmHg, below which the law does not hold: so thin a wall buckles long before.
    """

    name: str
    title: str
    formula: str
    equation: str
    parameters: tuple[Parameter, ...]
    stiffness: str = "stiffness"
    ratio: tuple[str, Quantity] | None = None
    linear_at: tuple[str, float] | None = None
    lowest: float = -5.0


class BedLaw(NamedTuple):
    """The description of a kind of vascular beds.

    Attributes
    ----------
    name : str
        One word, by which it is chosen.
    title : str
        In words, as in "three-element Windkessels".
    formula : str
        Impedance.
    equation : str
        Number of the paper's equation, empty if it has none.
    quantities : dict of str to Quantity
        The class's fields.
    factors : dict of str to Parameter
        What is fitted: a factor of the nominal values of each field that is `fitted`, all beds alike, in their order.
    shared : (str, str), optional
        The two factors between which the recording splits one resistance.
    fitted : tuple of str
        The fields that have a factor each; empty if all have.
    """

    name: str
    title: str
    formula: str
    equation: str
    quantities: dict[str, Quantity]
    factors: dict[str, Parameter]
    shared: tuple[str, str] | None = None
    fitted: tuple[str, ...] = ()
