"""How finely and how long to simulate."""

from dataclasses import dataclass

from vasowave.errors import InputError


@dataclass(frozen=True)
class Numerics:
    """How finely and how long to simulate; the defaults serve every network of the size of a mouse lung.

    ``Numerics(accuracy=0.02)`` is the ordinary way to ask where the default may not do: cells and steps follow from it.

    Attributes
    ----------
    accuracy : float, optional
        Largest error of pressure at inlet, middle and outlet of every vessel that space and time steps may leave, mmHg.
        It is estimated from two grids and reported; what cannot be reached is an error.
    cell_size : float
        Longest cell, cm; every vessel gets at least two cells.
    samples : int
        Evenly spaced output times per cycle.
    steps_per_cycle : int, optional
        Time steps a cycle, a multiple of `samples`; by default chosen from the wave speeds met.
    tolerance : float
        The state is periodic when no variable changes by more than this over a cycle, mmHg. The default is the paper's
        criterion, squared change below 1e-8, asked of every cell and every outlet.
    most_cycles : int
        Cycles after which a state that is still not periodic is an error.
    cycles_from_rest : int, optional
        Simulate exactly this many cycles from rest instead, periodic or not (the paper's practice: 8).
    most_steps : int
        A model that asks for more steps a cycle is an error, which says which vessel asks for them.
    every_cell : bool
        Return every cell instead of inlet, middle and outlet of each vessel.
    """

    accuracy: float | None = None
    cell_size: float = 0.1
    samples: int = 512
    steps_per_cycle: int | None = None
    tolerance: float = 1e-4
    most_cycles: int = 60
    cycles_from_rest: int | None = None
    most_steps: int = 100_000
    every_cell: bool = False

    def __post_init__(self) -> None:
        """Check the values."""
        if self.accuracy is not None:
            if not self.accuracy > 0:
                raise InputError(f"accuracy {self.accuracy} mmHg is not positive")
            if self.steps_per_cycle is not None or self.cycles_from_rest is not None:
                raise InputError("accuracy chooses steps and cycles: leave steps_per_cycle and cycles_from_rest out")
        if not self.cell_size > 0:
            raise InputError(f"cell_size {self.cell_size} cm is not positive")
        if self.samples < 1 or self.most_cycles < 1 or not self.tolerance > 0:
            raise InputError("samples and most_cycles must be at least 1, and tolerance positive")
        if self.cycles_from_rest is not None and self.cycles_from_rest < 1:
            raise InputError(f"cycles_from_rest {self.cycles_from_rest} must be at least 1")
        if self.steps_per_cycle is not None and (self.steps_per_cycle < 1 or self.steps_per_cycle % self.samples):
            raise InputError(
                f"steps_per_cycle {self.steps_per_cycle} is not a multiple of samples {self.samples}; "
                f"take {max(1, -(-self.steps_per_cycle // self.samples)) * self.samples}"
            )
