"""What is said of numbers and wall laws: units, symbols, words, equations; where a fit starts and may go."""

from typing import NamedTuple


class Quantity(NamedTuple):
    """What a number is.

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
    """

    unit: str
    symbol: str
    meaning: str
    equation: str = ""


class Parameter(NamedTuple):
    """A number that is fitted. Pressures are multiples of the nominal stiffness β0 (eq. 9), pure numbers are plain.

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
    """

    unit: str
    symbol: str
    meaning: str
    equation: str
    nominal: float
    bounds: tuple[float, float]
    paper_bounds: tuple[float, float] | None = None

    def scale(self, beta0: float) -> float:
        """Return the number that turns multiples into values: β0 (mmHg) for a pressure, 1 otherwise."""
        return beta0 if self.unit == "mmHg" else 1.0

    def limits(self, paper: bool) -> tuple[float, float]:
        """Return the paper's bounds, or the wide ones."""
        return self.paper_bounds if paper and self.paper_bounds is not None else self.bounds


class Law(NamedTuple):
    """What is said of a wall law.

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
    """

    name: str
    title: str
    formula: str
    equation: str
    parameters: tuple[Parameter, ...]
    stiffness: str = "stiffness"
    ratio: tuple[str, Quantity] | None = None
    linear_at: tuple[str, float] | None = None
