"""Every key of ``study.yaml``, made from the settings of the functions and dataclasses that use them.

The template, the editor's schema, the documentation and the options of `vasowave fit` are made from these classes.
"""

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal

from annotated_types import Ge, Le, MinLen
from pydantic import BaseModel, ConfigDict, Field, create_model, field_validator, model_validator

from vasowave.analysis import WavesAt
from vasowave.animal.animal import Settings
from vasowave.calibration import Search
from vasowave.calibration.calibrate import NUMERICS
from vasowave.cohort.primary import Family
from vasowave.model.blood import FRICTIONS, Blood
from vasowave.network.network import HIGHEST
from vasowave.recording import average_beats
from vasowave.recording.beats import HEART_RATES
from vasowave.settings import Check, Positive, Setting, settings_of
from vasowave.solver import Numerics
from vasowave.solver.practice import PAPER
from vasowave.study.names import checked_name

_ANIMAL, _NUMERICS, _BLOOD = settings_of(Settings), settings_of(Numerics), settings_of(Blood)
_PRACTICE = (
    "paper: compute as the paper's program did, to compare with its tables: friction as at 0.07 cm everywhere, its "
    "constants and bounds, eight cycles from rest, lengths rounded down to 0.025 cm, all harmonics, radii as at zero "
    "pressure; `blood`, `numerics` and `waves_at` are then its own."
)
_EXAMPLES: dict[str, Any] = {"bounds": {"beta": [10, 400], "c1": [0.05, 5]}, "fixed": {"gamma": 2}}
Text = Annotated[str, MinLen(1)]


class Section(BaseModel):
    """A part of the study file; unknown keys are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


def _fields(settings: Mapping[str, Setting]) -> dict[str, Any]:
    """Return settings as pydantic writes them."""
    return {name: (one.kind, _field(name, one)) for name, one in settings.items()}


def _field(name: str, one: Setting) -> Any:
    return Field(one.default, description=one.meaning, examples=[_EXAMPLES[name]] if name in _EXAMPLES else None)


def _chosen(settings: Mapping[str, Setting], names: Iterable[str]) -> dict[str, Setting]:
    return {name: settings[name] for name in names}


def _section(name: str, words: str, settings: Mapping[str, Setting], base: type[Section] = Section) -> Any:
    model = create_model(name, __base__=base, __doc__=words, **_fields(settings))
    return model, model()


def _friction_settings() -> dict[str, Setting]:
    """Return the choice of a friction law and the settings of every law."""
    settings = {"friction": Setting(Literal[tuple(FRICTIONS)], next(iter(FRICTIONS)), _BLOOD["friction"].meaning)}
    for name, law in FRICTIONS.items():
        settings |= {key: one._replace(meaning=f"For {name}: {one.meaning}") for key, one in settings_of(law).items()}
    return settings


class _FrictionBelongs(Section):
    @model_validator(mode="after")
    def _belongs(self) -> "_FrictionBelongs":
        given: dict[str, Any] = self.model_dump(exclude_defaults=True)
        for name, law in FRICTIONS.items():
            for key in settings_of(law):
                if key in given and given.get("friction", next(iter(FRICTIONS))) != name:
                    raise ValueError(f"{key} belongs to friction '{name}', not to '{self.model_dump()['friction']}'")
        return self


class _First(Section):
    title: Text = Field("Pulmonary arteries of two groups", description="Title of the report.")
    animals: Text = Field("animals.csv", description="The table of animals, beside this file.")
    species: Literal["mouse", "rat", "other"] = Field(
        "mouse",
        description="Whose physiology `check` compares with, and whose heart rates are looked for: mouse, rat or "
        "other (no comparison).",
    )
    groups: Annotated[list[Annotated[Text, Check(checked_name)]], MinLen(1)] = Field(
        ["CTL", "HPH"], description="Group labels in the order of tables; the first is the reference."
    )

    image_pressure: Annotated[float, Ge(0), Le(HIGHEST)] = Field(
        0.0,
        description="Transmural pressure at which the vessels were filled for the image, mmHg, of the animals whose "
        "network or row does not say it; 0 where it is not known.",
    )

    catheter: tuple[Positive, Positive] | None = Field(
        None,
        description="Natural frequency (Hz) and damping ratio of the catheter, by a flush test: the pressures are "
        "corrected for it. Nothing is corrected unless this is given.",
    )

    practice: Literal["vasowave", "paper"] = Field("vasowave", description=_PRACTICE)

    @field_validator("groups")
    @classmethod
    def _distinct(cls, value: list[str]) -> list[str]:
        twice = next((label for label in value if value.count(label) > 1), None)
        if twice is not None:
            raise ValueError(f"group '{twice}' is listed twice; keep one")
        return value


_All: Any = create_model(
    "_All",
    __base__=_First,
    averaging=_section(
        "Averaging",
        "From continuous recordings to one cycle. Only for animals of kind 'raw'.",
        settings_of(average_beats),
    ),
    calibration=_section(
        "Calibration",
        "The fit of each wall law to each recording.",
        _chosen(_ANIMAL, ("walls", "beds", *settings_of(Search))),
    ),
    **_fields(_chosen(_ANIMAL, ("model_selection", "selection_optima", "waves_at", "inference", "zero_sd"))),
    blood=_section(
        "Blood",
        "Blood and its friction at the wall.",
        _chosen(_BLOOD, ("density", "viscosity")) | _friction_settings(),
        _FrictionBelongs,
    ),
    numerics=_section(
        "NumericsOfFits",
        "How finely the model is simulated.",
        {
            name: _NUMERICS[name]._replace(default=getattr(NUMERICS, name))
            for name in ("cell_size", "tolerance", "most_cycles", "cycles_from_rest")
        },
    ),
    report=_section(
        "ReportSection",
        "The report: its files, and what of it is primary.",
        {"pdf": Setting(bool, True, "Whether the pages are also written as PDF.")} | settings_of(Family),
    ),
)


class StudyFile(_All):
    """Everything that ``study.yaml`` says."""

    @model_validator(mode="after")
    def _one_practice(self) -> "StudyFile":
        own = [name for name in ("blood", "numerics", "waves_at") if name in self.model_dump(exclude_defaults=True)]
        if self.practice == "paper" and own:
            raise ValueError(f"practice 'paper' sets {', '.join(own)} itself; leave that out, or the practice")
        return self

    if TYPE_CHECKING:  # made above
        averaging: Any
        calibration: Any
        model_selection: bool
        inference: str
        zero_sd: float
        selection_optima: tuple[Literal["OLS", "GLS"], ...]
        waves_at: WavesAt
        blood: Any
        numerics: Any
        report: Any


def averaging_settings(study: StudyFile) -> dict[str, Any]:
    """Return the arguments of `average_beats`; heart rates that the study file leaves open are those of its species."""
    given: dict[str, Any] = study.averaging.model_dump()
    return given | {"heart_rates": given["heart_rates"] or HEART_RATES.get(study.species, HEART_RATES["mouse"])}


def animal_settings(study: StudyFile) -> Settings:
    """Return what the study file says about the analysis of an animal."""
    if study.practice == "paper":
        return _paper_settings(study)
    blood = study.blood.model_dump()
    law = FRICTIONS[blood["friction"]]
    return Settings(
        **study.calibration.model_dump(),
        model_selection=study.model_selection,
        inference=study.inference,  # type: ignore[arg-type]
        zero_sd=study.zero_sd,
        selection_optima=study.selection_optima,
        waves_at=study.waves_at,
        blood=Blood(blood["density"], blood["viscosity"], law(**{name: blood[name] for name in settings_of(law)})),
        numerics=Numerics(**study.numerics.model_dump()),
    )


def _paper_settings(study: StudyFile) -> Settings:
    calibration = study.calibration.model_dump() | {"paper_bounds": True, "pressure_harmonics": "all"}
    return Settings(
        **calibration,
        model_selection=study.model_selection,
        selection_optima=study.selection_optima,
        waves_at="paper",
        inference=study.inference,  # type: ignore[arg-type]
        zero_sd=study.zero_sd,
        blood=PAPER.blood,
        numerics=PAPER.numerics,
    )
