"""Every key of ``study.yaml``: meaning, unit, default and allowed values.

The template, the editor's schema and the documentation are made from these classes, so they cannot disagree.
"""

from typing import Annotated, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, field_validator, model_validator


def _ordered(pair: tuple[float, float]) -> tuple[float, float]:
    if not pair[0] < pair[1]:
        raise ValueError(f"{pair[0]:g} is not below {pair[1]:g}; write [lower, upper]")
    return pair


Positive = Annotated[float, Field(gt=0)]
Range = Annotated[tuple[Positive, Positive], AfterValidator(_ordered)]
Parameter = Literal["beta", "p1", "gamma", "r1", "r2", "c1"]


class Section(BaseModel):
    """A part of the study file; unknown keys are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Averaging(Section):
    """From continuous recordings to one cycle. Only for animals of kind 'raw'."""

    beats: int = Field(20, ge=2, description="Consecutive good beats to average (20 in the paper).")
    samples: int = Field(256, ge=32, description="Samples of the averaged cycle.")
    harmonics: int | None = Field(
        20, ge=1, description="Harmonics of the averaged cycle that are kept; empty keeps all."
    )
    fiducial: Literal["ecg", "pressure"] | None = Field(
        None,
        description="What beats are aligned by: ecg (R wave) or pressure (foot). Empty: the ECG where there is one.",
    )
    heart_rates: Range = Field((250.0, 900.0), description="Slowest and fastest heart rate to look for, beats/min.")
    length_tolerance: float = Field(
        0.1, gt=0, le=1, description="A beat whose length differs by a larger fraction from its neighbors is rejected."
    )
    least_correlation: float = Field(
        0.9, ge=-1, le=1, description="A beat that correlates less with the median beat is rejected."
    )
    reject_ventilation: bool = Field(True, description="Whether beats off the end-expiratory level are rejected.")
    correct_delay: bool = Field(False, description="Whether the flow is advanced by the estimated p-q delay.")


class Calibration(Section):
    """The fit of each wall law to each recording."""

    walls: list[Literal["linear", "tangent"]] = Field(
        ["linear", "tangent"], min_length=1, description="Wall laws to fit."
    )
    starts: int = Field(
        20, ge=1, le=1000, description="Starts of each fit. The paper's 4 miss the best optimum one time in three."
    )
    method: Literal["least-squares", "sqp"] = Field(
        "least-squares", description="least-squares (bounded, trust region), or sqp as in the paper."
    )
    paper_bounds: bool = Field(False, description="The paper's bounds instead of wide ones.")
    bounds: dict[Parameter, Range] = Field(
        {},
        description="Own bounds of single parameters, [lower, upper]. beta and p1 in mmHg; gamma, r1, r2, c1 have no "
        "unit. p1 is that of eq. 4; the published table lists π p1.",
        examples=[{"beta": [10, 400], "c1": [0.05, 5]}],
    )
    fixed: dict[Parameter, Positive] = Field(
        {}, description="Parameters held at a value, in the same units.", examples=[{"gamma": 2}]
    )
    seed: int = Field(0, ge=0, description="Seed of everything random; the same seed gives the same result.")

    @field_validator("walls")
    @classmethod
    def _different(cls, value: list[str]) -> list[str]:
        if len(set(value)) < len(value):
            raise ValueError("each wall law is fitted once; remove the repetition")
        return value


class BloodSection(Section):
    """Blood and its friction at the wall."""

    density: float = Field(1.057, gt=0, description="Density ρ, g/ml.")
    viscosity: float = Field(0.0462, gt=0, description="Kinematic viscosity ν, cm²/s.")
    friction: Literal["boundary-layer", "poiseuille", "power-law"] = Field(
        "boundary-layer", description="Friction law: boundary-layer (eq. 2), poiseuille or power-law."
    )
    reference_radius: float | None = Field(
        None,
        gt=0,
        description="For boundary-layer: this radius (cm) in every vessel instead of the local one; the paper's own "
        "fits used 0.07.",
    )
    exponent: float = Field(9.0, gt=0, description="For power-law: exponent of the velocity profile.")

    @model_validator(mode="after")
    def _belongs(self) -> "BloodSection":
        if self.reference_radius is not None and self.friction != "boundary-layer":
            raise ValueError(f"reference_radius belongs to friction 'boundary-layer', not to '{self.friction}'")
        return self


class NumericsSection(Section):
    """How finely the model is simulated."""

    cell_size: float = Field(0.1, gt=0, description="Longest cell, cm.")
    tolerance: float = Field(
        1e-7, gt=0, description="Largest change from cycle to cycle that counts as periodic, mmHg."
    )
    most_cycles: int = Field(60, ge=2, description="Cycles after which a state that is not periodic is an error.")
    cycles_from_rest: int | None = Field(
        None, ge=1, description="Exactly this many cycles from rest, periodic or not (the paper's practice: 8)."
    )


class ReportSection(Section):
    """The report."""

    pdf: bool = Field(True, description="Whether the page is also written as PDF.")


class StudyFile(Section):
    """Everything that ``study.yaml`` says."""

    title: str = Field("Pulmonary arteries of two groups", min_length=1, description="Title of the report.")
    animals: str = Field("animals.csv", min_length=1, description="The table of animals, beside this file.")
    species: Literal["mouse", "rat", "other"] = Field(
        "mouse", description="Whose physiology `check` compares with: mouse, rat or other (no comparison)."
    )
    groups: list[Annotated[str, Field(min_length=1)]] = Field(
        ["CTL", "HPH"], min_length=1, description="Group labels in the order of tables; the first is the reference."
    )
    averaging: Averaging = Averaging()
    calibration: Calibration = Calibration()
    model_selection: bool = Field(True, description="Whether the wall laws are compared by AICc and BIC.")
    selection_optima: list[Literal["OLS", "GLS"]] = Field(
        ["OLS"],
        min_length=1,
        description="Where they are compared: at the optimum of ordinary least squares, of generalized least squares "
        "under the same noise model (about a minute an animal), or both.",
    )
    blood: BloodSection = BloodSection()
    numerics: NumericsSection = NumericsSection()
    report: ReportSection = ReportSection()

    @field_validator("groups")
    @classmethod
    def _distinct(cls, value: list[str]) -> list[str]:
        twice = next((label for label in value if value.count(label) > 1), None)
        if twice is not None:
            raise ValueError(f"group '{twice}' is listed twice; keep one")
        return value
