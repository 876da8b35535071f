"""One averaged cycle of pressure and flow, and the hemodynamic indices of the paper's Table 1."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from vasowave.base.accessors import Accessor
from vasowave.base.errors import InputError
from vasowave.base.findings import Finding, note_kind, texts
from vasowave.base.notebook import card
from vasowave.base.sites import PULMONARY

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.axes import Axes

MAX_SAMPLES = 65_536  # of an averaged cycle: the longest one, 3 s, at 20 kHz
MIN_SAMPLES = 32
"""A cycle with fewer samples cannot carry the 14 harmonics that the impedance analysis reads."""

_CUT_OFF_SHARE = 1e-9  # of the largest modulus: a harmonic below it was cut off, not measured


RESAMPLED = note_kind("recording.resampled", "resampled to {count} samples")


@dataclass(frozen=True, eq=False)
class Inflow:
    """A periodic flow into the root vessel, or into every inlet of a network with several.

    Attributes
    ----------
    flow : float array, shape (sample,) or (sample, inlet)
        Evenly spaced over one period, the first sample at t = 0, not repeated at the end; ml/s. A column for each of
        ``network.inlets``, in their order.
    period : float
        Period T, s.

    Examples
    --------
    >>> import vasowave as vw
    >>> import numpy as np
    >>> t = np.arange(64) / 64
    >>> flow = 0.4 * np.exp(-0.5 * ((t - 0.3) / 0.1) ** 2)
    >>> round(float(vw.Inflow(flow, period=0.11).flow.mean()), 3)  # ml/s
    0.1
    """

    flow: np.ndarray
    period: float

    of_pressure: ClassVar[bool] = False
    """Whether what is given is a pressure."""

    def __post_init__(self) -> None:
        """Check the values and freeze the array."""
        flow = np.array(self.flow, dtype=float)
        columns = flow.T if flow.ndim == 2 and flow.size else [flow]
        checked = [cycle_samples(column, "flow") for column in columns]
        object.__setattr__(self, "flow", _frozen(np.stack(checked, axis=1)) if flow.ndim == 2 else checked[0])
        object.__setattr__(self, "period", _period(self.period))

    def resampled(self, count: int) -> np.ndarray:
        """Return `count` evenly spaced samples of the flow, ml/s, by Fourier interpolation."""
        return resample(self.flow, count)

    def into(self, inlets: Sequence[str]) -> np.ndarray:
        """Return the flow into each of these vessels, ml/s, shape (sample, inlet); `InputError` for other numbers."""
        columns = self.flow.reshape(len(self.flow), -1)
        if columns.shape[1] != len(inlets):
            raise InputError(
                f"the network has {len(inlets)} inlet(s) ({', '.join(map(repr, inlets[:5]))}) and {columns.shape[1]} "
                "inflow(s) are given; give Inflow(flow, period) a column of flow for each inlet, in this order"
            )
        return columns


@dataclass(frozen=True, eq=False)
class InletPressure:
    """A periodic pressure at the inlet of the root vessel, which drives it: the flow follows from the model.

    Attributes
    ----------
    pressure : float array, shape (sample,)
        Evenly spaced over one period, the first sample at t = 0, not repeated at the end; mmHg.
    period : float
        Period T, s.

    Raises
    ------
    InputError
        Too few samples, a value that is not finite, a period that is not positive.

    Examples
    --------
    >>> import vasowave as vw
    >>> network, mouse = vw.control_network(), vw.virtual_mouse()
    >>> nominal = vw.estimate_nominal(network, mouse)
    >>> model = vw.Model(network, vw.LinearWall(60.0), nominal.outlets)
    >>> waves = vw.simulate(model, vw.InletPressure(mouse.pressure, mouse.period))
    >>> round(float(waves.flow.sel(vessel="1", station="inlet").mean()), 2)  # ml/s
    0.1...
    """

    pressure: np.ndarray
    period: float

    of_pressure: ClassVar[bool] = True
    """Whether what is given is a pressure."""

    def __post_init__(self) -> None:
        """Check the values and freeze the array."""
        object.__setattr__(self, "pressure", cycle_samples(self.pressure, "pressure"))
        object.__setattr__(self, "period", _period(self.period))

    def into(self, inlets: Sequence[str]) -> np.ndarray:
        """Return the pressure at the only one of these inlets, mmHg, shape (sample, 1); `InputError` for several."""
        require_one(inlets, "a pressure")
        return self.pressure.reshape(-1, 1)


def require_one(inlets: Sequence[str], driver: str) -> None:
    """Raise `InputError` where a network has several inlets and only a flow can drive them."""
    if len(inlets) != 1:
        raise InputError(
            f"the network has {len(inlets)} inlets ({', '.join(map(repr, inlets[:5]))}): {driver} drives one inlet "
            "only; give Inflow(flow, period) a column of flow for each inlet"
        )


@dataclass(frozen=True, eq=False)
class Recording:
    """One ensemble-averaged cycle of pressure and flow at the inlet of the root vessel.

    Attributes
    ----------
    pressure : float array, shape (pressure sample,)
        Evenly spaced over one period, the first sample at t = 0, not repeated at the end; mmHg.
    flow : float array, shape (flow sample,)
        Likewise, ml/s. The two may be sampled at different rates.
    period : float
        Period T, s.
    source : str
        Where the recording came from.
    notes : tuple of Finding
        What was noticed or assumed while it was read; stands in every report.
    pressure_error, flow_error : float array, shape (harmonic,), optional
        Standard error of the amplitude of each harmonic, the mean first, mmHg and ml/s; of a cycle averaged from beats.
    wedge_pressure : float
        Mean pressure behind the vascular beds, mmHg: the wedge pressure, or that of the left atrium; 0 in the paper.
    wedge_pulsation : float array, shape (sample,), optional
        What that pressure does about its mean over the cycle, in step with the pressure at the inlet, mmHg; a mean that
        it has is taken off. By default it is steady.
    site : str
        The artery, see `SiteName`.
    flow_delay_sd : float
        SD of the place of a flow that was gated apart from the pressure, s.

    Raises
    ------
    InputError
        Too few samples, a value that is not finite, a period that is not positive, a negative error, a wedge pressure
        that the mean pressure does not exceed.

    Examples
    --------
    >>> import vasowave as vw
    >>> import numpy as np
    >>> t = np.arange(64) / 64
    >>> flow = 0.4 * np.exp(-0.5 * ((t - 0.3) / 0.1) ** 2)
    >>> vw.Recording(10 + 20 * flow, flow, period=0.11).indices()["HR"]  # beats/min
    545.45...
    """

    pressure: np.ndarray
    flow: np.ndarray
    period: float
    source: str = "made in memory"
    notes: tuple[Finding, ...] = ()
    pressure_error: np.ndarray | None = None
    flow_error: np.ndarray | None = None
    wedge_pressure: float = 0.0
    wedge_pulsation: np.ndarray | None = None
    site: str = PULMONARY
    flow_delay_sd: float = 0.0

    def __post_init__(self) -> None:
        """Check the values and freeze the arrays."""
        object.__setattr__(self, "pressure", cycle_samples(self.pressure, "pressure"))
        object.__setattr__(self, "flow", cycle_samples(self.flow, "flow"))
        object.__setattr__(self, "period", _period(self.period))
        for name in ("pressure_error", "flow_error"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, _errors(getattr(self, name), name))
        if self.wedge_pulsation is not None:
            behind = cycle_samples(self.wedge_pulsation, "wedge_pulsation")
            object.__setattr__(self, "wedge_pulsation", _frozen(behind - behind.mean()))
        if self.wedge_pressure and not self.wedge_pressure < self.mean_pressure:
            raise InputError(
                f"{self.source}: a wedge pressure of {self.wedge_pressure:g} mmHg is not below the mean pressure, "
                f"{self.mean_pressure:.4g} mmHg; nothing would drive the flow"
            )

    def __repr__(self) -> str:
        return (
            f"Recording(mPAP {self.mean_pressure:.1f} mmHg, CO {self.cardiac_output:.3f} ml/s, "
            f"HR {self.heart_rate:.0f}/min, {len(self.pressure)} pressure and {len(self.flow)} flow samples, "
            f"{self.source})"
        )

    def _repr_html_(self) -> str:
        facts = {
            "mean pressure": f"{self.mean_pressure:.1f} mmHg ({self.pressure.min():.1f} to {self.pressure.max():.1f})",
            "cardiac output": f"{self.cardiac_output:.3f} ml/s",
            "heart rate": f"{self.heart_rate:.0f}/min",
            "samples": f"{len(self.pressure)} of pressure, {len(self.flow)} of flow",
            "source": self.source,
        }
        return card("Recording, one averaged cycle", facts, texts(self.notes))

    @property
    def inflow(self) -> Inflow:
        """The flow as boundary condition of a simulation."""
        return Inflow(self.flow, self.period)

    @property
    def time(self) -> np.ndarray:
        """Times of the pressure samples, s, shape (pressure sample,)."""
        return np.arange(len(self.pressure)) * (self.period / len(self.pressure))

    @property
    def heart_rate(self) -> float:
        """Heart rate HR, beats/min (Table 1)."""
        return 60.0 / self.period

    @property
    def cardiac_output(self) -> float:
        """Cardiac output CO, the mean flow, ml/s (Table 1)."""
        return float(self.flow.mean())

    @property
    def mean_pressure(self) -> float:
        """Mean pressure mPAP, mmHg (Table 1)."""
        return float(self.pressure.mean())

    @property
    def systolic_pressure(self) -> float:
        """Systolic pressure sPAP, the largest, mmHg (Table 1)."""
        return float(self.pressure.max())

    @property
    def diastolic_pressure(self) -> float:
        """Diastolic pressure dPAP, the smallest, mmHg (Table 1)."""
        return float(self.pressure.min())

    @property
    def pulse_pressure(self) -> float:
        """Pulse pressure pPAP = sPAP - dPAP, mmHg (Table 1)."""
        return self.systolic_pressure - self.diastolic_pressure

    @property
    def vascular_resistance(self) -> float:
        """Vascular resistance PVR = (mPAP - wedge pressure)/CO, mmHg s/ml; Table 1 has it for a wedge of 0."""
        return (self.mean_pressure - self.wedge_pressure) / self.cardiac_output

    @property
    def input_resistance(self) -> float:
        """Input resistance Z_0, mean pressure over mean flow, mmHg s/ml, clinically the TPR; a wedge does not enter."""
        return self.mean_pressure / self.cardiac_output

    def indices(self) -> dict[str, float]:
        """Return the quantities of the paper's Table 1 under its names: HR, CO, mPAP, sPAP, dPAP, pPAP, PVR."""
        return {
            "HR": self.heart_rate,
            "CO": self.cardiac_output,
            "mPAP": self.mean_pressure,
            "sPAP": self.systolic_pressure,
            "dPAP": self.diastolic_pressure,
            "pPAP": self.pulse_pressure,
            "PVR": self.vascular_resistance,
        }

    @Accessor
    def plot(self, axes: "Sequence[Axes] | None" = None) -> np.ndarray:
        """Draw pressure and flow into two matplotlib axes, or a new figure; returns the axes."""
        raise NotImplementedError

    @Accessor
    def to_dataset(self) -> "xr.Dataset":
        """Return pressure and flow as labelled data with units, dims ``time`` and ``flow_time`` (s)."""
        raise NotImplementedError

    def to_dataframe(self) -> "pd.DataFrame":
        """Return ``pressure [mmHg]`` and ``flow [ml/s]`` by ``time [s]``, both with the samples of the longer one."""
        import pandas as pd

        count = max(len(self.pressure), len(self.flow))
        time = pd.Index(np.arange(count) * (self.period / count), name="time [s]")
        pressure, flow = resample(self.pressure, count), resample(self.flow, count)
        return pd.DataFrame({"pressure [mmHg]": pressure, "flow [ml/s]": flow}, time)

    def resampled(self, count: int) -> "Recording":
        """Return the recording with `count` samples of pressure and of flow, by Fourier interpolation."""
        notes = (*self.notes, RESAMPLED(count=count))
        pressure, flow = resample(self.pressure, count), resample(self.flow, count)
        return replace(self, pressure=pressure, flow=flow, notes=notes)


def resample(samples: np.ndarray, count: int) -> np.ndarray:
    """Return `count` evenly spaced samples of a periodic signal, by Fourier interpolation along the first axis.

    Upwards it is exact for a band-limited signal; downwards it drops the harmonics the new rate cannot carry.
    """
    size = len(samples)
    if count == size:
        return np.array(samples)
    spectrum = np.fft.rfft(samples, axis=0)
    common_size = min(size, count)
    resized = np.zeros((count // 2 + 1, *samples.shape[1:]), dtype=complex)
    resized[: common_size // 2 + 1] = spectrum[: common_size // 2 + 1]
    if common_size % 2 == 0:
        # The harmonic at the coarser rate's limit is one real cosine: it is split or folded, never doubled.
        edge = resized[common_size // 2].real
        resized[common_size // 2] = edge * (0.5 if count > size else 2.0)
    return np.fft.irfft(resized, count, axis=0) * (count / size)


def samples_needed(signal: np.ndarray) -> int:
    """Return how many samples carry all harmonics of a cycle: an average that kept 20 of them needs 41.

    More samples add nothing measured: at the harmonics that were cut off a residual is the simulation's alone.
    """
    modulus = np.abs(np.fft.rfft(signal))
    return min(len(signal), 2 * int(np.flatnonzero(modulus > _CUT_OFF_SHARE * modulus.max())[-1]) + 1)


def _frozen(array: np.ndarray) -> np.ndarray:
    array.setflags(write=False)
    return array


def cycle_samples(values: object, name: str) -> np.ndarray:
    """Return the samples of one cycle, checked and frozen; `InputError`, naming `name`, where they are too few."""
    array = np.array(values, dtype=np.float64)
    if array.ndim != 1 or len(array) < MIN_SAMPLES:
        raise InputError(f"{name}: {array.size} samples in one cycle; at least {MIN_SAMPLES} are needed")
    bad = np.flatnonzero(~np.isfinite(array))
    if len(bad):
        raise InputError(f"{name}: sample {bad[0] + 1} is {array[bad[0]]}; fill the gap first")
    return _frozen(array)


def _errors(values: object, name: str) -> np.ndarray:
    array = np.array(values, dtype=np.float64)
    if array.ndim != 1 or not len(array) or not np.all(np.isfinite(array) & (array >= 0)):
        raise InputError(f"{name}: give one standard error for each harmonic, the mean's first, none negative")
    return _frozen(array)


def _period(value: object) -> float:
    period = float(value)  # type: ignore[arg-type]
    if not (np.isfinite(period) and period > 0):
        raise InputError(f"period {period:g} s is not a positive number")
    return period
