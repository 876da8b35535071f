"""The files of a study: its settings, its table of animals, its results."""

import re
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from fuzzing.forms import Form
from fuzzing.mutations import mutate_binary, mutate_text
from fuzzing.recordings import cycle_table
from fuzzing.vessels import network_table
from vasowave.base import VasowaveWarning
from vasowave.pulse.examples import control_network
from vasowave.pulse.model import find_law, learn
from vasowave.study.animal import AnimalResult, Measured, to_bytes
from vasowave.study.entering import check_study, study_text
from vasowave.study.folder import Study, StudyFile, refuse
from vasowave.study.results import Results, ResultStore, read_results, write_results
from vasowave.study.running import inspect_study, programs_of


def study(folder: Path) -> None:
    network_table(folder / "n.csv")
    rows = ["animal,group,network,recording,period [s],tau [s]"]
    for i in range(4):
        cycle_table(folder / f"{i}.csv")
        rows.append(f"mouse {i},{'CTL' if i < 2 else 'HPH'},n.csv,{i}.csv,0.11,0.2")
    (folder / "animals.csv").write_text("\n".join(rows) + "\n", "utf-8")
    (folder / "study.yaml").write_text(study_text(), "utf-8")


def read(folder: Path) -> Study:
    """Return the study; what is odd is a warning, what is wrong an error."""
    found, problems = inspect_study(folder)
    refuse(problems)
    for problem in problems:
        warnings.warn(str(problem), VasowaveWarning, stacklevel=1)
    assert found is not None
    return found


_WALLS = (Path(__file__).parents[2] / "docs" / "walls.md").read_text(encoding="utf-8")
LAW = next(text for text in re.findall(r"```python\n(.*?)```", _WALLS, re.DOTALL) if "class " in text)


def study_with_a_law(folder: Path) -> None:
    """Write a study of one animal that names a law of its own."""
    study(folder)
    rows = (folder / "animals.csv").read_text().splitlines()
    (folder / "animals.csv").write_text("\n".join(rows[:2]) + "\n", "utf-8")
    text = "groups: [CTL]\nmodel_selection: false\ncalibration: {walls: ['our_laws:ExponentialWall'], starts: 1}\n"
    (folder / "study.yaml").write_text(text, "utf-8")
    (folder / "our_laws.py").write_text(LAW, "utf-8")


def checked_law(folder: Path) -> Any:
    """Return the law of a study that `check` finds nothing wrong with; its program, a mutant of ours, may run here."""
    learn(programs_of(folder))
    found = check_study(folder)
    refuse([problem for problem in found.problems if problem.error])
    assert found.settings is not None
    return find_law(found.settings.calibration.walls[0])


def _rows(found: Study) -> list[Any]:
    return [(row.animal, row.group, row.recordings, row.network, row.period, row.tau) for row in found.animals]


def results(folder: Path) -> None:
    import xarray as xr

    store, pieces = ResultStore(folder), {}
    for i in range(3):
        data = xr.Dataset({"pressure": ("time", np.sin(np.arange(64.0) + i)), "name": ("wall", np.array(["a", "b"]))})
        nothing = xr.Dataset()
        measured = Measured(waves=nothing, impedance=nothing, quantities=nothing)
        result = AnimalResult(
            name=f"m {i}", group="CTL", network=control_network(), recording=data, nominal=nothing, measured=measured
        )
        pieces[(f"m {i}", "CTL")] = store.keep(f"k{i}", to_bytes(result.to_datatree()))
    write_results(folder, pieces, {}, StudyFile(groups=["CTL"]))
    first = next((folder / "animals").glob("m 0-*.nc"))
    content = first.read_bytes()
    first.unlink()  # it is linked with the piece of the store
    first.write_bytes(content)


def _stored(folder: Path) -> tuple[Results, list[Any]]:
    stored = read_results(folder)
    return stored, stored.in_order()


def results_form(damaged: str, text: bool) -> Form:
    return Form(
        results, ".", damaged, mutate_text if text else mutate_binary, _stored,
        lambda pair: (pair[0].animals, pair[0].settings, pair[0].failures),
        lambda pair: [result.recording["pressure"].values for result in pair[1]], text=text,
        exact=True,
    )  # fmt: skip


FORMS = {
    "study.yaml": Form(
        study, ".", "study.yaml", mutate_text, read, lambda found: len(found.animals), lambda found: [found.settings],
        text=True,
    ),
    "law file": Form(  # a program: what it says is not to be doubted, as long as its equations agree
        study_with_a_law, ".", "our_laws.py", mutate_text, checked_law,
        lambda law: law._fields, lambda law: [law.law(), law.ratio_at(np.linspace(0, 30, 7), 10.0, 2.0)],
    ),
    "animals.csv": Form(  # like a list of edits it cannot know that a row is missing; `check` tells what it read
        study, ".", "animals.csv", mutate_text, read,
        lambda found: sorted(row.group for row in found.animals), lambda found: [_rows(found)],
    ),
}  # fmt: skip
