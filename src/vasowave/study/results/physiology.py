"""Values of an animal that no healthy or sick animal of its species has: mostly a slip."""

from collections.abc import Mapping

from vasowave.base.cures import SetSetting
from vasowave.base.findings import Finding, Severity, from_json, look_kind, warn
from vasowave.base.sites import PULMONARY, ranges_at
from vasowave.base.species import SPECIES, Species
from vasowave.study.animal.result import AnimalResult
from vasowave.study.folder.settings import BloodSection

_UNITS = {"HR": "beats/min", "mPAP": "mmHg", "pPAP": "mmHg", "CO": "ml/s", "root radius": "cm"}

BLOOD = {"density": (0.95, 1.3, "g/ml", 1.057), "viscosity": (0.005, 0.3, "cm²/s", 0.0462)}
"""What blood of any species and the liquids used in its place have, unit, and the default."""

_IMPLAUSIBLE_TEXT = (
    "{{name}} {{value:.4g}} {{unit}} is implausible for a {{species}} ({{low:g}} to {{high:g}}); is the unit right, "
    "and is it {}?{{fits}}"
)
_SPECIES = SetSetting("The species is {likely}", "species", "{likely}")
IMPLAUSIBLE = look_kind(
    "physiology.implausible",
    _IMPLAUSIBLE_TEXT.format("one whole cycle"),
    "Correct the unit or the recording, or name the species (other compares with nothing); of a systemic "
    "artery, name that.",
    _SPECIES,
    SetSetting("It is of the aorta", "site", "aorta"),
)
IMPLAUSIBLE_RADIUS = look_kind(
    "physiology.implausible-radius",
    _IMPLAUSIBLE_TEXT.format("a radius, not a diameter"),
    "Correct the unit or the network, or name the species (other compares with nothing).",
    _SPECIES,
)
ODD_DECAY = look_kind(
    "physiology.odd-decay",
    "the pressure decays with τ = {tau:.3g} s after ejection (usual are {low:g} to {high:g} s); do pressure and flow "
    "belong together, and are they aligned?",
    "Align pressure and flow, or pair them anew.",
)


NO_BLOOD = look_kind(
    "check.no-blood",
    "blood.{quantity}: {value:g} {unit} is no blood's ({low:g} to {high:g}, usual {usual:g}); is the unit right?",
    "Correct the number or its unit.",
)


def blood_findings(blood: BloodSection) -> list[Finding]:
    """Return which properties of a blood no blood has."""
    values = ((name, getattr(blood, name), *limits) for name, limits in BLOOD.items())
    return [NO_BLOOD(quantity=name, value=value, unit=unit, low=low, high=high, usual=usual)
            for name, value, low, high, unit, usual in values if not low <= value <= high]  # fmt: skip


def tell_blood(blood: BloodSection) -> None:
    """Warn of a density or viscosity that no blood has."""
    for finding in blood_findings(blood):
        warn(finding, stacklevel=3)


def physiology_findings(values: Mapping[str, float], tau: float, species: str, site: str = PULMONARY) -> list[Finding]:
    """Return what is implausible for a species about an animal's indices, ``root radius`` (cm) and τ (s).

    If all of them are plausible for another species, its name is said.
    """
    findings = []
    if species not in SPECIES:
        return []
    fitting_species = [name for name in SPECIES if not _outside(values, ranges_at(name, site))]
    fits, likely = "", "other"
    if fitting_species:
        species_names, likely = " or a ".join(fitting_species), fitting_species[0]
        fits = f" All of them fit a {species_names}: if it is one, name that species"
    for name, (low, high) in _outside(values, ranges_at(species, site)).items():
        kind = IMPLAUSIBLE_RADIUS if name == "root radius" else IMPLAUSIBLE
        value, unit = float(values[name]), _UNITS[name]
        findings.append(
            kind(name=name, value=value, unit=unit, species=species, low=low, high=high, fits=fits, likely=likely)
        )
    if fits:
        findings = findings[:1]  # one remedy for all of them
    low, high = SPECIES[species].tau
    if not low <= tau <= high:
        findings.append(ODD_DECAY(tau=float(tau), low=low, high=high))
    return findings


def _outside(values: Mapping[str, float], species: Species) -> dict[str, tuple[float, float]]:
    """Return the usual range of every value that lies outside it."""
    ranges = {name: getattr(species, name.replace(" ", "_")) for name in _UNITS}
    return {name: (low, high) for name, (low, high) in ranges.items() if not low <= float(values[name]) <= high}


def looks_of(result: AnimalResult, species: str) -> tuple[Finding, ...]:
    """Return what asks for a look at an animal: at its recording, and what is implausible for its species."""
    noticed = from_json(result.recording.attrs["findings"])
    measured, network = result.measured.quantities, result.network
    values = {name: float(measured[name]) for name in _UNITS if name in measured}
    values["root radius"] = float(network.radius[network.root])
    site = str(result.recording.attrs.get("site", PULMONARY))
    odd = physiology_findings(values, float(measured["tau"]), species, site)
    return *(finding for finding in noticed if finding.severity is Severity.LOOK), *odd
