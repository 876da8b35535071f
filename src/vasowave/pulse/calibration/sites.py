"""Further sites of a fit: what was observed beside the pressure at the inlet, in numbers whose misfits count alike.

A waveform counts by its Fourier coefficients, a mean as that of a waveform, a largest or smallest value as one sample.
They are scaled so that a model that errs by the same share of the pulse errs by the same amount everywhere: all are
then in mmHg of the pressure at the inlet.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from vasowave.base.errors import InputError, did_you_mean
from vasowave.pulse.cycle.cycle import resample
from vasowave.pulse.cycle.observation import MAX_PERIOD_DIFFERENCE, Observation
from vasowave.pulse.network.network import Network
from vasowave.pulse.noise.spectrum import fourier, harmonics
from vasowave.pulse.solver.places import Places, Waves

POINT_HARMONIC = -1
"""Stands for the harmonic of a single value of the cycle, to which all harmonics add."""


@dataclass(frozen=True, eq=False)
class Sites:
    """What was observed beside the pressure at the inlet.

    Attributes
    ----------
    observations : tuple of Observation
    places : Places
    samples : int
        N, of the pressure at the inlet: no more harmonics are compared elsewhere.
    pulse : float
        Pulse pressure at the inlet, mmHg.
    deviation : float
        SD of the discrepancy of the model at the inlet, mmHg, and so that of every scaled value, as they are weighted.
    """

    observations: tuple[Observation, ...]
    places: Places
    samples: int
    pulse: float
    deviation: float

    @cached_property
    def scales(self) -> np.ndarray:
        """What the values of each site are multiplied by, mmHg per unit, shape (site,)."""
        return np.array([self.pulse / _pulse(observation, self.pulse) for observation in self.observations])

    @cached_property
    def rows(self) -> tuple[slice, ...]:
        """Which coefficients are those of each site."""
        ends = np.cumsum([0, *(len(orders) for orders in self._harmonics)]).tolist()
        return tuple(slice(first, last) for first, last in pairwise(ends))

    @cached_property
    def harmonic(self) -> np.ndarray:
        """Harmonic of each coefficient, or `POINT_HARMONIC`, shape (coefficient,)."""
        return np.concatenate(self._harmonics)

    @cached_property
    def _harmonics(self) -> tuple[np.ndarray, ...]:
        k = harmonics(self.samples)
        return tuple(
            k[k <= (min(len(observation.waveform), self.samples) - 1) // 2] if observation.waveform is not None
            else np.array([0 if name == "mean" else POINT_HARMONIC for name in observation.numbers])
            for observation in self.observations
        )  # fmt: skip

    @cached_property
    def measured(self) -> np.ndarray:
        """Scaled coefficients of what was observed, mmHg, shape (coefficient,)."""
        coefficients = [
            self._of_waveform(site, resample(observation.waveform, self.samples)) if observation.waveform is not None
            else self._weights(site) * np.array(list(observation.numbers.values()))
            for site, observation in enumerate(self.observations)
        ]  # fmt: skip
        return np.concatenate(coefficients)

    @cached_property
    def covariance(self) -> np.ndarray:
        """Covariance of the errors, zeros and gains included, mmHg², shape (coefficient, coefficient)."""
        covariance = np.zeros((len(self.harmonic),) * 2)
        for site, (observation, rows) in enumerate(zip(self.observations, self.rows, strict=True)):
            scale, weights = self.scales[site], self._weights(site)
            size = scale * np.ones(len(weights)) if observation.waveform is not None else weights
            covariance[rows, rows] = np.diag((size * observation.error) ** 2)
            if observation.quantity == "pressure":
                covariance[rows, rows] += observation.zero_sd**2 * np.outer(weights, weights)
            covariance[rows, rows] += observation.gain**2 * np.outer(self.measured[rows], self.measured[rows])
        return covariance

    @cached_property
    def balance(self) -> np.ndarray:
        """What residuals are multiplied by before their squares are summed, shape (coefficient, coefficient).

        It is the discrepancy over that and the errors together: what is known badly counts little.
        """
        values, axes = np.linalg.eigh(self.covariance)
        weight = self.deviation / np.sqrt(self.deviation**2 + np.maximum(values, 0.0))
        return np.asarray((axes * weight) @ axes.T)

    def coefficients(self, waves: Waves) -> np.ndarray:
        """Return what waves at the places, shape (step, site), say; scaled, mmHg, shape (coefficient,)."""
        blocks = []
        for site, observation in enumerate(self.observations):
            wave = waves.of(observation.quantity)[:, site]
            if observation.waveform is not None:
                blocks.append(self._of_waveform(site, resample(wave, self.samples)))
            else:
                values = {"mean": wave.mean(), "systolic": wave.max(), "diastolic": wave.min()}
                blocks.append(self._weights(site) * [values[name] for name in observation.numbers])
        return np.concatenate(blocks)

    def jacobian(self, waves: Waves, changes: Waves) -> np.ndarray:
        """Return the derivatives of `coefficients`, shape (coefficient, direction), from those of the waves."""
        blocks = []
        for site, observation in enumerate(self.observations):
            wave, change = (
                waves.of(observation.quantity)[:, site],
                waves.changed(observation.quantity, changes)[:, :, site],
            )
            if observation.waveform is not None:
                blocks.append(self._of_waveform(site, resample(change.T, self.samples)))
            else:
                samples = {"systolic": int(np.argmax(wave)), "diastolic": int(np.argmin(wave))}
                rows = [
                    change.mean(axis=1) if name == "mean" else change[:, samples[name]] for name in observation.numbers
                ]
                blocks.append(self._weights(site)[:, np.newaxis] * np.array(rows))
        return np.concatenate(blocks)

    def without(self, site: int) -> "Sites | None":
        """Return all sites but one; None if there is no other."""
        indices = [i for i in range(len(self.observations)) if i != site]
        if not indices:
            return None
        observations = tuple(self.observations[i] for i in indices)
        places = Places(self.places.vessel[indices], self.places.share[indices])
        return replace(self, observations=observations, places=places)

    def _of_waveform(self, site: int, values: np.ndarray) -> np.ndarray:
        highest = int(self._harmonics[site].max())
        return np.asarray(self.scales[site] * fourier(values)[harmonics(self.samples) <= highest])

    def _weights(self, site: int) -> np.ndarray:
        """Return what a change of the whole site by one unit is in each of its coefficients."""
        k = self._harmonics[site]
        if self.observations[site].waveform is not None:
            return self.scales[site] * np.where(k == 0, np.sqrt(self.samples), 0.0)
        return self.scales[site] * np.where(k == 0, np.sqrt(self.samples), 1.0)


def _pulse(observation: Observation, of_inlet: float) -> float:
    """Return the range of a site's values; of a mean alone a guess: the inlet's of a pressure, else the mean itself."""
    if observation.pulse:
        return observation.pulse
    return of_inlet if observation.quantity == "pressure" else max(abs(value) for value in observation.numbers.values())


def places_of(observations: Sequence[Observation], network: Network, period: float) -> Places:
    """Return where sites lie in a network; `period` (s) is that of the recording.

    Raises
    ------
    InputError
        A vessel that the network does not have, a place beyond its end, another period, a site that is none.
    """
    rows, shares = [], []
    for site in observations:
        if not isinstance(site, Observation):
            raise InputError(f"{site!r} is no site; give Observation(quantity, vessel, error, waveform=…)")
        if site.vessel not in network.name:
            hint = did_you_mean(site.vessel, network.name)
            raise InputError(f"{site.title}: the network has no vessel '{site.vessel}'{hint}")
        row = network.row(site.vessel)
        share = float(site.place if site.cm is None else site.cm / network.length[row])  # type: ignore[arg-type]
        if share > 1:
            raise InputError(f"{site.title}: the vessel is {network.length[row]:.4g} cm long; the place lies beyond it")
        if site.period is not None and abs(site.period - period) > MAX_PERIOD_DIFFERENCE * period:
            raise InputError(
                f"{site.title}: its cycle lasts {site.period:.5g} s and that of the recording {period:.5g} s; give one "
                "averaged at the same heart rate, in step with the recording"
            )
        rows.append(row)
        shares.append(share)
    return Places(np.array(rows), np.array(shares))
