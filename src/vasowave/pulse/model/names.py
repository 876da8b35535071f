"""Names of the numbers of a model: one namespace of walls, beds, image, instruments and blood, ours and users'."""

from collections.abc import Iterable, Mapping
from typing import Any, TypeVar

from vasowave.base.errors import InputError, did_you_mean

Value = TypeVar("Value")


class ParameterName(str):
    """Name of a number of a model. Its text is the short one, which commands, settings, tables and files show.

    Attributes
    ----------
    owner : str
        What the number belongs to: ``wall``, ``bed``, ``model``, ``recording``, ``image``, ``probe``, ``calibration``.
    field : str
        Its name there.

    Examples
    --------
    >>> name = ParameterName("wall", "k", "exponential.k")
    >>> str(name), name.full
    ('exponential.k', 'wall.k')
    """

    owner: str
    field: str

    def __new__(cls, owner: str, field: str, text: str = "") -> "ParameterName":
        """Return the name of a field, whose text is `text` or, by default, the field."""
        name = super().__new__(cls, text or field)
        name.owner, name.field = owner, field
        return name

    def __getnewargs__(self) -> tuple[str, str, str]:  # type: ignore[override]
        """Return what makes the same name in another process."""
        return self.owner, self.field, str(self)

    @property
    def full(self) -> str:
        """Owner and field, ``wall.k``: no two numbers of a model share it."""
        return f"{self.owner}.{self.field}"


def joined(*groups: Mapping[Any, Value]) -> dict[Any, Value]:
    """Return the numbers of all groups by their names.

    Raises
    ------
    InputError
        Two numbers have one name.
    """
    numbers: dict[Any, Value] = {}
    for group in groups:
        for name in numbers.keys() & group.keys():
            owners = [getattr(key, "full", key) for table in (numbers, group) for key in table if key == name]
            raise InputError(f"'{name}' is the name of two numbers, {' and '.join(owners)}: rename a field of the law")
        numbers |= group
    return numbers


def resolved(values: Mapping[str, Value], names: Iterable[str], owner: str) -> dict[str, Value]:
    """Return values by the names in `names`, of which each may be written short or in full.

    Raises
    ------
    InputError
        A name that is none of them, or one number twice. `owner` says of what they are: ``the linear wall``.
    """
    names = tuple(names)
    spelled = {getattr(name, "full", name): name for name in names} | {name: name for name in names}
    result: dict[str, Value] = {}
    for name, value in values.items():
        if name not in spelled:
            hint = did_you_mean(name, names)
            raise InputError(f"{owner} has no parameter '{name}'{hint}; it has: {', '.join(names)}")
        if spelled[name] in result:
            raise InputError(f"{spelled[name]} is given twice, short and in full; give it once")
        result[spelled[name]] = value
    return result
