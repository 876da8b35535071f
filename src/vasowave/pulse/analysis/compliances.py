"""Compliance of the network and of its beds."""

from dataclasses import dataclass

import numpy as np

from vasowave.base.errors import InputError
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.walls import area_compliance
from vasowave.pulse.network.graph import steady_flows
from vasowave.pulse.network.network import Network


@dataclass(frozen=True, eq=False)
class Compliance:
    """Compliances, ml/mmHg. The published rule and the plain sum of C_v differ widely: see docs/analysis.md.

    Attributes
    ----------
    vessel : array, shape (vessel,)
        L dA/dp of each vessel.
    network_published, network_sum : float
        C_v by the series/parallel rule (eqs. 28, 29), and as ΣL dA/dp.
    peripheral : float
        C_p = ΣĈ_p of the beds.
    resistance : float
        R_T, mmHg s/ml.
    """

    vessel: np.ndarray
    network_published: float
    network_sum: float
    peripheral: float
    resistance: float

    def total(self, published: bool = True) -> float:
        """C_T = C_v + ΣĈ_p (eq. 30)."""
        return self.peripheral + (self.network_published if published else self.network_sum)

    def peripheral_share(self, published: bool = True) -> float:
        """C_p/C_T."""
        return self.peripheral / self.total(published)

    def time_constant(self, published: bool = True) -> float:
        """τ = R_T C_T, s."""
        return self.resistance * self.total(published)


def compliance(model: Model, pressure: float | np.ndarray) -> Compliance:
    """Compliances of a model, ml/mmHg (eqs. 25 to 30), at a transmural pressure (the paper takes the diastolic).

    Parameters
    ----------
    model : Model
        With outlets that have a capacitor.
    pressure : float or array, shape (vessel,)
        mmHg.

    Raises
    ------
    InputError
        Other outlets, or a pressure that is not finite or of another shape.

    Examples
    --------
    >>> import vasowave as vw
    >>> network = vw.control_network()
    >>> nominal = vw.estimate_nominal(network, vw.virtual_mouse())
    >>> model = vw.Model(network, vw.LinearWall(nominal.beta), nominal.outlets)
    >>> vw.compliance(model, 10.0).vessel.shape  # of every vessel, at 10 mmHg
    (21,)
    """
    if np.shape(pressure) not in ((), (len(model.network),)) or not np.all(np.isfinite(pressure)):
        raise InputError(f"pressure must be one finite number or {len(model.network)} of them")
    peripheral = float(model.outlets.weighted_compliance().sum())
    vessel = model.network.length * np.asarray(_mean_area_compliance(model, pressure))
    return Compliance(
        vessel,
        series_parallel(model.network, vessel),
        float(vessel.sum()),
        peripheral,
        model.outlets.total_resistance(),
    )


def _mean_area_compliance(model: Model, pressure: float | np.ndarray) -> np.ndarray:
    """Return dA/dp, cm²/mmHg, as the mean along every vessel, shape (vessel,); by Simpson's rule where it changes."""
    at_middle = np.asarray(area_compliance(model.wall, pressure, model.area0))
    if not model.changing.any():
        return at_middle
    rows = np.arange(len(model.network))
    inlet, middle, outlet = (
        np.asarray(area_compliance(wall, pressure, area0))
        for wall, area0 in (model.at(rows, np.full(len(rows), share)) for share in (0.0, 0.5, 1.0))
    )
    return np.where(model.changing, (inlet + 4.0 * middle + outlet) / 6.0, at_middle)


def series_parallel(network: Network, vessel: np.ndarray) -> float:
    """C_v, ml/mmHg, by the published rule: each vessel in series with its daughters in parallel (eqs. 28, 29).

    Compliances are joined as conductances would be, which says what the rule is where vessels form loops.
    """
    if network.nodes is not None:
        return float(steady_flows(network.start, network.end, vessel)[network.inlets].sum())
    tree = np.array(vessel, dtype=float)
    for rows in network.generations[::-1]:
        for row in rows:
            if network.daughters[row]:
                below = sum(tree[d] for d in network.daughters[row])
                tree[row] = tree[row] * below / (tree[row] + below)
    return float(tree[network.root])
