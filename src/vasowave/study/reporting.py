"""Tables, figures and report of a study, from its stored results alone."""

from pathlib import Path

from vasowave.animal.reading import group_of
from vasowave.cohort.cohort import gathered
from vasowave.cohort.primary import Family
from vasowave.memory import seldom_collected
from vasowave.report.write import write_cohort_report, write_report
from vasowave.study.executors import side_by_side
from vasowave.study.reading import study_path
from vasowave.study.results import read_results

REPORT_FOLDER, ONE_BY_ONE = "report", "report of animals"


def report_study(study: Path, pdf: bool | None = None, workers: int = 1, animal: str = "") -> Path:
    """Write the report of a study that was run and return its page; nothing is simulated, and no recording is read.

    The folder is ``report`` beside the results, or ``report of animals`` with a folder of its own for an animal.

    Parameters
    ----------
    study : Path
        The study's folder or file.
    pdf : bool, optional
        Whether the page is also written as PDF; by default as the study file said when the study was run.
    workers : int
        Processes that read results and draw figures. A script that asks for more than one must do so below
        ``if __name__ == "__main__":``.
    animal : str
        Write the report of this one alone.

    Raises
    ------
    InputError
        There are no results or none of this animal, they are damaged, or the report cannot be written.
    """
    folder = study_path(Path(study)).parent
    stored = read_results(folder)
    asked = stored.settings.report
    pdf = asked.pdf if pdf is None else pdf
    if animal:
        own = folder / ONE_BY_ONE / stored.file_of(animal).stem
        return write_report([stored[animal]], own, pdf=pdf)
    with side_by_side(workers, len(stored)) as each, seldom_collected():
        results = stored.in_order(each, whole=False)
        return write_cohort_report(
            gathered(results, group_of(results[0]), whole=stored.__getitem__, lost=stored.lost),
            folder / REPORT_FOLDER,
            pdf=pdf,
            title=stored.settings.title,
            family=Family(asked.law, asked.quantities),
            each=each,
        )
