"""Repairs of a network with what they change for waves: its input impedance by the linear theory, before and after.

Two vessels in line that become one keep their resistance and compliance (`network.tidying`), but not the wave that a
change of the radius sends back. So only those are joined whose radii are so alike that the impedance stays.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.species import SPECIES, known_species
from vasowave.pulse.cycle.cycle import Inflow
from vasowave.pulse.model.linear import linear_solution
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.nominal import windkessels
from vasowave.pulse.model.outlets import Windkessel
from vasowave.pulse.model.walls import LinearWall
from vasowave.pulse.network import tidying
from vasowave.pulse.network.network import Network
from vasowave.pulse.network.tidying import SHORTEST, Tidied

_SAMPLES = 64


@dataclass(frozen=True)
class ProofRules:
    """The model in which an impedance is compared before and after repairs.

    Attributes
    ----------
    change : float
        Share of the impedance by which repairs may change a harmonic.
    harmonics : int
        From the first on.
    stiffness : float
        β of the linear law, mmHg: the mean of the paper's control mice, a wave speed of 1.9 m/s.
    ejection : float
        Share of the cycle that the heart ejects, in half a sine.
    alike : tuple of float
        Differences of the radii of vessels that are joined, tried one after the other until the impedance stays.
    """

    change: float = 0.01
    harmonics: int = 10
    stiffness: float = 57.0
    ejection: float = 0.4
    alike: tuple[float, ...] = (np.inf, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.0)


PROOF = ProofRules()


def tidy(network: Network, shortest: float = SHORTEST, *, change: float = PROOF.change, species: str = "") -> Tidied:
    """Return the network without vessels too short to carry a wave and without chains of vessels that are alike.

    Two vessels in line become one with the sum of their resistances to Poiseuille flow, ∝ Σ L/r⁴, and of their
    compliances at equal stiffness, ∝ Σ L r². A vessel shorter than `shortest` of its own radii hands both on to its
    daughters, as they share its flow; one without daughters is made `shortest` long, and so is an inlet, and one whose
    end others meet. Terminals keep their names, so that beds by name stay with them.

    The input impedance is computed before and after with the same beds (linear theory, nominal beds, the species'
    usual heart rate, output and pressure). As many vessels in line are joined as `change` allows; the others stay.

    Parameters
    ----------
    network : Network
    shortest : float
        Shortest vessel that is kept, in its own radii.
    change : float
        By how much a harmonic of the input impedance may change, as a share of it; infinity for any.
    species : str
        See `SPECIES`; by default the one whose main pulmonary artery is nearest to the root in size.

    Raises
    ------
    InputError
        `shortest` or `change` is negative or not a number; short vessels whose repair alone changes the impedance by
        more than `change`.

    Examples
    --------
    >>> import vasowave as vw
    >>> lung = vw.Network(("main", "stub", "left", "right"), [-1, 0, 1, 1], [0.4, 1e-4, 0.4, 0.3],
    ...                   [0.05, 0.04, 0.03, 0.03])
    >>> tidied = vw.tidy(lung)
    >>> tidied.network
    Network(3 vessels, 2 terminals, root 'main' r0 0.05 cm, total length 1.1 cm)
    >>> print(*tidied.repairs, sep="\\n")
    nothing divides between 'main' and 'stub' (0.0001 cm); both are 'main' now
    """
    if not change >= 0:
        raise InputError(f"the change of the impedance, {change:g}, must be a share of at least 0")
    repaired = tidying.tidy(network, shortest)
    if not repaired.repairs:
        return repaired
    usual = _Usual.of(species or _nearest(network), network)
    beds = usual.beds(network)
    before = usual.impedance(network, beds)
    row = {network.name[terminal]: place for place, terminal in enumerate(network.terminals)}
    smallest = np.inf
    for alike in PROOF.alike:
        tidied = tidying.tidy(network, shortest, alike=alike)
        after = tidied.network
        rows = [row[after.name[terminal]] for terminal in after.terminals]
        same = Windkessel(*(values[rows] for values in beds))
        changes = np.abs(usual.impedance(after, same) / before - 1).max(axis=1)
        if changes.max() <= change:
            split = np.abs(usual.impedance(after, usual.beds(after)) / before - 1).max(axis=1)
            return replace(tidied, change=changes, split=split)
        smallest = min(smallest, float(changes.max()))
    raise InputError(
        f"repairing vessels that are too short changes the input impedance by {100 * smallest:.3g} %, more than the "
        f"{100 * change:.2g} % that are allowed; lower the shortest length ({shortest:g} radii), repair the table "
        "yourself, or allow more"
    )


def _nearest(network: Network) -> str:
    """Return the species whose main pulmonary artery is nearest to the root in size."""
    size = np.log(network.radius[network.root])
    return min(SPECIES, key=lambda name: abs(np.log(np.prod(SPECIES[name].root_radius)) / 2 - size))


class _Usual(NamedTuple):
    """The middle of a species' ranges: period (s), total resistance (mmHg s/ml), time constant (s), inflow."""

    inflow: Inflow
    R_T: float
    tau: float

    @classmethod
    def of(cls, species: str, network: Network) -> "_Usual":
        if known_species(species) not in SPECIES:
            raise InputError("the impedance needs a species with a heart rate; name one of " + ", ".join(SPECIES))
        ranges = SPECIES[species]
        middle = (np.sqrt(np.prod(bounds)) for bounds in (ranges.HR, ranges.mPAP, ranges.CO, ranges.tau))
        rate, pressure, output, tau = middle
        share = np.arange(_SAMPLES) / _SAMPLES / PROOF.ejection
        flow = np.where(share < 1, np.sin(np.pi * np.minimum(share, 1)), 0.0)
        flow *= output / flow.mean()
        inlets = network.flow_fraction[network.inlets]
        flows = flow if len(inlets) == 1 else flow[:, np.newaxis] * inlets
        return cls(Inflow(flows, 60.0 / float(rate)), float(pressure / output), float(tau))

    def beds(self, network: Network) -> Windkessel:
        return windkessels(network, self.R_T, self.tau)

    def impedance(self, network: Network, beds: Windkessel) -> np.ndarray:
        """Return the impedances at the inlets from the first harmonic on, shape (harmonic, inlet)."""
        model = Model(network, LinearWall(PROOF.stiffness), beds)
        return linear_solution(model, self.inflow, PROOF.harmonics).input_impedance[1:, network.inlets]
