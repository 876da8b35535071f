"""What a study said that it would compare, and when: a change after results were there is no plan."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Declaration:
    """What a study says at one time of its groups, primary family, law and design.

    Attributes
    ----------
    time : str
        UTC.
    seen : bool
        Whether results were there already.
    content : dict
        Values by name.
    """

    time: str
    seen: bool
    content: Mapping[str, Any]

    def changes(self, before: "Declaration") -> list[str]:
        """Return the names of what it says otherwise than the one before."""
        names = dict.fromkeys([*before.content, *self.content])
        return [name for name in names if self.content.get(name) != before.content.get(name)]
