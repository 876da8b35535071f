"""What the page shows of findings and errors: sentence, code, and a button for each cure with what it changes."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from vasowave.base.cures import (
    UNKNOWN,
    Cure,
    NameGroups,
    RemoveAnimal,
    SetCells,
    SetOption,
    SetSetting,
    Visit,
    in_row,
)
from vasowave.base.findings import Finding, Severity, sentence

_MAX_BUTTONS = 8  # beside a finding


def as_shown(finding: Finding, animals: Sequence[str] = (), row: Mapping[str, str] | None = None) -> dict[str, Any]:
    """Return a finding about some animals as the page shows it; `row` holds the cells of the first."""
    return {
        "code": finding.code,
        "severity": finding.severity,
        "text": sentence(finding),
        "look": finding.severity is not Severity.NOTE,
        "remedies": buttons(finding.cures, animals, row or {}),
    }


def buttons(cures: Iterable[Cure], animals: Sequence[str] = (), row: Mapping[str, str] | None = None) -> list[Any]:
    """Return the buttons of cures: their labels, what they will change, and the messages to `actions.act`.

    What a person has to add opens the place where that is typed.
    """
    made = (_button(in_row(cure, row or {}), animals, row or {}) for cure in cures)
    return [*filter(None, made)][:_MAX_BUTTONS]


def _button(cure: Cure, animals: Sequence[str], row: Mapping[str, str]) -> dict[str, Any] | None:
    match cure:
        case SetCells(label, cells) if animals and not any(UNKNOWN in text for _, text in cells):
            changes = "; ".join(f"{title}: {row.get(title) or 'empty'} → {text or 'empty'}" for title, text in cells)
            acts: list[Any] = [{"do": "set-cells", "animal": name, "cells": dict(cells)} for name in animals]
            return {"label": label, "changes": f"{', '.join(animals)}: {changes}", "acts": acts}
        case SetCells(label, ((title, _), *_)) if animals:
            return {"label": label, "changes": f"Type '{title}' of {animals[0]}", "open": animals[0], "type": title}
        case SetSetting(label, key, text) if text != UNKNOWN:
            acts = [{"do": "set-setting", "key": key, "value": text}]
            return {"label": label, "changes": f"Setting {key}: {text}", "acts": acts}
        case SetSetting(label, key, _):
            return {"label": label, "changes": f"Type the setting {key}", "type": f"setting {key}"}
        case SetOption(label, name, _):
            return {"label": label, "changes": f"Say {name} on the lung's desk", "desk": "lung"}
        case Visit("recording") if animals:
            return {"label": "Look at the recording", "changes": "Changes nothing", "open": animals[0]}
        case Visit("lung"):
            return {"label": "Look at the lung", "changes": "Changes nothing", "desk": "lung"}
        case RemoveAnimal() if animals:
            acts = [{"do": "remove-animal", "animal": animals[0]}]
            return {"label": f"Remove {animals[0]}", "changes": "Takes its row out; its files stay", "acts": acts}
        case NameGroups(groups) if UNKNOWN not in groups:
            names = list(dict.fromkeys(name.strip() for name in groups.split(",")))
            acts = [{"do": "set-groups", "groups": names}]
            return {"label": f"Add the group {names[-1]}", "changes": f"Groups: {', '.join(names)}", "acts": acts}
        case NameGroups():
            return {"label": "Name the groups", "changes": "Type the groups of the study", "type": "groups"}
    return None
