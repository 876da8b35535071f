"""Every key of ``study.yaml``: what is of a study alone, and the settings of what it runs.

The template, the editor's schema, the documentation and the options of `vasowave fit` are made from these classes.
"""

from dataclasses import field, replace
from typing import Annotated, Any, Literal

from annotated_types import Ge, Le, MaxLen, MinLen

from vasowave.base.errors import InputError
from vasowave.base.settings import Check, Example, Positive, settings_class, settings_of
from vasowave.base.sites import PULMONARY, SiteName
from vasowave.base.species import SpeciesName, heart_rates_of
from vasowave.catheter.beats.prepared import Averaging
from vasowave.pulse.calibration.fitting import NUMERICS
from vasowave.pulse.inference.known_errors import KnownErrors
from vasowave.pulse.model.blood import FRICTIONS, Blood, BoundaryLayer, Fluid, FrictionName, PowerLaw, relative_to_usual
from vasowave.pulse.model.numerics import Numerics, Resolution
from vasowave.pulse.network.network import HIGHEST
from vasowave.pulse.noise.fitting import OF_PAPER
from vasowave.pulse.solver.practice import PAPER
from vasowave.study.animal.animal import Analysis, Calibration, Settings
from vasowave.study.cohort.design import Design
from vasowave.study.folder.names import checked_name
from vasowave.study.folder.rows import AnimalRow
from vasowave.study.report.settings import ReportSettings

Text = Annotated[str, MinLen(1), MaxLen(1000)]
Frequency = Annotated[float, Ge(0.1), Le(1e5)]
Damping = Annotated[float, Ge(0.001), Le(100)]


def _distinct(labels: list[str]) -> list[str]:
    twice = next((label for label in labels if labels.count(label) > 1), None)
    if twice is not None:
        raise InputError(f"group '{twice}' is listed twice; keep one")
    labels_by_name: dict[str, str] = {}
    for label in labels:
        if (namesake := labels_by_name.setdefault(label.casefold(), label)) != label:
            raise InputError(f"groups '{namesake}' and '{label}' differ by capitals alone; keep one, or rename it")
    return labels


@settings_class
class _FrictionOfBlood(Fluid):
    friction: FrictionName = "boundary-layer"
    """Friction law: boundary-layer (eq. 2), poiseuille or power-law."""


@settings_class
class BloodSection(PowerLaw, BoundaryLayer, _FrictionOfBlood):
    """Blood and its friction at the wall."""

    def __post_init__(self) -> None:
        """Refuse a setting of a friction law that is not the chosen one."""
        for name, law in FRICTIONS.items():
            for key in settings_of(law):
                if name != self.friction and getattr(self, key) != settings_of(BloodSection)[key].default:
                    raise InputError(f"{key} belongs to friction '{name}', not to '{self.friction}'")

    def blood(self) -> Blood:
        """Return the blood with its friction law."""
        law = FRICTIONS[self.friction]
        return Blood(self.density, self.viscosity, law(**{key: getattr(self, key) for key in settings_of(law)}))


@settings_class
class NumericsOfFits(Resolution):
    """How finely the model is simulated."""

    tolerance: Positive = NUMERICS.tolerance


@settings_class
class Inputs:
    """What a study is of, and how its animals come to be calibrated."""

    title: Text = "Arteries of the groups"
    """Title of the report."""
    animals: Text = "animals.csv"
    """The table of animals, beside this file."""
    species: SpeciesName = "mouse"
    """Whose physiology `check` compares with, and whose heart rates are looked for: mouse, rat, rabbit, dog, pig,
    human, or other (no comparison)."""
    site: SiteName = PULMONARY
    """The artery that is recorded and modeled: pulmonary artery, aorta, carotid, brachial, radial, femoral, renal or
    mesenteric. `check` compares with what is plausible there, and channels are chosen by titles that speak of it."""
    groups: Annotated[list[Annotated[Text, Check(checked_name)]], MinLen(1), MaxLen(1000), Check(_distinct)] = field(
        default_factory=lambda: ["CTL", "HPH"]
    )
    """Group labels in the order of tables; the first is the reference."""
    image_pressure: Annotated[float, Ge(0), Le(HIGHEST)] = 0.0
    """Transmural pressure at which the vessels were filled for the image, mmHg, of the animals whose network or row
    does not say it; 0 where it is not known."""
    catheter: Annotated[tuple[Frequency, Damping] | None, Example((60, 0.4))] = None
    """Natural frequency (Hz) and damping ratio of the catheter, by a flush test: the pressures are corrected for it.
    Nothing is corrected unless this is given."""
    practice: Literal["vasowave", "paper"] = "vasowave"
    """paper: compute as the paper's program did, to compare with its tables: friction as at 0.07 cm everywhere, its
    constants and bounds, eight cycles from rest, lengths rounded down to 0.025 cm, all harmonics at the places of its
    samples, radii as at zero pressure, its noise models beside ours, no error that is not said; `blood`, `numerics`,
    `waves_at` and `noise_models` are then its own."""
    averaging: Averaging = field(default_factory=Averaging)
    calibration: Calibration = field(default_factory=Calibration)


@settings_class
class StudyFile(Analysis, Inputs):
    """Everything that ``study.yaml`` says."""

    blood: BloodSection = field(default_factory=BloodSection)
    numerics: NumericsOfFits = field(default_factory=NumericsOfFits)
    design: Design = field(default_factory=Design)
    report: ReportSettings = field(default_factory=ReportSettings)

    def __post_init__(self) -> None:
        """Refuse what the paper's practice sets itself."""
        known_settings = settings_of(StudyFile)
        changed_names = [
            name for name in ("blood", "numerics", "waves_at", "noise_models")
            if getattr(self, name) != known_settings[name].default
        ]  # fmt: skip
        if self.calibration.pressure_harmonics not in (Calibration.pressure_harmonics, "all"):
            changed_names.append("calibration.pressure_harmonics")
        if self.practice == "paper" and changed_names:
            raise InputError(
                f"practice 'paper' sets {', '.join(changed_names)} itself; leave that out, or the practice"
            )
        if self.practice == "paper" and self.calibration.enters == "pressure":
            raise InputError("practice 'paper' lets the flow enter; leave calibration.enters out, or the practice")


def averaging_settings(study: StudyFile) -> Averaging:
    """Return how beats are averaged; heart rates that the study file leaves open are those of its species."""
    rates = study.averaging.heart_rates or heart_rates_of(study.species)
    return replace(study.averaging, heart_rates=rates)


def animal_settings(study: StudyFile, row: AnimalRow | None = None) -> Settings:
    """Return what the study file says about the analysis of an animal, and of one its row in the table of animals."""
    values = {name: getattr(study, name) for name in settings_of(Analysis)}
    values |= {name: getattr(study.calibration, name) for name in settings_of(Calibration)}
    numerics = {name: getattr(study.numerics, name) for name in settings_of(Resolution)}
    settings = Settings(**values, blood=study.blood.blood(), numerics=Numerics(**numerics))
    if study.practice == "paper":
        exact: dict[str, Any] = {name: getattr(study, name) or 0.0 for name in settings_of(KnownErrors)}
        settings = replace(
            settings, paper_bounds=True, pressure_harmonics="all", waves_at="paper", blood=PAPER.blood,
            numerics=PAPER.numerics, noise_models=OF_PAPER, **exact,
        )  # fmt: skip
    if row is None:
        return settings
    thicker = relative_to_usual(row.hematocrit, row.temperature)
    blood = replace(settings.blood, viscosity=settings.blood.viscosity * thicker)
    errors: dict[str, Any] = {**row.errors}
    return replace(settings, blood=blood, **errors)
