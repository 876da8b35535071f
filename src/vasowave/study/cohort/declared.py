"""What a study said that it would compare, and when: a change after results were there is no plan."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple


class AnimalChanges(NamedTuple):
    """How the animals of a study differ from those that it declared before."""

    added: tuple[str, ...]
    dropped: tuple[str, ...]
    """Names of animals."""
    changed: tuple[tuple[str, str, str, str], ...]
    """Groups and cells of the design's columns that are others; of columns that both declarations have."""


@dataclass(frozen=True)
class Declaration:
    """What a study says at one time of its groups, primary family, law, design and animals."""

    time: str
    """UTC."""
    seen: bool
    """Whether results were there already."""
    content: Mapping[str, Any]
    """Values by name. ``animals`` are, by name, their groups and cells of the design's columns, and ``reference`` the
    level of a second factor that others are compared with; declarations of earlier versions have neither."""

    def changes(self, before: "Declaration") -> list[str]:
        """Return the names of what both say, and this one otherwise than the one before."""
        shared_names = (name for name in before.content if name in self.content)
        changed = [name for name in shared_names if self.content[name] != before.content[name]]
        return [name for name in changed if name != "animals" or any(self.rows(before))]

    def first_said(self, before: "Declaration") -> list[str]:
        """Return the names of what the one before did not speak of."""
        return [name for name in self.content if name not in before.content]

    def rows(self, before: "Declaration") -> AnimalChanges:
        """Return how its animals differ from those of the one before; nothing differs where one names none."""
        old, new = (declaration.content.get("animals") for declaration in (before, self))
        if old is None or new is None:
            return AnimalChanges((), (), ())
        changed = [
            (animal, column, old[animal][column], cell)
            for animal, cells in new.items() if animal in old
            for column, cell in cells.items() if old[animal].get(column, cell) != cell
        ]  # fmt: skip
        added, dropped = ([name for name in first if name not in second] for first, second in ((new, old), (old, new)))
        return AnimalChanges(tuple(added), tuple(dropped), tuple(changed))
