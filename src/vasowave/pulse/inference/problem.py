"""One animal as a problem of inference: from a point to harmonics at its inlet and further sites, and the data."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from importlib.metadata import version
from typing import Any

import numpy as np

from vasowave.base.errors import NumericalError, VasowaveError
from vasowave.base.runtime.kept import digest_of
from vasowave.pulse.analysis.operating import operating_point
from vasowave.pulse.analysis.waves import wave_intensity
from vasowave.pulse.calibration.compared import Compared
from vasowave.pulse.calibration.sites import Sites
from vasowave.pulse.cycle.cycle import Recording, resample
from vasowave.pulse.cycle.response import second_order
from vasowave.pulse.inference.discrepancy import Discrepancy
from vasowave.pulse.inference.unknowns import Unknowns
from vasowave.pulse.model.linear import LinearSolution, linear_solution
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.numerics import Numerics
from vasowave.pulse.model.outlets import OF_DROP
from vasowave.pulse.noise.spectrum import fourier, harmonics
from vasowave.pulse.quantities import OF_PARAMETERS, derived
from vasowave.pulse.solver.places import Waves, waves_at, with_areas
from vasowave.pulse.solver.result import Run
from vasowave.pulse.solver.simulation import simulate_runs

_SOLVER_ERROR = 0.02  # mmHg, error of the simulated pressure by its grid of 0.1 cm, white; see docs/decisions/pulse.md
_MIN_LOG_ARGUMENT = 1e-12  # of a strain or compliance whose logarithm is taken
_PERIODIC_TOLERANCE = 0.1 * _SOLVER_ERROR  # mmHg, change from cycle to cycle that is left in simulations
_STEP_SAMPLES = 64  # the solver chooses its step in multiples of this
_WAVE_SAMPLES = 256  # samples of a cycle whose waves are separated


@dataclass(frozen=True, eq=False)
class Problem:
    """What the recording says, and what a point says it should be; both as orthonormal Fourier coefficients, mmHg.

    Attributes
    ----------
    unknowns : Unknowns
    compared : Compared
        The harmonics of the pressure that a fit compares, with their errors.
    numerics : Numerics
    workers : int
        Threads.
    """

    unknowns: Unknowns
    compared: Compared
    numerics: Numerics
    workers: int

    @property
    def recording(self) -> Recording:
        """The cycle."""
        return self.compared.recording

    @property
    def samples(self) -> int:
        """Coefficients of what is compared at the inlet: the mean and two for each harmonic, an odd number."""
        return 2 * ((self.compared.samples - 1) // 2) + 1

    @property
    def sites(self) -> Sites | None:
        """What was observed elsewhere; its coefficients follow those of the inlet."""
        return self.compared.sites

    @cached_property
    def count(self) -> int:
        """Coefficients of the inlet and of all further sites."""
        return self.samples + (0 if self.sites is None else len(self.sites.harmonic))

    @cached_property
    def measured(self) -> np.ndarray:
        """Coefficients of what was measured at the inlet and observed elsewhere, shape (coefficient,)."""
        at_inlet = fourier(resample(self.compared.signal_of(self.recording), self.samples))
        return at_inlet if self.sites is None else np.append(at_inlet, self.sites.measured)

    @cached_property
    def measurement_error(self) -> np.ndarray:
        """Variance of each coefficient of the inlet by scatter of the beats (or rounding), grid, and zero, mmHg²."""
        k = harmonics(self.samples)
        beats = self.compared.error_power()[k] * np.where(k == 0, 1.0, 0.5) * self.samples
        return beats + _SOLVER_ERROR**2 + np.where(k == 0, self.zero_variance, 0.0)

    @property
    def zero_variance(self) -> float:
        """Variance of the mean's coefficient by the zero of the pressure, mmHg²; 0 where it is one of the unknowns."""
        return 0.0 if self.unknowns.zero_enters else self.samples * self.unknowns.priors.sd("zero") ** 2

    @property
    def zero(self) -> np.ndarray:
        """What one SD of the zero of the pressure changes in the coefficients, mmHg, shape (coefficient,)."""
        return np.sqrt(self.zero_variance) * np.eye(self.count)[0]

    @cached_property
    def _errors(self) -> np.ndarray:
        """Covariance of the errors of all coefficients, mmHg²."""
        errors = np.diag(np.append(self.measurement_error, np.full(self.count - self.samples, _SOLVER_ERROR**2)))
        if self.sites is not None:
            errors[self.samples :, self.samples :] += self.sites.covariance
        return errors

    @cached_property
    def _middle(self) -> tuple[Model, LinearSolution]:
        """The model at the medians, and what it does in the frequency domain; not finite where it has no mean state."""
        model = self.unknowns.model(np.zeros(len(self.unknowns.all)))
        with np.errstate(all="ignore"):
            return model, linear_solution(model, self.recording.inflow, self.samples // 2)

    @cached_property
    def _diastole(self) -> np.ndarray:
        """Diastolic pressure of the vessels, mmHg, shape (vessel,): measured, and by how much they differ."""
        model, solved = self._middle
        with np.errstate(all="ignore"):
            lowest = solved.over_cycle(solved.pressure, _WAVE_SAMPLES).min(axis=0)
        difference = lowest - lowest[model.network.root]
        return self.recording.diastolic_pressure + np.where(np.isfinite(difference), difference, 0.0)

    def quantities(
        self, points: np.ndarray, outputs: np.ndarray, zeros: np.ndarray, errors: np.ndarray | None = None
    ) -> dict[str, np.ndarray]:
        """Return what follows from points, their simulated coefficients, and zeros that are wrong by so many SD.

        Of the indices those that an error moves; I_R from the harmonics that are compared. All of shape (point,).
        Where waves are taken apart the root is as wide as its own error says: `errors` are those of `vessels`, in SD.
        """
        unknowns = self.unknowns
        sd = unknowns.priors.sd("zero")
        zero = unknowns.values(points)["zero"] if unknowns.zero_enters else sd * zeros
        gain = unknowns.values(points)["pressure_gain"]
        wider = self._wider_root(errors, len(points))
        means = (self.recording.mean_pressure - np.broadcast_to(zero, len(points))) * gain
        rows, flows, places = [], [], []
        for point, mean in zip(points, means.tolist(), strict=True):
            model, recording = unknowns.posed(point)
            model_values = derived(model, mean, self._diastole)
            rows.append([model_values[name] for name in (*OF_PARAMETERS, "tau") if name in model_values])
            flows.append(recording.flow)
            places.append(operating_point(model, mean))
        names = [name for name in (*OF_PARAMETERS, "tau") if name in model_values]
        values_by_name = dict(zip(names, np.array(rows).T, strict=True))
        values_by_name["area_compliance"] = wider * values_by_name["area_compliance"]
        areas, speeds = np.array(places).T
        values_by_name["I_R"] = self._reflections(
            np.array(flows), self.through_amplifier(points, outputs, back=True),
            np.column_stack([areas * wider, speeds]), model.blood.inertia,
        )  # fmt: skip
        moved = {
            "mPAP": sd > 0 or "pressure_gain" in unknowns.all,
            "CO": not {"flow_gain", "flow_zero"}.isdisjoint(unknowns.all),
        }
        moved["PVR"] = any(moved.values()) or "wedge" in unknowns.all
        CO = np.mean(flows, axis=1)
        indices = {"mPAP": means, "CO": CO, "PVR": (means - unknowns.values(points)["wedge"]) / CO}
        return values_by_name | {name: value for name, value in indices.items() if moved[name]}

    def _wider_root(self, errors: np.ndarray | None, count: int) -> np.ndarray:
        """Return how many times as large the root's area is by the error of its own radius, shape (point,)."""
        radii, root = self.unknowns.own_errors[0], self.unknowns.network.root
        if errors is None or not radii[root]:
            return np.ones(count)
        return np.asarray(np.exp(2 * radii[root] * errors[:, np.count_nonzero(radii[:root])]))

    def _reflections(self, flows: np.ndarray, outputs: np.ndarray, places: np.ndarray, inertia: float) -> np.ndarray:
        """Return I_R of the waves of flows (point, time) and coefficients at places; NaN where there are none."""
        reflections = np.full(len(flows), np.nan)
        good = np.isfinite(outputs[:, : self.samples]).all(axis=1) & np.isfinite(places).all(axis=1)
        if good.any():
            areas, speeds = places[good].T[:, :, np.newaxis]
            pressure, flow = self.inlet_waves(flows[good], outputs[good])
            waves = wave_intensity(pressure, flow, self.recording.period, areas, speeds, inertia)
            reflections[good] = waves.reflection_coefficient
        return reflections

    def inlet_waves(self, flows: np.ndarray, outputs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return pressure and flow at the inlet, shape (point, time), of coefficients and flows without errors.

        In the harmonics that are compared.
        """
        pressure = resample(self.in_time(outputs).T, _WAVE_SAMPLES).T
        if self.compared.what == "flow":  # without the errors of the probe, which `outputs` have and `flows` do not
            wrong = flows - self.recording.flow
            flow = pressure / self.compared.scale + resample(resample(wrong.T, self.samples), _WAVE_SAMPLES).T
            pressure = resample(resample(self.recording.pressure, self.samples), _WAVE_SAMPLES)
            return np.tile(pressure, (len(flow), 1)), flow
        return pressure, resample(resample(flows.T, self.samples), _WAVE_SAMPLES).T

    def discrepancy(self, vessels: np.ndarray | None = None) -> Discrepancy:
        """Return the likelihood of residuals, with what single vessels change (as from `vessels`) or without."""
        change = np.zeros((self.count, 1)) if vessels is None else vessels
        of_mean = OF_DROP * self.mean_drop * self.compared.per_pressure
        share, spread = self.unknowns.priors.discrepancy
        amplitude = share * self.recording.pulse_pressure, spread
        site_harmonics = None if self.sites is None else self.sites.harmonic
        noise = Discrepancy(
            self.samples, amplitude, self._errors, change, of_mean=of_mean, site_harmonics=site_harmonics
        )
        passed = self.compared.passed_on
        if passed is None:
            return noise
        k, variance, power = harmonics(self.samples), np.zeros(self.count), np.ones(self.count)
        variance[: self.samples] = np.where(k == 0, 1.0, 0.5) * self.samples * passed.of_harmonic[k] ** 2
        power[: self.samples] = np.where(k == 0, 2.0, 0.5) * self.samples * passed.modulus[k] ** 2
        return noise.beside_flow(variance, np.maximum(power, np.finfo(float).tiny), self.measured)

    @cached_property
    def mean_drop(self) -> float:
        """What the mean pressure falls along the vessels of the image with nominal walls, mmHg; infinite if unknown."""
        model, solved = self._middle
        beds = self.recording.cardiac_output * model.outlets.total_resistance() + self.unknowns.space.outlet_pressure
        fall = float(solved.pressure[0, model.network.root].real) - beds
        return max(fall, 0.0) if np.isfinite(fall) else np.inf

    def vessels(self, point: np.ndarray) -> np.ndarray:
        """Return what one SD of each vessel's own radius, length and taper changes, shape (coefficient, error), mmHg.

        The last two are those of a taper that all vessels have alike and nobody measured, where there may be one.

        Raises
        ------
        NumericalError
            A model with one vessel wider, longer or narrowing more by one SD cannot be simulated.
        """
        posed = [self._posed(point)]
        for kind, errors in zip(("radii", "lengths", "falls"), self.unknowns.own_errors, strict=True):
            posed += [self._posed(point, **{kind: error}) for error in np.diag(errors) if error.any()]
        outputs = self.through_amplifier([point] * len(posed), self._simulated(posed))
        if not np.isfinite(outputs).all():
            raise NumericalError(
                "a model with one vessel wider or longer by its assumed error cannot be simulated; give smaller errors "
                "of radius and length, or other numerics"
            )
        return np.column_stack([(outputs[1:] - outputs[0]).T, self._untold_taper(point, outputs[0])])

    def _untold_taper(self, point: np.ndarray, straight: np.ndarray) -> np.ndarray:
        """Return what one SD of a common taper changes, and what any taper does whatever its sign, (coefficient, 2).

        Junctions of vessels that taper share another pressure, which nobody measured either: in truth its step is there
        or not. Where the flow chokes, both are those of a quarter of the SD, drawn on by a straight line.
        """
        network = self.unknowns.network
        falls = self.unknowns.priors.sd("taper", network) * np.ones(len(network))
        if not falls.any():
            return np.zeros((self.count, 1))
        for share in (1.0, 0.25):
            posed = [self._posed(point, falls=side * share * falls) for side in (1, -1)]
            up, down = self.through_amplifier([point] * 2, self._simulated(posed)) - straight
            if np.isfinite([up, down]).all():
                return np.column_stack([(up - down) / (2 * share), (up + down) / 2])
        raise NumericalError("a model whose vessels taper cannot be simulated; say a smaller taper_sd")

    def seen(self, points: np.ndarray) -> np.ndarray:
        """Return coordinates of points, shape (point, unknown), in which the pressure bends less.

        In place of the wall law's first two parameters: the logarithms of compliance and strain at mean pressure, in a
        vessel of usual radius, because k moves those of the root least where the whole tree's are moved most.
        """
        space, law, names = self.unknowns.space, self.unknowns.space.law, list(self.unknowns.all)
        values, coordinates = self.unknowns.values(points), np.array(points)
        stiffer: Any = self._usual_radius ** -values["k"]
        parameters = [values[name] * space.parameters[name].scale(stiffer) for name in space.names_of("wall")]
        mean = self.recording.mean_pressure
        shown = (law.slope_at(mean, *parameters), law.ratio_at(mean, *parameters) - 1.0)
        for name, quantity in zip(space.names_of("wall"), shown, strict=False):
            if name in names:
                coordinates[:, names.index(name)] = np.log(np.maximum(quantity, _MIN_LOG_ARGUMENT))
        return coordinates

    @property
    def _usual_radius(self) -> float:
        """Geometric mean of the radii along all vessels, in radii of the root."""
        network = self.unknowns.network
        logarithms = np.log(network.radius / network.radius[network.root])
        return float(np.exp(np.average(logarithms, weights=network.length)))

    def in_time(self, coefficients: np.ndarray) -> np.ndarray:
        """Return what coefficients (..., coefficient) of the inlet stand for, shape (..., sample), mmHg."""
        n, K = self.samples, self.samples // 2
        spectrum = np.array(coefficients[..., : K + 1], dtype=complex)
        spectrum[..., 1:] = (spectrum[..., 1:] - 1j * coefficients[..., K + 1 : n]) / np.sqrt(2)
        return np.fft.irfft(spectrum * np.sqrt(n), n, axis=-1)

    def simulate(self, points: Sequence[np.ndarray] | np.ndarray) -> np.ndarray:
        """Return the coefficients at points, shape (point, coefficient); NaN where a point cannot be simulated."""
        return self.through_amplifier(points, self._simulated([self._posed(point) for point in points]))

    def through_amplifier(
        self, points: Sequence[np.ndarray] | np.ndarray, outputs: np.ndarray, back: bool = False
    ) -> np.ndarray:
        """Return coefficients (point, coefficient) as the pressure's amplifier gives them, or back."""
        response = {"pressure_lag", "pressure_inertia"}
        if (response | {"pressure_gain"}).isdisjoint(self.unknowns.all) or self.compared.what == "flow":
            return outputs
        values, K, amplified = self.unknowns.values(np.asarray(points)), self.samples // 2, outputs.copy()
        gain = np.broadcast_to(values["pressure_gain"], len(outputs))[:, np.newaxis]
        amplified[:, : self.samples] *= gain if back else 1 / gain
        if response.isdisjoint(self.unknowns.all):
            return amplified
        outputs, frequency = amplified.copy(), np.arange(1, K + 1) / self.recording.period
        passing = second_order(values["pressure_lag"][..., None], values["pressure_inertia"][..., None], frequency)
        passed = (outputs[:, 1 : K + 1] - 1j * outputs[:, K + 1 : self.samples]) * passing ** (-1 if back else 1)
        amplified[:, 1 : K + 1], amplified[:, K + 1 : self.samples] = passed.real, -passed.imag
        return amplified

    def linear(self, points: np.ndarray) -> np.ndarray:
        """Return the coefficients at points as the network in the frequency domain has them; NaN where it has none."""
        outputs = np.full((len(points), self.count), np.nan)
        for i, posed in enumerate(map(self._posed, points)):
            if posed is not None:
                model, recorded = posed
                with np.errstate(all="ignore"):  # what is infinite is no start
                    solved = linear_solution(model, self.compared.driven_by(recorded), self.samples // 2)
                    at_inlet = solved.over_cycle(self.compared.of_linear(solved, model.network.root), self.samples)
                    outputs[i] = self._whole(at_inlet, recorded, self._linear_waves(model, solved))
        return self.through_amplifier(points, outputs)

    def _whole(self, at_inlet: np.ndarray, recorded: Recording, waves: Waves | None) -> np.ndarray:
        """Return all coefficients: of what is compared at the inlet, mmHg, and of the waves at the sites.

        `recorded` is what would have been recorded without errors; a flow that is compared has those of its probe.
        """
        if self.compared.what == "flow" and recorded is not self.recording:
            wrong = self.compared.signal_of(self.recording) - self.compared.signal_of(recorded)
            at_inlet = at_inlet + resample(wrong, self.samples)
        coefficients = fourier(at_inlet)
        return (
            coefficients
            if self.sites is None or waves is None
            else np.append(coefficients, self.sites.coefficients(waves))
        )

    def _linear_waves(self, model: Model, solved: LinearSolution) -> Waves | None:
        """Return the waves of the network in the frequency domain at the sites, shape (step, site)."""
        if self.sites is None:
            return None
        places = self.sites.places
        spectra = solved.at(places.vessel, places.share * model.network.length[places.vessel])
        pressure, flow = (solved.over_cycle(spectrum, _WAVE_SAMPLES) for spectrum in spectra)
        return with_areas(model, places, pressure, flow)

    def _simulated(self, posed: Sequence[tuple[Model, Recording] | None]) -> np.ndarray:
        """Return the coefficients of models with what would have been recorded of them without errors.

        Every simulation starts from its linear solution, which takes fewer cycles than from a neighbor as far away as
        draws are from each other; and what a point gives does not depend on the points before it.
        """
        pairs = [pair for pair in posed if pair is not None]
        outputs = np.full((len(posed), self.count), np.nan)
        models, recorded = zip(*pairs, strict=True) if pairs else ((), ())
        driven = [self.compared.driven_by(recording) for recording in recorded]
        runs = simulate_runs(models, driven, self._numerics, workers=self.workers)
        for i, pair in enumerate(posed):
            run = next(runs) if pair is not None else None
            if pair is not None and isinstance(run, Run):
                waves = None
                if self.sites is not None:
                    waves = waves_at(run, self.compared.driven_by(pair[1]), self.sites.places)
                outputs[i] = self._whole(self.compared.at_inlet(run, self.samples), pair[1], waves)
        return outputs

    @property
    def _numerics(self) -> Numerics:
        """The step is free in multiples of few samples, unless a number of steps or cycles was asked for.

        Cycles repeat far within the error of the grid, which is part of the likelihood.
        """
        numerics = replace(self.numerics, every_cell=False, tolerance=max(self.numerics.tolerance, _PERIODIC_TOLERANCE))
        fixed = numerics.cycles_from_rest is not None or numerics.steps_per_cycle is not None
        return numerics if fixed else replace(numerics, samples=_STEP_SAMPLES)

    @cached_property
    def key(self) -> str:
        """SHA-256 of everything that enters a simulation and its harmonics."""
        unknowns, network = self.unknowns, self.unknowns.network
        space, nominal = unknowns.space, unknowns.nominal
        return digest_of(
            *(space.law, type(space.outlets), space.free_names, space.blood, space.nominal),
            *(unknowns.all, unknowns.fall, nominal.total_resistance, nominal.time_constant),
            *(network.name, network.start, network.end, network.length, network.radius, network.pressure),
            *(self.recording.flow, self.recording.period, self._numerics, self.samples, version("vasowave")),
            *((self.recording.pressure, self.compared.scale) if self.compared.what == "flow" else ()),
            *(() if space.outlet_pulsation is None else (space.outlet_pulsation,)),
            *self._of_sites,
        )

    @property
    def _of_sites(self) -> tuple[object, ...]:
        sites = self.sites
        if sites is None:
            return ()
        kinds = [(observation.quantity, *observation.numbers) for observation in sites.observations]
        return sites.measured, sites.harmonic, sites.places.vessel, sites.places.share, sites.scales, kinds

    def _posed(self, point: np.ndarray, **errors: np.ndarray) -> tuple[Model, Recording] | None:
        """Return what a point poses, or nothing where a number of it overflows or its law raises an error."""
        try:
            return self.unknowns.posed(point, **errors)
        except (VasowaveError, ArithmeticError, ValueError):
            return None
