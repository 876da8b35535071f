"""What a family of loops of pressure and volume tells of a ventricle: lines through their corners, with intervals.

Beats before the preload falls are its steady state, those of the fall its family. Each number of a steady beat is a
mean over these beats; a line goes through one point of each beat of the family.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from vasowave.base.accessors import Accessor
from vasowave.base.descriptions import LEVEL, NORMAL, Quantity
from vasowave.base.errors import InputError, VasowaveError
from vasowave.base.findings import Finding, look_kind, note_kind
from vasowave.pulse.analysis.family_lines import IntervalEstimate, family_lines
from vasowave.pulse.analysis.loop_doubts import doubts_of_loops
from vasowave.pulse.analysis.loops import PressureVolumeLoop, cut_loops, mean_loop
from vasowave.pulse.analysis.selected_beats import beats_within, falling_beats, usable_beats
from vasowave.pulse.analysis.ventricle_coupling import UNLIKE, coupling
from vasowave.pulse.cycle.cycle import Recording
from vasowave.pulse.cycle.ventricular import PressureVolume, VentricularPressure

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes


@dataclass(frozen=True)
class FamilyRules:
    """What makes a family, and the mean loop of the steady beats."""

    min_fall: float = 0.2  # of the end-diastolic volume of a family, as a share of the stroke volume
    min_beats: int = 5  # of a family
    steady_beats: int = 8  # before the fall, that belong to the family, too
    cycle_samples: int = 256  # of the mean loop that the estimate by one beat takes


RULES = FamilyRules()
_ELASTANCE = "mmHg/ml"

VENTRICULAR: dict[str, Quantity] = {
    "HR": Quantity("beats/min", "HR", "heart rate", "Table 1"),
    "EDV": Quantity("ml", "EDV", "volume at the end of diastole", "", "end-diastolic volume"),
    "ESV": Quantity("ml", "ESV", "volume at the end of systole, the upper left corner of the loop", "",
                    "end-systolic volume"),
    "SV": Quantity("ml", "SV", "stroke volume", comparatives=("larger", "smaller", "")),
    "EF": Quantity("1", "EF", "ejection fraction, stroke volume over largest volume", "", "ejection fraction"),
    "EDP": Quantity("mmHg", "EDP", "pressure at the end of diastole", "", "end-diastolic pressure"),
    "ESP": Quantity("mmHg", "ESP", "pressure at the end of systole, the upper left corner of the loop", "",
                    "end-systolic pressure"),
    "stroke_work": Quantity("mJ", "SW", "stroke work of the ventricle", comparatives=("larger", "smaller", "")),
    "dp_dt_max": Quantity("mmHg/s", "dp/dt max", "steepest rise of the pressure", "", "steepest rise"),
    "dp_dt_min": Quantity("mmHg/s", "dp/dt min", "steepest fall of the pressure", "", "steepest fall"),
    "tau_weiss": Quantity("s", "τ (Weiss)", "time constant of relaxation towards zero", "", "relaxation time"),
    "tau_glantz": Quantity("s", "τ (Glantz)", "time constant of relaxation towards an asymptote", "",
                           "relaxation time with an asymptote"),
    "E_a": Quantity(
        _ELASTANCE, "E_a", "effective elastance of the artery, end-systolic pressure over stroke volume", "",
        "elastance of the artery",
    ),
    "E_es_single_beat": Quantity(
        _ELASTANCE, "E_es (one beat)",
        "end-systolic elastance by the mean steady beat alone; in simulated hearts 10 to 40 % too low", "",
        "elastance by one beat",
    ),
    "E_es": Quantity(_ELASTANCE, "E_es", "end-systolic elastance of the ventricle", "", "elastance of the ventricle"),
    "V_0": Quantity("ml", "V_0", "volume at which the end-systolic line has no pressure", "",
                    "volume without pressure"),
    "coupling": Quantity("1", "E_es/E_a", "coupling of ventricle and artery", "", "coupling of ventricle and artery"),
    "PRSW": Quantity("mmHg", "PRSW", "preload-recruitable stroke work, its rise with the end-diastolic volume", "",
                     "preload-recruitable stroke work"),
    "V_w": Quantity("ml", "V_w", "end-diastolic volume at which no stroke work is left", "", "volume without work"),
    "dp_dt_max_over_EDV": Quantity("mmHg/s/ml", "dE/dt max", "rise of dp/dt max with the end-diastolic volume", "",
                                   "rise of dp/dt max with volume"),
    "diastolic_slope": Quantity(_ELASTANCE, "E_ed", "slope of the line through the end-diastolic points", "",
                                "diastolic elastance"),
    "diastolic_beta": Quantity("1/ml", "β_ed", "exponent of an exponential through the end-diastolic points", "",
                               "diastolic exponent"),
}  # fmt: skip
"""The numbers of a ventricle by their names, in the order of tables."""

NO_FAMILY = note_kind(
    "loops.no-family",
    "{source}: the end-diastolic volume falls by {percent:.0f} % of the stroke volume in a row, over {beats} beats: no "
    "family of loops, so no E_es, V_0, preload-recruitable work and end-diastolic line",
)
NO_STEADY_BEAT = look_kind(
    "loops.no-steady-beat",
    "{source}: the preload falls from the first beat on: the numbers of steady beats are those of this beat alone",
    "Record some beats before the vena cava is closed, or name the stretch of the steady state.",
)
NOT_ALL_BEATS = note_kind(
    "loops.beats-left-out",
    "{source}: {count} of {beats} beats were left out: their length or stroke differs from that of the beats around",
)
NO_ONE_BEAT = note_kind("loops.no-one-beat", "{source}: no elastance by one beat: {why}")


@dataclass(frozen=True, eq=False)
class VentricularFunction:
    """A ventricle by its loops of pressure and volume.

    Attributes
    ----------
    source : str
    loops : tuple of PressureVolumeLoop
        All beats in the order of time.
    steady, family : tuple of int
        Which of them are the steady state, and which the fall of the preload; empty where it does not fall.
    estimates : dict of str to IntervalEstimate
        By the names of `VENTRICULAR`; what the loops do not tell is absent.
    findings : tuple of Finding

    Examples
    --------
    >>> import numpy as np
    >>> import vasowave as vw
    >>> turn = 2 * np.pi * np.arange(0, 8, 0.002)
    >>> loops = vw.pressure_volume(vw.PressureVolume(40 - 40 * np.cos(turn - 1), 90 + 30 * np.cos(turn), 500))
    >>> loops.table.loc["stroke_work", "unit"], loops.estimates["SV"].beats
    ('mJ', 7)
    """

    source: str
    loops: tuple[PressureVolumeLoop, ...]
    steady: tuple[int, ...]
    family: tuple[int, ...]
    estimates: dict[str, IntervalEstimate]
    findings: tuple[Finding, ...] = ()

    @property
    def table(self) -> "pd.DataFrame":
        """Index: name; columns ``symbol``, ``value``, ``low``, ``high``, ``unit``, ``beats``, ``meaning``."""
        import pandas as pd

        table = pd.DataFrame.from_dict(self.estimates, orient="index", columns=IntervalEstimate._fields)
        for place, field in ((0, "symbol"), (4, "unit"), (6, "meaning")):
            table.insert(place, field, [getattr(VENTRICULAR[name], field) for name in self.estimates])
        return table.rename_axis("quantity")

    @property
    def beats(self) -> "pd.DataFrame":
        """A row each beat: the numbers of a single loop, and whether it is ``steady``, of the ``family`` or neither."""
        import pandas as pd

        state = dict.fromkeys(self.steady, "steady") | dict.fromkeys(self.family, "family")
        rows = [{"state": state.get(number, "left out")} | loop.values() for number, loop in enumerate(self.loops)]
        return pd.DataFrame(rows, index=pd.Index([loop.start for loop in self.loops], name="start [s]"))

    @Accessor
    def plot(self, ax: "Axes | None" = None) -> "Axes":
        """Draw the loops, their end-systolic and end-diastolic points, and the lines through them."""
        raise NotImplementedError

    def __repr__(self) -> str:
        shown = (name for name in ("E_es", "E_a", "EF") if name in self.estimates)
        numbers = ", ".join(f"{name} {self.estimates[name].value:.4g} {VENTRICULAR[name].unit}" for name in shown)
        return f"VentricularFunction({len(self.steady)} steady beats, {len(self.family)} of a family, {numbers})"


def pressure_volume(
    recording: PressureVolume,
    steady: tuple[float, float] | None = None,
    family: tuple[float, float] | None = None,
) -> VentricularFunction:
    """Return what loops of pressure and volume tell of a ventricle, each number with its 95 % interval.

    Parameters
    ----------
    recording : PressureVolume
    steady, family : (float, float), optional
        Stretches of the steady state and of the falling preload, s; by default the longest fall of the end-diastolic
        volume is the family, and what comes before it is steady.

    Raises
    ------
    InputError
        A pressure that does not beat, too few samples a beat, a stretch without beats.

    Notes
    -----
    E_es and V_0 by the line through the points of largest ``p / (V - V_0)``, taken anew with each V_0 until it stays
    (Sagawa 1978; Kono et al. 1984), E_a by Sunagawa et al. (1983), preload-recruitable work by Glower et al. (1985),
    dp/dt max over end-diastolic volume by Little (1985). Intervals of lines are those of least squares, that of a zero
    crossing is Fieller's; noise of the volume, known from what the filter took away, does not flatten the lines.

    Examples
    --------
    >>> import numpy as np
    >>> import vasowave as vw
    >>> turn = 2 * np.pi * np.arange(0, 8, 0.002)
    >>> loops = vw.pressure_volume(vw.PressureVolume(40 - 40 * np.cos(turn - 1), 90 + 30 * np.cos(turn), 500))
    >>> round(loops.estimates["SV"].value)  # ml
    60
    """
    _check(recording, {"steady": steady, "family": family})
    cut, source = cut_loops(recording), recording.source
    findings, usable = list[Finding](), usable_beats(cut.loops)
    if len(usable) < len(cut.loops):
        count = len(cut.loops) - len(usable)
        findings.append(NOT_ALL_BEATS(source=source, count=count, beats=len(cut.loops)))
    fall = falling_beats(cut.loops, usable) if family is None else beats_within(cut.loops, usable, family, source)
    depth = float(
        np.ptp([cut.loops[n].volume[0] for n in fall]) / np.median([loop.stroke_volume for loop in cut.loops])
    )
    estimates = dict[str, IntervalEstimate]()
    if len(fall) < RULES.min_beats or depth < RULES.min_fall:
        findings.append(NO_FAMILY(source=source, percent=100 * depth, beats=len(fall)))
        fall = []
    before = [number for number in usable if not fall or number < fall[0]]
    if not before and steady is None:
        findings.append(NO_STEADY_BEAT(source=source))
    before = before or fall[:1]
    chosen = before if steady is None else beats_within(cut.loops, usable, steady, source)
    if fall:
        fall = fall if family is not None else [*[n for n in before if n < fall[0]][-RULES.steady_beats :], *fall]
        estimates, remarks = family_lines(cut, fall, source)
        findings += remarks
    estimates |= _means([cut.loops[number].values() for number in chosen])
    if fall:
        estimates["coupling"] = _ratio(estimates["E_es"], estimates["E_a"])
    by_one, remarks = _by_one_beat([cut.loops[number] for number in chosen], source)
    estimates |= by_one
    finite = {name: estimates[name] for name in VENTRICULAR if name in estimates and np.isfinite(estimates[name].value)}
    steady_loops = [cut.loops[number] for number in chosen]
    findings += [*doubts_of_loops(estimates, steady_loops, source, recording.volume_delay), *remarks]
    return VentricularFunction(source, cut.loops, tuple(chosen), tuple(fall), finite, (*recording.notes, *findings))


def _check(recording: PressureVolume, stretches: Mapping[str, tuple[float, float] | None]) -> None:
    if not isinstance(recording, PressureVolume):
        kind = type(recording).__name__
        raise InputError(f"{kind} was given where a PressureVolume is needed; of a file: read_loops(path)")
    for name, stretch in stretches.items():
        if stretch is not None and len(stretch) != 2:
            raise InputError(f"{name}: give two times in s, as (2, 8.5)")


def _means(rows: Sequence[dict[str, float]]) -> dict[str, IntervalEstimate]:
    """Return the means of numbers over beats; a single beat has no interval."""
    from scipy.stats import t as student

    estimates = {}
    for name in rows[0]:
        values = np.array([row[name] for row in rows])
        values = values[np.isfinite(values)]
        count = len(values)
        mean = float(values.mean()) if count else np.nan
        half = np.nan
        if count > 1:
            half = float(student.ppf(0.5 + LEVEL / 2, count - 1) * values.std(ddof=1) / np.sqrt(count))
        estimates[name] = IntervalEstimate(mean, mean - half, mean + half, count)
    return estimates


def _ratio(above: IntervalEstimate, below: IntervalEstimate) -> IntervalEstimate:
    """Return a ratio of two estimates that err independently, with an interval of its logarithm."""
    ratio = above.value / below.value
    halves = [0.5 * (estimate.high - estimate.low) / estimate.value for estimate in (above, below)]
    factor = np.exp(np.hypot(*np.nan_to_num(halves)))
    return IntervalEstimate(ratio, ratio / factor, ratio * factor, above.beats)


def _by_one_beat(loops: Sequence[PressureVolumeLoop], source: str) -> tuple[dict[str, IntervalEstimate], list[Finding]]:
    """Return the elastance by the shape of the mean steady beat, as `coupling` finds it from pressure and outflow."""
    pressure, volume = mean_loop(loops, RULES.cycle_samples)
    period = float(np.mean([loop.period for loop in loops]))
    outflow = -np.gradient(volume) * RULES.cycle_samples / period
    ejecting = np.arange(len(volume)) <= int(np.argmin(volume))
    flow = np.where(ejecting, np.maximum(outflow, 0.0), 0.0)[:-1]
    try:
        cycle = Recording(pressure[:-1], flow, period, source)
        beat = coupling(cycle, VentricularPressure(pressure[:-1], period, source))
    except VasowaveError as error:
        return {}, [NO_ONE_BEAT(source=source, why=str(error))]
    unlike = [finding for finding in beat.findings if finding.code == UNLIKE.code]
    value, factor = beat.elastance, float(np.exp(NORMAL * beat.error))
    return {"E_es_single_beat": IntervalEstimate(value, value / factor, value * factor, len(loops))}, unlike
