"""The model that a command works on: from network and recording, the folder of a fit, or a file of another program."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vasowave.base.species import SPECIES as SPECIES_RANGES

if TYPE_CHECKING:
    from vasowave.pulse.cycle.cycle import Inflow, Recording
    from vasowave.pulse.model.blood import Blood
    from vasowave.pulse.model.model import Model
    from vasowave.pulse.model.numerics import Numerics
    from vasowave.study.animal.animal import Animal
    from vasowave.study.animal.result import AnimalResult
    from vasowave.study.folder.settings import StudyFile

NETWORK = typer.Argument(
    help="Vessel table (CSV or Excel); or, alone, the folder of a fit or a study: its fitted model; or a file of "
    "openBF or svZeroDSolver."
)
RECORDING = typer.Argument(
    help="One averaged cycle (one file, or pressure and flow) or a continuous recording. Only with a vessel table."
)


def _not_empty(context: typer.Context, option: typer.CallbackParam, value: str) -> str:
    """Refuse an empty name, which would silently mean the default."""
    from vasowave.base.errors import InputError

    source = context.get_parameter_source(str(option.name))
    if source is not None and source.name == "COMMANDLINE" and not value.strip():
        raise InputError(f"--{option.name} is empty; name one (another word lists them), or leave the option out")
    return value


PERIOD = typer.Option(help="Period of the cycle in seconds, for recordings without a time column.")
SPECIES_NAMES = f"{', '.join(SPECIES_RANGES)} or other"
SPECIES = typer.Option(help=f"{SPECIES_NAMES}: at which heart rates beats are looked for.")
ANIMAL = typer.Option(help="Animal of a study.")
WALL = typer.Option(
    help="Wall law by name (another word lists them), or module:Class; of a fit, the first fitted.", callback=_not_empty
)
BED = typer.Option(
    help="Vascular beds by name (another word lists them), or module:Class; of a fit, its own.", callback=_not_empty
)
FRICTION = typer.Option(
    help="boundary-layer (the paper's eq. 2), poiseuille, or power-law; of a fit, its own.", callback=_not_empty
)
CELL = typer.Option(help="Longest cell, cm.")
ACCURACY = typer.Option(help="Largest numerical error of the pressure, mmHg: cells and steps are chosen from it.")
NARROW = typer.Option(
    metavar="VESSEL=SHARE,CM[,STIFFER]",
    help="A stenosis, web or band: share of the vessel's area that is closed, its length, and how many times stiffer "
    "it is (1, or of a suture 20). May be repeated.",
)
TRUST = typer.Option(
    "--trust", help="Allow the programs that the study names (laws of its own) to run: read them first."
)


@dataclass(frozen=True)
class Subject:
    """What a command works on: a network with a recording, the folder of a fit, or a file of openBF, svZeroDSolver."""

    network: Annotated[Path, NETWORK]
    recording: Annotated[list[Path] | None, RECORDING] = None


@dataclass(frozen=True)
class ModelChoice:
    """How the cycle is read, whose it is, and the laws of the model; empty where the default holds."""

    period: Annotated[float | None, PERIOD] = None
    species: Annotated[str, SPECIES] = "mouse"
    animal: Annotated[str, ANIMAL] = ""
    wall: Annotated[str, WALL] = ""
    bed: Annotated[str, BED] = ""


@dataclass(frozen=True)
class Refinement:
    """Narrowings and friction of the model, the numerics, and whether programs of a study may run."""

    narrow: Annotated[list[str] | None, NARROW] = None
    friction: Annotated[str, FRICTION] = ""
    cell_size: Annotated[float | None, CELL] = None
    accuracy: Annotated[float | None, ACCURACY] = None
    trust: Annotated[bool, TRUST] = False


DATA = ".nc"
"""How the name of a netCDF file ends."""
_MODEL_FILES = (".yaml", ".yml", ".json")


def trust_programs(study: Path, trust: bool) -> None:
    """Allow the programs of a study to run, if that was asked for; say which."""
    from vasowave.study.running.programs import trust_study

    for path in trust_study(study) if trust else ():
        typer.echo(f"allowed to run for this study: {path}", err=True)


def model_from(subject: Subject, choice: ModelChoice, friction: str) -> "tuple[Model, Recording | Inflow]":
    """Return the nominal model of a network and a cycle, the fitted one of a folder, or a file's, and what flows in."""
    from vasowave.base.errors import InputError, did_you_mean
    from vasowave.pulse.model.blood import FRICTIONS, Blood

    if friction and friction not in FRICTIONS:
        hint = did_you_mean(friction, FRICTIONS)
        raise InputError(f"unknown friction '{friction}'{hint}; there are: {', '.join(FRICTIONS)}")
    blood = Blood(friction=FRICTIONS[friction]()) if friction else None
    network = subject.network
    if not brings_its_model(network):
        return _nominal(subject, choice, blood or Blood())
    if subject.recording:
        raise InputError(f"{network} brings the flow into it along; leave the recording out")
    if choice.bed:
        raise InputError(f"{network} brings its vascular beds along; leave --bed out")
    wall = choice.wall
    model, flow = _fitted(network, choice.animal, wall) if network.is_dir() else _model_file(network, wall)
    return (model.changed(blood=blood) if blood else model), flow


def brings_its_model(network: Path) -> bool:
    """Whether what was given for a network brings its parameters: a fit's folder, a file of openBF or svZeroDSolver."""
    return network.is_dir() or network.suffix.lower() in _MODEL_FILES


def narrowed_model(model: "Model", narrow: Sequence[str]) -> "Model":
    """Return the model with the narrowings that were typed, see `NARROW`."""
    from vasowave.base.errors import InputError
    from vasowave.pulse.model.losses import narrowed

    for text in narrow:
        vessel, _, numbers = text.rpartition("=")
        try:
            area_lost, length, *stiffer = (float(number) for number in numbers.split(","))
        except ValueError:
            vessel = ""
        if not vessel.strip() or len(stiffer) > 1:
            raise InputError(f"--narrow {text}: write VESSEL=SHARE,CM, for example 2=0.8,0.05")
        try:
            model = narrowed(model, vessel.strip(), area_lost, length, stiffer=stiffer[0] if stiffer else 1.0)
        except InputError as error:
            raise InputError(f"--narrow {text}: {error}") from None
    return model


def numerics_from(refinement: Refinement) -> "Numerics":
    """Return the numerics with the sizes that were typed."""
    from vasowave.pulse.model.numerics import Numerics

    values = {"cell_size": refinement.cell_size, "accuracy": refinement.accuracy}
    return Numerics(**{name: value for name, value in values.items() if value is not None})  # type: ignore[arg-type]


def _fitted(folder: Path, animal: str, wall: str) -> "tuple[Model, Recording | Inflow]":
    from vasowave.study.animal.stored import stored_inflow, stored_model

    result = stored_animal(folder, animal)
    return stored_model(result, wall), stored_inflow(result, wall)


def _model_file(file: Path, wall: str) -> "tuple[Model, Inflow]":
    from vasowave.base.errors import InputError
    from vasowave.study.exchange.openbf_reading import read_openbf
    from vasowave.study.exchange.svzerod_reading import read_svzerod

    if wall not in ("", "linear"):
        raise InputError(f"{file}: its wall is the linear one; leave --wall out")
    return read_svzerod(file) if file.suffix.lower() == ".json" else read_openbf(file)


def _nominal(subject: Subject, choice: ModelChoice, blood: "Blood") -> "tuple[Model, Recording]":
    from vasowave.base.species import known_species
    from vasowave.pulse.model.laws import find_bed, find_law
    from vasowave.pulse.model.model import Model
    from vasowave.pulse.model.nominal import estimate_nominal
    from vasowave.study.folder.settings import StudyFile

    cells = {} if choice.period is None else {"period [s]": repr(choice.period)}
    settings = StudyFile(species=known_species(choice.species))
    animal = animal_from(subject.network, subject.recording or [], cells, settings)
    nominal = estimate_nominal(animal.network, animal.recording, blood, find_bed(choice.bed or "windkessel"))
    law = find_law(choice.wall or "linear")
    model = Model(animal.network, nominal.wall(law), nominal.outlets, blood, nominal.outlet_pressure,
                  outlet_pulsation=nominal.outlet_pulsation)  # fmt: skip
    return model, animal.recording


def animal_from(
    network: Path, recording: Sequence[Path], cells: "Mapping[str, str]", settings: "StudyFile"
) -> "Animal":
    """Return the animal of a network and a recording of any kind, as a study reads it; say what was noticed."""
    from vasowave.base.errors import InputError
    from vasowave.study.folder.names import plain_name
    from vasowave.study.results.loading import load_animal
    from vasowave.study.results.physiology import tell_blood
    from vasowave.study.running.single_animal import one_row

    if not network.exists():
        raise InputError(f"{network}: no such file or folder")
    if not recording:
        raise InputError(f"{network}: a network needs a recording too, whose flow enters it")
    row = one_row(network, recording, plain_name(recording[0].stem), settings.groups[0], cells)
    tell_blood(settings.blood)
    animal = load_animal(row, settings, Path())
    for note in animal.recording.notes:
        typer.echo(f"note: {note}", err=True)
    return animal


def stored_animal(folder: Path, animal: str) -> "AnimalResult":
    """Return the stored result of one animal of a fit or a study."""
    from vasowave.base.errors import InputError
    from vasowave.study.results.results import read_results

    results = read_results(folder)
    if not animal and len(results) > 1:
        raise InputError(f"{folder}: name one of its animals with --animal: {', '.join(results)}")
    name = animal or next(iter(results))
    if name not in list(results):
        raise InputError(f"{folder}: no animal '{name}'; there are: {', '.join(results)}")
    return results[name]
