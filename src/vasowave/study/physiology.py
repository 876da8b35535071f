"""What an animal's recording and network say that no healthy or sick animal of its species has: mostly a slip."""

from collections.abc import Mapping

from vasowave.animal.result import AnimalResult
from vasowave.findings import Finding, Severity, from_json, look_kind
from vasowave.network.remarks import ROOT_RADIUS

NORMAL = {
    "mouse": {
        "HR": (300.0, 800.0, "beats/min"),
        "mPAP": (7.0, 45.0, "mmHg"),
        "pPAP": (4.0, 50.0, "mmHg"),
        "CO": (0.05, 0.45, "ml/s"),
        "root radius": (*ROOT_RADIUS["mouse"], "cm"),
    },
    "rat": {
        "HR": (200.0, 550.0, "beats/min"),
        "mPAP": (8.0, 70.0, "mmHg"),
        "pPAP": (5.0, 80.0, "mmHg"),
        "CO": (0.4, 4.0, "ml/s"),
        "root radius": (*ROOT_RADIUS["rat"], "cm"),
    },
}
"""Values outside are taken for slips until somebody has looked. For mice: well beyond three SD from the means
of the paper's Table 1; its two main pulmonary arteries have radii of 0.047 and 0.051 cm, so that a diameter in place
of the radius is noticed."""

_TAU = (0.02, 0.6)  # s, between which the time constant of a mouse or a rat is not odd

_IMPLAUSIBLE = (
    "{{name}} {{value:.4g}} {{unit}} is implausible for a {{species}} ({{low:g}} to {{high:g}}); is the unit right, "
    "and is it {}?{{fits}}"
)
IMPLAUSIBLE = look_kind(
    "physiology.implausible",
    _IMPLAUSIBLE.format("one whole cycle"),
    "Correct the unit or the recording, or name the species; `species: other` compares with nothing.",
)
IMPLAUSIBLE_RADIUS = look_kind(
    "physiology.implausible-radius",
    _IMPLAUSIBLE.format("a radius, not a diameter"),
    "Correct the unit or the network, or name the species; `species: other` compares with nothing.",
)
ODD_DECAY = look_kind(
    "physiology.odd-decay",
    "the pressure decays with τ = {tau:.3g} s after ejection (usual are {low:g} to {high:g} s); do pressure and flow "
    "belong together, and are they aligned?",
    "Align pressure and flow, or pair them anew.",
)


def physiology_findings(values: Mapping[str, float], tau: float, species: str) -> list[Finding]:
    """Return what is implausible for a species about an animal's indices, ``root radius`` (cm) and τ (s).

    If all of them are plausible for another species, its name is said.
    """
    found = []
    other = next((name for name in NORMAL if _plausible(values, name)), "")
    fits = f" All of them fit a {other}: write species: {other} (vasowave fit: --species {other})" if other else ""
    for name, (low, high, unit) in NORMAL.get(species, {}).items():
        value = float(values[name])
        if not low <= value <= high:
            which = IMPLAUSIBLE_RADIUS if name == "root radius" else IMPLAUSIBLE
            found.append(which(name=name, value=value, unit=unit, species=species, low=low, high=high, fits=fits))
    low, high = _TAU
    if species != "other" and not low <= tau <= high:
        found.append(ODD_DECAY(tau=float(tau), low=low, high=high))
    return found


def _plausible(values: Mapping[str, float], species: str) -> bool:
    return all(low <= float(values[name]) <= high for name, (low, high, _) in NORMAL[species].items())


def looks_of(result: AnimalResult, species: str) -> tuple[Finding, ...]:
    """Return what asks for a look at an animal: at its recording, and what is implausible for its species."""
    noticed = from_json(result.recording.attrs["findings"])
    measured, network = result.measured.quantities, result.network
    values = {name: float(measured[name]) for name in NORMAL["mouse"] if name in measured}
    values["root radius"] = float(network.radius[network.root])
    odd = physiology_findings(values, float(measured["tau"]), species)
    return *(one for one in noticed if one.severity is Severity.LOOK), *odd
