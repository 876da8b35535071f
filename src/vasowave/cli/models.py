"""The model that a command works on: from network and recording, the folder of a fit, or a file of another program."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

import vasowave as vw
from vasowave.base import io
from vasowave.base.errors import InputError, did_you_mean
from vasowave.base.species import SPECIES as SPECIES_RANGES
from vasowave.base.species import known_species
from vasowave.pulse import model as laws
from vasowave.study import animal as animals
from vasowave.study import figures, results, running
from vasowave.study import folder as folders

NETWORK = typer.Argument(
    help="Vessel table (CSV or Excel); or, alone, the folder of a fit or a study: its fitted model; or a file of "
    "openBF or svZeroDSolver."
)
RECORDING = typer.Argument(
    help="One averaged cycle (one file, or pressure and flow) or a continuous recording. Only with a vessel table."
)


def _not_empty(context: typer.Context, option: typer.CallbackParam, value: str) -> str:
    """Refuse an empty name, which would silently mean the default."""
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


PICTURES = (".png", ".pdf", ".svg")
"""How the names of pictures end."""
DATA = ".nc"
"""How the name of a netCDF file ends."""
_MODEL_FILES = (".yaml", ".yml", ".json")


def trust_programs(study: Path, trust: bool) -> None:
    """Allow the programs of a study to run, if that was asked for; say which."""
    for path in vw.trust_study(study) if trust else ():
        typer.echo(f"allowed to run for this study: {path}", err=True)


def model_from(subject: Subject, choice: ModelChoice, friction: str) -> "tuple[vw.Model, vw.Recording | vw.Inflow]":
    """Return the nominal model of a network and a cycle, the fitted one of a folder, or a file's, and what flows in."""
    from vasowave.pulse.model.blood import FRICTIONS

    if friction and friction not in FRICTIONS:
        hint = did_you_mean(friction, FRICTIONS)
        raise InputError(f"unknown friction '{friction}'{hint}; there are: {', '.join(FRICTIONS)}")
    blood = vw.Blood(friction=FRICTIONS[friction]()) if friction else None
    network = subject.network
    if not brings_its_model(network):
        return _nominal(subject, choice, blood or vw.Blood())
    if subject.recording:
        raise InputError(f"{network} brings the flow into it along; leave the recording out")
    if choice.bed:
        raise InputError(f"{network} brings its vascular beds along; leave --bed out")
    if network.is_dir():
        result = stored_animal(network, choice.animal)
        model, flow = vw.stored_model(result, choice.wall), animals.stored_inflow(result, choice.wall)
    elif choice.wall not in ("", "linear"):
        raise InputError(f"{network}: its wall is the linear one; leave --wall out")
    else:
        model, flow = vw.read_svzerod(network) if network.suffix.lower() == ".json" else vw.read_openbf(network)
    return (model.changed(blood=blood) if blood else model), flow


def brings_its_model(network: Path) -> bool:
    """Whether what was given for a network brings its parameters: a fit's folder, a file of openBF or svZeroDSolver."""
    return network.is_dir() or network.suffix.lower() in _MODEL_FILES


def narrowed_model(model: "vw.Model", narrow: Sequence[str]) -> "vw.Model":
    """Return the model with the narrowings that were typed, see `NARROW`."""
    for text in narrow:
        vessel, _, numbers = text.rpartition("=")
        try:
            area_lost, length, *stiffer = (float(number) for number in numbers.split(","))
        except ValueError:
            vessel = ""
        if not vessel.strip() or len(stiffer) > 1:
            raise InputError(f"--narrow {text}: write VESSEL=SHARE,CM, for example 2=0.8,0.05")
        try:
            model = vw.narrowed(model, vessel.strip(), area_lost, length, stiffer=stiffer[0] if stiffer else 1.0)
        except InputError as error:
            raise InputError(f"--narrow {text}: {error}") from None
    return model


def numerics_from(refinement: Refinement) -> "vw.Numerics":
    """Return the numerics with the sizes that were typed."""
    values = {"cell_size": refinement.cell_size, "accuracy": refinement.accuracy}
    return vw.Numerics(**{name: value for name, value in values.items() if value is not None})  # type: ignore[arg-type]


def _nominal(subject: Subject, choice: ModelChoice, blood: "vw.Blood") -> "tuple[vw.Model, vw.Recording]":
    cells = {} if choice.period is None else {"period [s]": repr(choice.period)}
    settings = folders.StudyFile(species=known_species(choice.species))
    animal, _ = animal_from(subject.network, subject.recording or [], cells, settings)
    nominal = vw.estimate_nominal(animal.network, animal.recording, blood, laws.find_bed(choice.bed or "windkessel"))
    law = laws.find_law(choice.wall or "linear")
    model = vw.Model(animal.network, nominal.wall(law), nominal.outlets, blood, nominal.outlet_pressure,
                  outlet_pulsation=nominal.outlet_pulsation)  # fmt: skip
    return model, animal.recording


def animal_from(
    network: Path, recording: Sequence[Path], cells: "Mapping[str, str]", settings: "folders.StudyFile"
) -> "tuple[vw.Animal, vw.Settings]":
    """Return the animal of a network and a recording of any kind, as a study reads it, and the settings of its
    analysis; say what was noticed."""
    if not network.exists():
        raise InputError(f"{network}: no such file or folder")
    if not recording:
        raise InputError(f"{network}: a network needs a recording too, whose flow enters it")
    row = running.one_row(network, recording, folders.plain_name(recording[0].stem), settings.groups[0], cells)
    results.tell_blood(settings.blood)
    animal = results.load_animal(row, settings, Path())
    for note in animal.recording.notes:
        typer.echo(f"note: {note}", err=True)
    return animal, folders.animal_settings(settings, row)


def stored_animal(folder: Path, animal: str) -> "vw.AnimalResult":
    """Return the stored result of one animal of a fit or a study."""
    results = vw.read_results(folder)
    if not animal and len(results) > 1:
        raise InputError(f"{folder}: name one of its animals with --animal: {', '.join(results)}")
    name = animal or next(iter(results))
    if name not in list(results):
        raise InputError(f"{folder}: no animal '{name}'; there are: {', '.join(results)}")
    return results[name]


def check_files(*files: tuple[Path | None, *tuple[str, ...]]) -> None:
    """Refuse a file that cannot be written, each by the endings that stand behind it; none was asked for where None."""
    for path, *endings in files:
        if path is not None:
            io.check_file(path, *endings)


def draw(figure: Callable[[], Any], plot: Path) -> Path:
    """Write a picture and return its file."""
    with figures.style():
        return io.write_file(plot, figures.as_file(figure(), plot.suffix.lower()[1:]))
