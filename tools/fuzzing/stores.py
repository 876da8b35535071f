"""What this program writes and reads again: a form for every store of `vasowave.base.stores`."""

import json
import pkgutil
from dataclasses import asdict
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

import vasowave
from fuzzing import studies, vessels
from fuzzing.forms import Form
from fuzzing.mutations import mutate_binary, mutate_text
from vasowave.base import STORES, InputError
from vasowave.base.runtime import digest_of
from vasowave.catheter.beats import BeatEdit, edits_text, read_edits
from vasowave.lung import Line
from vasowave.lung.kept import read_value, write_value
from vasowave.pulse.calibration import SearchEnd
from vasowave.pulse.inference import ModelEmulator, Simulations, read_simulations
from vasowave.study.animal import read_emulator, read_result, write_emulator
from vasowave.study.cohort import Declaration
from vasowave.study.folder import RESULTS
from vasowave.study.results import Journal, ResultStore, read_journal
from vasowave.study.running import RECORD, STATUS, read_declared, run_status, running
from vasowave.workbench import stored_wishes

END = SearchEnd(np.array([0.1, -1 / 3]), 12.5, 31, True, "the step is below the tolerance", np.linspace(0, 1, 20))
DECLARED = (Declaration("2026-01-02 10:00 UTC", False, {"groups": ["CTL", "HPH"], "law": "linear", "animals": {}}),)
LINE = Line(np.linspace(0, 1, 30).reshape(10, 3), np.full(10, 0.1))
POINTS = np.random.default_rng(0).standard_normal((40, 3))


def _journal(folder: Path) -> None:
    journal = Journal(folder / "key.jsonl")
    for start in range(5):
        journal.searches("linear", 5).keep("scout", start, END)


def _simulations(folder: Path) -> None:
    Simulations(lambda points: 2 * points, folder / "s.npz", "problem")(POINTS)


def _record(folder: Path) -> None:
    content = {"sha256": digest_of(DECLARED), "declared": [asdict(one) for one in DECLARED]}
    (folder / RECORD).write_text(json.dumps(content, indent=1), "utf-8")


def _piece(folder: Path) -> None:
    ResultStore(folder).keep("key", b"key " + bytes(range(256)) * 8)


def _run(folder: Path) -> None:
    with running(folder, 3) as record:
        record.write(stage="computing", done=2, left=1.5)


def _extraction(folder: Path) -> None:
    settings = {"threshold": "100", "cannula": "0.12", "species": "mouse", "loops": "open"}
    (folder / "extraction.json").write_text(json.dumps({"settings": settings}, indent=1), "utf-8")


def _emulator(folder: Path) -> None:
    places = np.random.default_rng(1).uniform(-1, 1, (80, 2))
    box = {"value": [2.0, 2.0], "low": [1.0, 1.0], "high": [4.0, 4.0], "unit": np.array(["mmHg", "1"], object)}
    data = xr.Dataset(
        {name: ("parameter", column) for name, column in box.items()}
        | {"places": (("simulation", "parameter"), places), "learned": ((), 21),
           "answers": (("simulation", "quantity"), places**2)},
        {"parameter": np.array(["beta", "c1"], object), "quantity": np.array(["mPAP", "pPAP"], object)},
        {"title": "emulator of one animal", "source": "a model"},
    )  # fmt: skip
    write_emulator(ModelEmulator(data), folder / "emulator.nc")


def _part(whole: Any, found: Any) -> list[bool]:
    """Return, of lines that are lost one by one, whether those that are believed are lines that were written."""
    return [all(one in whole for one in found)]


def _stage(path: Path) -> Any:
    """Return a stage; whatever cannot be read is made anew (see `Stages`)."""
    try:
        return read_value(path, "key")
    except Exception:
        raise InputError("made anew") from None


def _found(folder: Path) -> bytes:
    """Return a finished piece; a damaged one is made anew."""
    if (path := ResultStore(folder).find("key")) is None:
        raise InputError("made anew")
    return path.read_bytes()


def _form(write: Any, file: str, read: Any, values: Any = lambda found: [found], **more: Any) -> Form:
    mutate = mutate_text if file.endswith(("json", "jsonl", "csv")) else mutate_binary
    return Form(write, more.pop("opened", file), file, mutate, read, lambda found: None, values, **more)


def _lines_of_journal() -> list[Any]:
    from tempfile import TemporaryDirectory

    with TemporaryDirectory() as folder:
        _journal(Path(folder))
        return read_journal(Path(folder) / "key.jsonl")


_FORMS = {
    "index of results": studies.results_form("index.json", True),
    "result of an animal": studies.results_form("animals/m 0-*.nc", False),
    "journal of searches": _form(_journal, "key.jsonl", read_journal, partial(_part, _lines_of_journal()), exact=True),
    "simulations of a posterior": _form(
        _simulations, "s.npz", lambda path: read_simulations(path, "problem"), lambda found: [*found.values()],
        exact=True,
    ),
    "finished piece": _form(
        _piece, "cache/key-*.nc", _found, opened=".", exact=True
    ),
    "stage of an extraction": _form(
        lambda folder: write_value(folder / "a.stage", "key", LINE), "a.stage", _stage,
        lambda found: [found.points, found.radius], exact=True,
    ),
    "record of what was declared": _form(_record, RECORD, read_declared, exact=True),
    "settings of an extraction": _form(_extraction, "extraction.json", stored_wishes),
    "status of a run": _form(
        _run, f"{RESULTS}/{STATUS}", lambda folder: run_status(folder / RESULTS),
        lambda found: [found is None or found.count == 3],
        opened=".", exact=True,
    ),
    "edits of beats": _form(
        lambda folder: (folder / "e.csv").write_text(edits_text([BeatEdit("reject", 1.0), BeatEdit("move", 2.0, 2.1)])),
        "e.csv", read_edits,
    ),
    "emulator of an animal": _form(
        _emulator, "emulator.nc", read_emulator, lambda found: [found.data["answers"].values], exact=True,
    ),
    "edits of a tree": vessels.edits_form(),
}  # fmt: skip


for module in pkgutil.walk_packages(vasowave.__path__, "vasowave."):
    if not module.name.endswith("__main__"):
        import_module(module.name)

FORMS = {name: _FORMS[name] for name in STORES}
"""A form for every store: one that has none is an error here."""


def _alone(folder: Path) -> None:
    studies.results(folder)
    next((folder / "animals").glob("m 0-*.nc")).rename(folder / "r.nc")


ALONE = _form(
    _alone, "r.nc", read_result, lambda found: [found.recording["pressure"].values],
)  # fmt: skip
"""The file of a result without anybody who knows its check sum."""
