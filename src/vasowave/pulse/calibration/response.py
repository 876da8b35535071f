"""An unknown response of amplifier and catheter to the pressure: a fit estimates it beside the parameters.

It is of first order, with a lag, or of second order, with an inertia, too (`second_order`).
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from vasowave.base.findings import Finding, note_kind
from vasowave.pulse.calibration.response_search import RESPONSE

LAG = note_kind(
    "fit.lag",
    "The lag of the pressure was fitted beside the parameters: {lag:.2g} ± {error:.2g} ms (assumed: 0 ± {prior:.2g} "
    "ms); a filter of first order has the cut-off frequency 1/(2π lag).",
)
INERTIA = note_kind(
    "fit.inertia",
    "The inertia of the catheter was fitted beside the parameters: {inertia:.2g} ± {error:.2g} ms² (assumed: 0 ± "
    "{prior:.2g} ms²); the natural frequency of a catheter is 1/(2π √inertia), its damping ratio lag/(2 √inertia).",
)


class Estimate(NamedTuple):
    """A number of the response: its estimate, the SD of its error, and the SD that it was assumed to have."""

    value: float
    error: float
    prior: float


Response = dict[str, Estimate]
"""What of the response was fitted, by name."""


def findings(response: Response) -> Iterator[Finding]:
    """Return what a reader must know of a response."""
    for name, (value, error, prior) in response.items():
        if name == "pressure_lag":
            yield LAG(lag=1e3 * value, error=1e3 * error, prior=1e3 * prior)
        else:
            yield INERTIA(inertia=1e6 * value, error=1e6 * error, prior=1e6 * prior)


def in_words(response: Response) -> str:
    """Return the estimates as words of a sentence, each after a comma."""
    return "".join(
        f", lag of the pressure {1e3 * estimate.value:.2g} ± {1e3 * estimate.error:.2g} ms"
        if name == "pressure_lag"
        else f", inertia of the catheter {1e6 * estimate.value:.2g} ± {1e6 * estimate.error:.2g} ms²"
        for name, estimate in response.items()
    )


def estimates(response: tuple[float, float], errors: Sequence[float], priors: Mapping[str, float]) -> Response:
    """Return what was fitted of a response by name; the errors are in SD of the prior."""
    values = dict(zip(RESPONSE, response, strict=True))
    return {
        name: Estimate(values[name], prior * float(error), prior)
        for (name, prior), error in zip(priors.items(), errors, strict=True)
    }
