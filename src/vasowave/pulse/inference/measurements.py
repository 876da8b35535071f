"""What a further measurement would add, before anybody makes it: how much narrower each interval would be.

The posterior is taken for normal about its mode (Laplace), with the likelihood and the priors of `posterior`. How the
harmonics at inlet and further sites change with the unknowns, and with errors of single vessels, comes from simulations
about the mode; what a measurement adds follows from them by linear algebra (Fisher's information).
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from vasowave.base.descriptions import NORMAL
from vasowave.base.errors import InputError, NumericalError, did_you_mean
from vasowave.base.settings import given_values
from vasowave.pulse.calibration.compared import compared_part, sites_of
from vasowave.pulse.cycle.averaged import EnsembleAverage, one_cycle
from vasowave.pulse.cycle.cycle import Recording
from vasowave.pulse.cycle.observation import ZERO_SD, Observation
from vasowave.pulse.inference.mode import climb
from vasowave.pulse.inference.problem import Problem
from vasowave.pulse.inference.sampling import Sampling, problem_of
from vasowave.pulse.network.network import Network, a_network
from vasowave.pulse.noise.spectrum import harmonics
from vasowave.pulse.quantities import OF_PARAMETERS, QUANTITIES
from vasowave.pulse.solver.simulation import simulate


@dataclass(frozen=True)
class MeasurementRules:
    """What is assumed of measurements that nobody has made.

    Attributes
    ----------
    wedge_sd : float
        SD of the pressure behind the beds, mmHg, where neither a wedge pressure nor a prior of it is given.
    measured_wedge_sd : float
        The same after a wedge pressure was measured: of a catheter's zero.
    image : float
        What is left of the SD of radii in a better image.
    min_error : float
        SD of each value of a pressure at a second site, mmHg, at least.
    max_harmonics : int
        That are compared, where the signal tells how many: more of them say no more, and cost much.
    step : float
        Of derivatives by the unknowns, in SD of the prior.
    max_start : float
        SD of the prior at which the way to the mode begins where a fit ended farther away.
    """

    wedge_sd: float = 3.0
    measured_wedge_sd: float = ZERO_SD
    image: float = 0.5
    min_error: float = 0.02
    max_harmonics: int = 24
    step: float = 0.1
    max_start: float = 2.0


RULES = MeasurementRules()
WEDGE, RADII, SCALE, ALL = "wedge pressure", "radii twice as exact", "scale of the image", "all of them"
_EXACT = 1e-6  # share of an SD that is left of what becomes exact
_MOST_NAMED = 8  # vessels that an error names


@dataclass(frozen=True, eq=False)
class ExpectedPrecision:
    """How exactly an animal is known, and by which factor each interval would shrink with a further measurement.

    Attributes
    ----------
    table : DataFrame
        Index: quantity (free parameters, then what follows from them); columns ``unit, value, low, high`` (95 % as it
        is), then one for each measurement: the width of the interval with it over that without it; 1 adds nothing.
    assumptions : tuple of str
        What each measurement is taken to be, and how the numbers are made.

    Examples
    --------
    >>> import vasowave as vw
    >>> network = vw.Network(("1",), [-1], [0.4], [0.05])  # a quick one: one vessel
    >>> search = vw.Search(fixed={"r1": 1.0, "c1": 1.0}, pressure_harmonics=8)
    >>> expected = vw.expected_precision(network, vw.virtual_mouse(), search=search)
    >>> bool(expected.table.loc["r2", "wedge pressure"] < 0.5)
    True
    """

    table: pd.DataFrame
    assumptions: tuple[str, ...]

    @property
    def measurements(self) -> tuple[str, ...]:
        """What could be measured."""
        return tuple(map(str, self.table.columns[4:]))

    def __repr__(self) -> str:
        rows = [
            f"  {name} {row['value']:.4g} [{row['low']:.3g}, {row['high']:.3g}] {row['unit'].removeprefix('1')}: "
            + ", ".join(f"{measurement} × {row[measurement]:.2f}" for measurement in self.measurements)
            for name, row in self.table.iterrows()
        ]
        return "\n".join(["ExpectedPrecision", *rows, *(f"  {text}" for text in self.assumptions)])


def expected_precision(
    network: Network,
    recording: Recording | EnsembleAverage,
    wall: str | type = "linear",
    *,
    vessels: Sequence[str] | None = None,
    beats: int = 4,
    start: Mapping[str, float] | None = None,
    **settings: Any,
) -> ExpectedPrecision:
    """Return by which factor the interval of each quantity would shrink with further measurements.

    They are a pressure in the middle of each vessel that is named, with the error of the recording; a wedge pressure,
    where none was measured; radii twice as exact; an image of exact scale, as with a cannula of known size; more beats.

    Parameters
    ----------
    network : Network
    recording : Recording or EnsembleAverage
    wall : str or class
        As for `calibrate`.
    vessels : sequence of str, optional
        Where a second pressure could be recorded, each once; by default the daughters of the root.
    beats : int
        How many times as many beats.
    start : mapping of str to float, optional
        Parameters as fitted (``fit.parameters["value"]``), from where the mode of the posterior is climbed to.
    settings
        Those of `Sampling` by name.

    Returns
    -------
    ExpectedPrecision

    Raises
    ------
    InputError
        A vessel that the network does not have, no whole number of beats from 2; as `posterior`.
    NumericalError
        The animal cannot be simulated near the start.

    Examples
    --------
    >>> import vasowave as vw
    >>> network = vw.Network(("1",), [-1], [0.4], [0.05])  # a quick one: one vessel
    >>> search = vw.Search(fixed={"r1": 1.0, "c1": 1.0}, pressure_harmonics=8)
    >>> vw.expected_precision(network, vw.virtual_mouse(), search=search).measurements
    ('wedge pressure', 'radii twice as exact', 'scale of the image', '4 × the beats', 'all of them')
    """
    if not (isinstance(beats, int | np.integer) and beats >= 2):
        raise InputError(f"beats: {beats!r}; give how many times as many there would be, a whole number, 2 or more")
    network, cycle = a_network(network), one_cycle(recording)
    vessels = _second_sites(network, vessels)
    sampling = _as_planned(given_values(Sampling, None, settings), cycle)
    problem = problem_of(network, cycle, wall, sampling)
    animal = _linearized(problem, vessels, {} if start is None else start)
    table = _quantity_table(animal)
    now = animal.spread(animal.covariance(_Measurement()))
    table["low"], table["high"] = animal.interval(now)
    for name, measurement in _measurements(animal, vessels, beats):
        table[name] = animal.spread(animal.covariance(measurement)) / now
    return ExpectedPrecision(table, _assumptions(animal, vessels))


def _as_planned(sampling: Sampling, cycle: Recording) -> Sampling:
    """Return what a posterior is of, with a wedge pressure that nobody measured as an unknown, and few harmonics."""
    priors, search = sampling.priors.allowing_for(cycle), sampling.search
    if not (priors.wedge or cycle.wedge_pressure):
        priors = replace(priors, wedge=RULES.wedge_sd)
    if search.pressure_harmonics == "signal":
        count = min(compared_part(cycle, "signal", search.enters).harmonics, RULES.max_harmonics)
        search = replace(search, pressure_harmonics=count)
    return replace(sampling, priors=priors, search=search)


def _second_sites(network: Network, vessels: Sequence[str] | None) -> Sequence[str]:
    """Return vessels that a network has, each once, by default the daughters of its root."""
    if vessels is None:
        return [network.name[row] for row in network.daughters[network.root]]
    first = [f"'{name}'" for name in network.name[:_MOST_NAMED]]
    names = ", ".join([*first, "…"] if len(first) < len(network.name) else first)
    try:
        sites = list(dict.fromkeys([vessels] if isinstance(vessels, str) else vessels))
    except TypeError:
        raise InputError(f"vessels: {vessels!r}; give a list of names; there are: {names}") from None
    for vessel in (vessel for vessel in sites if vessel not in network.name):
        hint = did_you_mean(str(vessel), network.name)
        raise InputError(f"the network has no vessel {vessel!r}{hint}; there are: {names}")
    return sites


@dataclass(frozen=True)
class _Measurement:
    """What becomes known: SD that are left of unknowns, as shares; of radii of single vessels; sites; beats."""

    remaining: Mapping[str, float] | None = None
    radii: float = 1.0
    sites: tuple[int, ...] = ()
    beats: int = 1


@dataclass(frozen=True, eq=False)
class _Linearized:
    """An animal about the mode of its posterior: derivatives by scores of what is compared, and of logarithms.

    `measured` counts the coefficients that were measured; those of sites that could be follow, a block each, and are
    taken to leave the same residual.
    """

    problem: Problem
    measured: int
    jacobian: np.ndarray
    vessels: np.ndarray
    residual: np.ndarray
    values: dict[str, float]
    slopes: np.ndarray

    def covariance(self, measurement: _Measurement) -> np.ndarray:
        """Return the covariance of the scores with a measurement."""
        rows = np.concatenate([np.arange(self.measured), *(self._rows(site) for site in measurement.sites)]).astype(int)
        radii = int(np.count_nonzero(self.problem.unknowns.own_errors[0]))
        of_vessels = self.vessels * np.where(np.arange(self.vessels.shape[1]) < radii, measurement.radii, 1.0)
        total = of_vessels @ of_vessels.T + self._errors(rows)
        total[np.diag_indices(self.problem.samples)] -= (1 - 1 / measurement.beats) * self._beats
        remaining = measurement.remaining or {}
        prior = np.array([remaining.get(name, 1.0) ** -2 for name in self.problem.unknowns.all])
        J = self.jacobian[rows]
        information = J.T @ np.linalg.solve(total[np.ix_(rows, rows)], J)
        return np.linalg.inv(information + np.diag(prior))

    def _errors(self, rows: np.ndarray) -> np.ndarray:
        """Return the covariance of everything but errors of single vessels, mmHg²; the discrepancy by what is seen."""
        noise, ignored = self.problem.discrepancy(self.vessels), np.ones(self.problem.count, dtype=bool)
        ignored[rows] = False
        errors = noise.measured.copy()
        errors[rows, rows] += noise.without(ignored).variance(self.residual[np.newaxis])
        return errors

    def _rows(self, site: int) -> np.ndarray:
        """Return which coefficients are those of a site that could be."""
        sites = self.problem.sites
        assert sites is not None
        first = next(
            place for place, rows in enumerate(sites.rows) if self.problem.samples + rows.start == self.measured
        )
        rows = sites.rows[first + site]
        return self.problem.samples + np.arange(rows.start, rows.stop)

    @property
    def _beats(self) -> np.ndarray:
        """Variance of the coefficients of the inlet by the scatter of beats, mmHg²."""
        k = harmonics(self.problem.samples)
        power = self.problem.compared.error_power()[k]
        return np.asarray(power * np.where(k == 0, 1.0, 0.5) * self.problem.samples)

    def spread(self, covariance: np.ndarray) -> np.ndarray:
        """Return the SD of each quantity: of its logarithm where it is positive."""
        return np.asarray(np.sqrt(np.einsum("qi,ij,qj->q", self.slopes, covariance, self.slopes)))

    def interval(self, spread: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the ends of the 95 % intervals of all quantities."""
        values = np.array(list(self.values.values()))
        factor, reach = np.exp(NORMAL * spread), NORMAL * spread
        positive = values > 0
        return np.where(positive, values / factor, values - reach), np.where(positive, values * factor, values + reach)


def _linearized(problem: Problem, vessels: Sequence[str], start: Mapping[str, float]) -> _Linearized:
    """Return an animal about the mode of its posterior, with sites in the middle of vessels that could be measured."""
    scores = np.clip(problem.unknowns.scores(start), -RULES.max_start, RULES.max_start)
    noise = problem.discrepancy()
    mode = climb(problem.simulate, problem.measured, noise, scores)
    extended = _with_sites(problem, vessels, mode.middle)
    steps = RULES.step * np.concatenate([np.eye(len(scores)), -np.eye(len(scores))])
    points = mode.middle + steps
    outputs = extended.simulate(points)
    if not np.isfinite(outputs).all():
        raise NumericalError("models near the mode of the posterior cannot be simulated; give narrower priors")
    jacobian = _slopes(outputs)
    of_vessels, residual = extended.vessels(mode.middle), problem.measured - mode.output
    noise = problem.discrepancy(of_vessels[: problem.count]).near(residual)
    if noise.passed is not None:
        jacobian[: problem.count] = noise.passed.slope(residual) @ jacobian[: problem.count]
    residual = np.append(residual, residual[_rows_at_inlet(extended, problem.count)])
    values, slopes = _quantities(extended, np.vstack([mode.middle, points]), np.vstack([outputs[:1], outputs]))
    return _Linearized(extended, problem.count, jacobian, of_vessels, residual, values, slopes)


def _slopes(rows: np.ndarray) -> np.ndarray:
    """Return central differences of values, (2 unknown, value), by the scores, shape (value, unknown)."""
    forward, backward = np.split(rows, 2)
    return np.asarray((forward - backward).T / (2 * RULES.step))


def _with_sites(problem: Problem, vessels: Sequence[str], point: np.ndarray) -> Problem:
    """Return a problem with pressures in the middle of vessels, as the model at a point has them."""
    if not vessels:
        return problem
    network, compared = problem.unknowns.network, problem.compared
    error = max(float(np.sqrt(compared.error_power().sum())), RULES.min_error)
    model, recorded = problem.unknowns.posed(point)
    pressure = simulate(model, compared.driven_by(recorded), problem.numerics)["pressure"].sel(station="middle")
    waves = [pressure.sel(vessel=name).to_numpy() for name in vessels]
    expected = [Observation("pressure", name, error, waveform=wave) for name, wave in zip(vessels, waves, strict=True)]
    measured = () if compared.sites is None else compared.sites.observations
    return replace(problem, compared=replace(compared, sites=sites_of((*measured, *expected), network, compared)))


def _rows_at_inlet(problem: Problem, measured: int) -> np.ndarray:
    """Return which coefficient of the inlet leaves what each one that could be measured will: of the same harmonic.

    Of a mean it is the first harmonic's: what bounds the model's error of the mean at the inlet does not elsewhere.
    """
    k = harmonics(problem.samples)
    added = np.zeros(0, int) if problem.sites is None else problem.sites.harmonic[measured - problem.samples :]
    return np.array([int(np.argmax(k == max(harmonic, 1))) for harmonic in added], dtype=int)


def _quantities(problem: Problem, points: np.ndarray, outputs: np.ndarray) -> tuple[dict[str, float], np.ndarray]:
    """Return parameters and what follows from them at the first point, and slopes by the scores about it.

    Slopes are those of logarithms where a quantity is positive; one that does not move is left out.
    """
    names = [*problem.unknowns.space.free_names, *OF_PARAMETERS, "tau"]
    at_points = problem.quantities(points, outputs, np.zeros(len(points))) | problem.unknowns.values(points)
    columns = {str(name): at_points[name] for name in names if np.ptp(at_points.get(name, 0.0)) > 0}
    slopes = [_slopes((np.log(column) if column.min() > 0 else column)[1:, np.newaxis]) for column in columns.values()]
    return {name: float(column[0]) for name, column in columns.items()}, np.concatenate(slopes)


def _quantity_table(animal: _Linearized) -> pd.DataFrame:
    """Return the quantities with their units and values."""
    parameters = {str(name): parameter.unit for name, parameter in animal.problem.unknowns.space.parameters.items()}
    units = [parameters.get(name) or QUANTITIES[name].unit for name in animal.values]
    index = pd.Index(animal.values, name="quantity")
    return pd.DataFrame({"unit": units, "value": list(animal.values.values())}, index)


def _measurements(animal: _Linearized, vessels: Sequence[str], beats: int) -> Iterator[tuple[str, _Measurement]]:
    """Go through what could be measured, and last all of it; nothing that is known exactly already."""
    unknowns = animal.problem.unknowns
    for site, name in enumerate(vessels):
        yield f"pressure in {name}", _Measurement(sites=(site,))
    remaining: dict[str, float] = {}
    if "wedge" in unknowns.all:
        remaining["wedge"] = min(1.0, RULES.measured_wedge_sd / unknowns.all["wedge"].spread)  # type: ignore[index]
        yield WEDGE, _Measurement(remaining=dict(remaining))
    scales = [str(name) for name in unknowns.all if name in ("radius_scale", "length_scale")]
    if "radius_scale" in scales or unknowns.own_errors[0].any():
        yield RADII, _Measurement(remaining={"radius_scale": RULES.image}, radii=RULES.image)
    if scales:
        remaining |= dict.fromkeys(scales, _EXACT)
        yield SCALE, _Measurement(remaining=dict.fromkeys(scales, _EXACT))
    yield f"{beats} × the beats", _Measurement(beats=beats)
    yield ALL, _Measurement(remaining, RULES.image, tuple(range(len(vessels))), beats)


def _assumptions(animal: _Linearized, vessels: Sequence[str]) -> tuple[str, ...]:
    """Return what the measurements are taken to be."""
    unknowns = animal.problem.unknowns
    texts = ["intervals are those of the posterior, taken for normal about its mode"]
    if "wedge" in unknowns.all:
        spread = unknowns.all["wedge"].spread  # type: ignore[index]
        texts.append(
            f"the pressure behind the beds is taken for known within {spread:g} mmHg now, and within "
            f"{RULES.measured_wedge_sd:g} mmHg with a wedge pressure"
        )
    if vessels:
        texts.append("a second pressure is recorded in the middle of its vessel, as exactly as that at the inlet")
    return (*texts, "a measurement that contradicts the model adds nothing, and that nobody can foretell")
