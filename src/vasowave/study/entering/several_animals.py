"""Animals that were recorded side by side into one file: told by titles of its channels and the name of the file."""

import re
from collections.abc import Mapping, Sequence

from vasowave.base import units
from vasowave.catheter.read.choosing import DIMENSIONS, owner, quantity_of
from vasowave.catheter.read.describe import ChannelDescription
from vasowave.study.entering.animal_sheet import ANIMAL_WORDS
from vasowave.study.entering.grouping import within, words

_NEEDED = ("pressure", "flow")
_NUMBERED = re.compile(rf"(?<![^\W_\d])(?:{'|'.join(ANIMAL_WORDS)})[\W_]*(?:n[or])?[\W_]*(\d+)")


def animals_side_by_side(
    stem: str, channels: Sequence[ChannelDescription], site: str, named: Mapping[str, str]
) -> dict[str, dict[str, str]]:
    """Return the channels of each animal by what they hold; none unless the name of the file tells all animals, or
    every title says the animal and its number.

    ``R05_R06`` with 'PAP R05', 'Flow R05', 'PAP R06' and 'Flow R06' are two animals, and so are 'Rat 1 PAP' and 'Rat 2
    PAP'; 'PAP proximal' and 'PAP distal' in the file of one are not. Those are left out whose channel is not the one
    that a user `named`.
    """
    of_animal: dict[str, dict[str, str]] = {}
    for quantity in (*_NEEDED, "ecg"):
        titles = _titles(channels, quantity, site)
        for title, label in zip(titles, _labels(titles), strict=True):
            if quantity in _NEEDED or label in of_animal:  # one ECG is of all
                of_animal.setdefault(label, {})[quantity] = title
    complete = all(
        {*_NEEDED} <= {*held} and (_says_animal(label) or within(words(label), words(stem)))
        for label, held in of_animal.items()
    )
    if not complete or len(of_animal) < 2:
        return {}
    return {label: held for label, held in of_animal.items()
            if all(held.get(quantity) == title for quantity, title in named.items())}  # fmt: skip


def _titles(channels: Sequence[ChannelDescription], quantity: str, site: str) -> list[str]:
    """Return the titles of the channels of a quantity: those that say it, else those that have its unit."""
    titles = [channel.title for channel in channels if quantity_of(channel.title, site) == quantity]
    return titles or [channel.title for channel in channels if units.is_of(channel.unit, DIMENSIONS[quantity])]


def _says_animal(label: str) -> bool:
    """Whether a word for an animal stands in a label."""
    return bool(set(words(label)) & set(ANIMAL_WORDS))


def _labels(titles: Sequence[str]) -> list[str]:
    """Return whose each title is: the animal that all of them name, or what is left without the words that all of them
    begin and end with."""
    owners = list(map(owner, titles))
    numbers = [match[1] if (match := _NUMBERED.search(whose)) else "" for whose in owners]
    if all(numbers) and len(set(numbers)) == len(titles):  # 'Rat 1 proximal' and 'Rat 1 distal' are one animal
        return owners
    split = [title.split() for title in titles]
    shortest = min(map(len, split), default=0)
    begun = next((i for i in range(shortest) if len({of_title[i] for of_title in split}) > 1), shortest)
    length = shortest - begun
    ended = next((i for i in range(length) if len({of_title[-1 - i] for of_title in split}) > 1), length)
    return [" ".join(of_title[begun : len(of_title) - ended]) for of_title in split]
