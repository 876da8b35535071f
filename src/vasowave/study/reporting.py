"""Tables, figures and report of a study, from its results file alone."""

from pathlib import Path

from vasowave.report import write_report
from vasowave.study.outcome import read_outcome
from vasowave.study.plan import RESULTS
from vasowave.study.reading import study_path

REPORT_FOLDER = "report"


def report_study(study: Path, pdf: bool | None = None) -> Path:
    """Write the report of a study that was run and return its page; nothing is simulated, and no recording is read.

    Parameters
    ----------
    study : Path
        The study's folder or file.
    pdf : bool, optional
        Whether the page is also written as PDF; by default as the study file said when the study was run.

    Raises
    ------
    InputError
        There is no results file, it is damaged, or the report cannot be written.
    """
    folder = study_path(Path(study)).parent
    outcome = read_outcome(folder / RESULTS)
    groups = outcome.settings.groups
    trees = sorted(outcome.trees.values(), key=lambda tree: groups.index(tree.attrs["group"]))
    present = [label for label in groups if any(tree.attrs["group"] == label for tree in trees)]
    return write_report(
        trees,
        folder / REPORT_FOLDER,
        failures=outcome.failures,
        pdf=outcome.settings.report.pdf if pdf is None else pdf,
        reference=present[0],
        title=outcome.settings.title,
    )
