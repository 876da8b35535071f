"""Tables, figures and report of a study, from its stored results alone."""

from pathlib import Path

from vasowave.cohort.primary import Family
from vasowave.report import write_report
from vasowave.study.executors import side_by_side
from vasowave.study.reading import study_path
from vasowave.study.results import read_results

REPORT_FOLDER = "report"


def report_study(study: Path, pdf: bool | None = None, workers: int = 1) -> Path:
    """Write the report of a study that was run and return its page; nothing is simulated, and no recording is read.

    Parameters
    ----------
    study : Path
        The study's folder or file.
    pdf : bool, optional
        Whether the page is also written as PDF; by default as the study file said when the study was run.
    workers : int
        Processes that read results and draw figures. A script that asks for more than one must do so below
        ``if __name__ == "__main__":``.

    Raises
    ------
    InputError
        There are no results, they are damaged, or the report cannot be written.
    """
    folder = study_path(Path(study)).parent
    stored = read_results(folder)
    asked = stored.settings.report
    with side_by_side(workers, len(stored)) as each:
        results = stored.in_order(each)
        return write_report(
            results,
            folder / REPORT_FOLDER,
            failures=stored.failures,
            pdf=asked.pdf if pdf is None else pdf,
            reference=results[0].attrs["group"],
            title=stored.settings.title,
            family=Family(asked.law, asked.quantities),
            each=each,
        )
