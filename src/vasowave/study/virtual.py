"""The virtual cohort as a study that can be run: what `vasowave demo` does, and a model for one's own."""

from pathlib import Path

from vasowave.datasets.virtual_cohort import virtual_cohort
from vasowave.datasets.virtual_files import SYNTHETIC, write_virtual_cohort
from vasowave.errors import InputError
from vasowave.io.files import write_file
from vasowave.study.reading import STUDY_FILE
from vasowave.study.template import SCHEMA_FILE, schema_text

_MARK = "truth.csv"  # a lab never has this file


def write_virtual_study(folder: Path, starts: int = 4, seed: int = 1) -> Path:
    """Write the files of twelve virtual mice and a study file that fits each of them from `starts` starts.

    Returns
    -------
    Path
        The study file. The same arguments write the same bytes, so a study that was interrupted goes on.

    Raises
    ------
    InputError
        The folder holds something else, or cannot be written.
    """
    folder = Path(folder)
    if folder.is_file():
        raise InputError(f"{folder} is a file; give the name of a folder")
    if folder.exists() and any(folder.iterdir()) and not (folder / _MARK).exists():
        raise InputError(f"{folder} is not empty and not the study of virtual mice; give another folder")
    write_virtual_cohort(virtual_cohort(seed), folder)
    study = folder / STUDY_FILE
    write_file(
        study,
        f"# yaml-language-server: $schema={SCHEMA_FILE}\n"
        f"# {SYNTHETIC}\n"
        "title: Virtual cohort of 7 + 5 mice (SYNTHETIC)\n"
        "calibration:\n"
        f"  starts: {starts}\n",
    )
    write_file(folder / SCHEMA_FILE, schema_text())
    return study
