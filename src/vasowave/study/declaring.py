"""The study's record of what it declared to compare, with times: written when it is first found in order, or run."""

import json
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from vasowave.cohort.declared import Declaration
from vasowave.errors import InputError
from vasowave.io.files import write_file
from vasowave.io.textfile import read_bytes
from vasowave.study.plan import Study

RECORD = "declared.json"


def declare(study: Study) -> tuple[Declaration, ...]:
    """Write what a study declares into its record if that is new, and return all that it ever declared.

    Raises
    ------
    InputError
        The record is damaged, or cannot be written.
    """
    path = study.folder / RECORD
    before = read_declared(path)
    content = _content(study)
    if before and before[-1].content == content:
        return before
    now = datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")
    after = (*before, Declaration(now, (study.results / "index.json").is_file(), content))
    write_file(path, json.dumps([asdict(one) for one in after], indent=1, ensure_ascii=False) + "\n")
    return after


def _content(study: Study) -> dict[str, Any]:
    settings = study.settings
    said = {
        "groups": settings.groups,
        "quantities": settings.report.quantities,
        "law": settings.report.law or settings.calibration.walls[0],
        "design": asdict(settings.design),
        "animals": _animals(study),
        "reference": {one.name: one.order[0] for one in study.variables if one.name == settings.design.second},
    }
    plain: dict[str, Any] = json.loads(json.dumps(said))
    return plain


def _animals(study: Study) -> dict[str, dict[str, str]]:
    """Return of every animal its group and its cells of the design's columns, an empty text for an empty cell."""
    columns = [one for one in study.variables if one.name in study.settings.design.terms]
    return {
        row.animal: {"group": row.group} | {one.name: one.levels.get(row.animal, "") for one in columns}
        for row in study.animals
    }


def read_declared(path: Path) -> tuple[Declaration, ...]:
    """Return what a record holds; nothing where there is none.

    Raises
    ------
    InputError
        It is damaged.
    """
    if not path.is_file():
        return ()
    try:
        return tuple(Declaration(**one) for one in json.loads(read_bytes(path)))
    except (ValueError, TypeError) as error:
        raise InputError(f"{path}: damaged ({error}); put back what it was, or remove it to declare anew") from None
