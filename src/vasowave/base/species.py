"""Plausible values of a species: heart rate, pressures, output, decay and the size of its main pulmonary artery."""

from dataclasses import dataclass
from typing import Literal, cast, get_args

from vasowave.base.errors import InputError, did_you_mean

SpeciesName = Literal["mouse", "rat", "rabbit", "dog", "pig", "human", "other"]
"""Species by name; of any other nothing is compared."""

Range = tuple[float, float]


@dataclass(frozen=True)
class Species:
    """Ranges outside of which a value is taken for a slip until somebody has looked; adults, at rest or anesthetized.

    Attributes
    ----------
    heart_rates : (float, float)
        Between which beats are looked for, beats/min: a little more than the species has.
    HR, mPAP, pPAP, CO : (float, float)
        Heart rate, beats/min; mean and pulse pressure of the main pulmonary artery, mmHg; cardiac output, ml/s. Healthy
        animals and those with pulmonary hypertension.
    tau : (float, float)
        Time constant of the pressure's decay, s.
    root_radius : (float, float)
        Of the main pulmonary artery, cm; a diameter in its place is noticed.
    source : str
    """

    heart_rates: Range
    HR: Range
    mPAP: Range
    pPAP: Range
    CO: Range
    tau: Range
    root_radius: Range
    source: str


SPECIES: dict[str, Species] = {
    "mouse": Species(
        (250.0, 900.0), (300.0, 800.0), (7.0, 45.0), (4.0, 50.0), (0.05, 0.45), (0.02, 0.6), (0.02, 0.08),
        "well beyond three SD from the means of Qureshi et al. 2019, table 1, whose radii are 0.047 and 0.051 cm",
    ),
    "rat": Species(
        (150.0, 650.0), (200.0, 550.0), (8.0, 70.0), (5.0, 80.0), (0.4, 4.0), (0.02, 0.6), (0.05, 0.25),
        "textbook values of healthy rats and of rats with hypoxic or monocrotaline hypertension",
    ),
    "rabbit": Species(
        (80.0, 400.0), (110.0, 360.0), (7.0, 50.0), (3.0, 55.0), (1.5, 25.0), (0.03, 1.2), (0.12, 0.6),
        "2 to 5 kg; around the pressures and flows of Caro and McDonald 1961",
    ),
    "dog": Species(
        (30.0, 260.0), (40.0, 240.0), (7.0, 70.0), (4.0, 80.0), (8.0, 180.0), (0.05, 2.5), (0.35, 1.7),
        "5 to 40 kg; around the pressures and flows of Bergel and Milnor 1965",
    ),
    "pig": Species(
        (35.0, 240.0), (45.0, 220.0), (8.0, 75.0), (4.0, 80.0), (10.0, 220.0), (0.05, 2.5), (0.4, 2.0),
        "10 to 90 kg; around the values of conscious pigs of Hannon et al. 1990",
    ),
    "human": Species(
        (30.0, 200.0), (35.0, 180.0), (7.0, 100.0), (4.0, 120.0), (25.0, 300.0), (0.05, 2.5), (0.3, 2.5),
        "mPAP 14.0 ± 3.3 mmHg at rest (Kovacs et al. 2009), up to severe hypertension; a diameter of 2.7 ± 0.3 cm (CT, "
        "Edwards, Bull and Coulden 1998), wider in hypertension; down to lobar arteries, where trees begin, too",
    ),
}  # fmt: skip
"""The ranges of each species; those of rabbits, dogs, pigs and humans are wide, and catch units, not disease."""

ANY_HEART_RATES: Range = (30.0, 900.0)
"""Between which beats of another species are looked for, beats/min."""


def heart_rates_of(species: str) -> Range:
    """Return between which heart rates, beats/min, the beats of a species are looked for."""
    return SPECIES[species].heart_rates if species in SPECIES else ANY_HEART_RATES


def known_species(name: str) -> SpeciesName:
    """Return the name of a species; raises `InputError` where it is none."""
    names = get_args(SpeciesName)
    if name not in names:
        raise InputError(
            f"species '{name}' is not known{did_you_mean(name, names)}; there are: {', '.join(names)} (any that is not "
            "named before it)"
        )
    return cast(SpeciesName, name)
