"""Where the files of a study stand."""

from pathlib import Path

STUDY_FILE = "study.yaml"
YAML = (".yaml", ".yml")
RESULTS = "results"
"""Folder of the results, beside the study file."""


def study_path(study: Path) -> Path:
    """Return the study file that a folder or a file name means."""
    return study / STUDY_FILE if study.is_dir() else study
