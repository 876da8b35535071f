"""The choice of the channels of pressure, flow and ECG: by title, or by unit where that leaves one answer."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Generic, NamedTuple, Protocol, TypeVar

from vasowave.base import units
from vasowave.base.cures import UNKNOWN, SetCells
from vasowave.base.errors import InputError, did_you_mean
from vasowave.base.findings import Finding, note_kind
from vasowave.base.sites import PULMONARY, SITES

DIMENSIONS = {"pressure": "pressure", "flow": "flow", "ecg": "voltage", "velocity": "velocity", "volume": "volume"}
"""What is looked for, and the kind of unit that it has."""

_CHANNEL_WORDS = {
    "pressure": ("pressure", "press", "pap", "mpap", "ppa", "p pa", "p"),
    "flow": ("flow", "flow rate", "flowrate", "qpa", "q pa", "q"),
    "ecg": ("ecg", "ekg"),
    "velocity": ("velocity", "vel", "v", "doppler", "u"),
}
VENTRICLE = "ventricle"
"""A site beside the arteries: the only one that has a volume."""

_VENTRICULAR_WORDS = {
    "pressure": ("pressure", "press", "p", "lvp", "rvp", "plv", "prv"),
    "volume": ("volume", "vol", "lvv", "rvv", "vlv", "vrv"),
}
_OF_VENTRICLES = {"lv", "rv", "lvp", "rvp", "plv", "prv", "lvv", "rvv", "vlv", "vrv"}
_PULMONARY_WORDS = ("pa", "mpa", "pap", "mpap", "ppa", "pulm", "pulmonary", "pulmonal")
_OTHER_SITE_WORDS = (*sorted(_OF_VENTRICLES), "ra", "la", "ao", "aop", "aorta", "aortic", "abp",
                     "cvp", "carotid", "femoral", "systemic", "airway", "paw", "ventilator", "trachea",
                     "tracheal", "tidal", "stroke")  # fmt: skip
"""Words of titles that speak of another place than the pulmonary artery; such a channel is read only if it is named."""

_OTHER_SITE_STEMS = ("aort", "arteri", "carot", "karot", "femor", "systemi", "ventri")
"""Beginnings of such words in other languages (Aortendruck), unless a word of the title speaks of the lung (pulm…)."""

_LETTERS = re.compile(r"[^\W\d_]+")
_JOINED = re.compile(r"(?<=pa)(?=flow|pressure)")  # PAflow
_HOW_TO_NAME = "name channels by their titles"
_MAX_OFFERED = 8  # channels that are offered for a quantity


def wanted_titles(
    pressure: str | None, flow: str | None, ecg: str | None = None, velocity: bool = False
) -> dict[str, str | None]:
    """Return the titles by what is looked for, a velocity in place of a flow where that is what was recorded."""
    return {"pressure": pressure, "velocity" if velocity else "flow": flow, "ecg": ecg}


def column_of(name: str) -> str:
    """Return what columns, options and arguments call a signal: title and unit of a velocity are those of the flow."""
    return "flow" if name == "velocity" else name


TAKEN = note_kind("recording.channel-taken", "'{title}' was taken for {name}: {why}")


class Titled(Protocol):
    """Anything with a title and a unit."""

    @property
    def title(self) -> str:
        """As written in the file."""
        ...

    @property
    def unit(self) -> str:
        """As written in the file, empty where none is stated."""
        ...


T = TypeVar("T", bound=Titled)


class Choice(NamedTuple, Generic[T]):
    """The channels that were chosen.

    Attributes
    ----------
    picked : dict of str to channel
        By quantity.
    guessed : dict of str to str
        Why, for every quantity that neither the caller nor one title alone decided.
    problems : tuple of str
        Quantities for which nothing or too much was found.
    lacking : tuple of str
        These quantities.
    """

    picked: dict[str, T]
    guessed: dict[str, str]
    problems: tuple[str, ...]
    lacking: tuple[str, ...]


def choose(channels: Sequence[T], titles: Mapping[str, str | None], site: str = PULMONARY) -> Choice[T]:
    """Return the channel of each quantity: the one named, else the one that says so, else the only one with its unit.

    Of several that say so, the one whose title speaks of the `site` is taken. A missing ECG is no problem.
    `titles` names the channels of ``pressure``, ``flow`` and ``ecg``, or says None.
    """
    picked: dict[str, T] = {}
    guessed: dict[str, str] = {}
    problems: dict[str, str] = {}
    beginnings = {c.title[: c.title.rfind(".") + 1] for c in channels}
    structure = beginnings.pop() if len(beginnings) == 1 else ""  # of MATLAB, whose fields the channels are: Data.p
    strangers = _of_other_animals(channels, [title for title in titles.values() if title])
    for name, title in titles.items():
        named = [text.strip().lower() for text in titles.values() if text is not None]
        free = [c for c in channels if c not in (*picked.values(), *strangers) and c.title.strip().lower() not in named]
        alike = [c for c in free if (whose := owner(c.title)) and whose in map(owner, filter(None, titles.values()))]
        hits, reason = _named(channels, title) if title is not None else _found(alike, name, site, structure)
        hits, reason = (hits, reason) if hits or title is not None else _found(free, name, site, structure)
        if len(hits) > 1 and title is not None:  # one title of channels that differ in unit
            hits = [c for c in hits if _has_unit(c, name)] or hits
        if len(hits) == 1:
            picked[name] = hits[0]
            guessed |= {name: reason} if reason else {}
        elif hits:
            problems[name] = f"{len(hits)} channels may hold {name}, name one of them"
        elif title is not None:
            problems[name] = f"no channel '{title}'{did_you_mean(title, [c.title for c in channels])}"
        elif name != "ecg":
            velocity = _velocity_instead(channels) if name == "flow" else ""
            velocity = ", name it, or give the file that holds it beside this one" if name == "volume" else velocity
            elsewhere = _of_elsewhere(channels, name, site)
            problems[name] = f"no channel says that it holds {name}{elsewhere}{velocity or ', name it'}"
    return Choice(picked, guessed, tuple(problems.values()), tuple(problems))


def pick_channels(
    path: str | Path, channels: Sequence[T], titles: Mapping[str, str | None], site: str = PULMONARY, program: str = ""
) -> tuple[dict[str, T], list[Finding]]:
    """Return what `choose` chooses, and a sentence for each channel that neither the caller nor its title named.

    Raises
    ------
    InputError
        All quantities at once for which no channel or several are found, with the channels there are.
    """
    choice = choose(channels, titles, site)
    if choice.problems:
        of_whom = f"this is {program}, {len(channels)} channels: " if program else ""
        present = ", ".join(f"'{c.title}' [{c.unit or 'no unit'}]" for c in channels) or "none"
        problems = "; ".join(choice.problems)
        raise InputError(f"{path}: {of_whom}{problems}; it has: {present}; {_HOW_TO_NAME}", _offers(channels, choice))
    notes = [TAKEN(title=choice.picked[name].title, name=name, why=reason) for name, reason in choice.guessed.items()]
    return choice.picked, notes


def _offers(channels: Sequence[T], choice: Choice[T]) -> list[SetCells]:
    """Return each channel that may hold what none was found for, as a cure."""
    free = [c for c in channels if c not in choice.picked.values() and c.title.strip()][:_MAX_OFFERED]
    offers = [
        SetCells(f"{name} is '{c.title}'", ((f"{column_of(name)} channel", c.title),))
        for name in choice.lacking
        for c in ([c for c in free if _has_unit(c, name)] or [c for c in free if not units.is_unit(c.unit)])
    ]
    velocity = "flow" in choice.lacking and _velocity_instead(channels)
    diameter = [SetCells("Give the vessel's diameter, mm", (("flow diameter [mm]", UNKNOWN),))] if velocity else []
    names = SetCells("Name the channels", tuple((f"{column_of(name)} channel", UNKNOWN) for name in choice.lacking))
    return [*diameter, names, *offers]


def with_time(names: Sequence[str], column_units: Sequence[str]) -> tuple[str, ...]:
    """Return the names of columns with ``time`` for the only one in a unit of time, where none is called so; of several
    for those that are called t and time, perhaps with a number."""
    if "time" in names:
        return tuple(names)
    timed = [i for i, unit in enumerate(column_units) if units.is_of(unit, "time")]
    if len(timed) > 1:
        timed = [i for i in timed if _plain(names[i]) in ("t", "time")]
    return tuple("time" if i in timed else name for i, name in enumerate(names))


def quantity_of(title: str, site: str = PULMONARY) -> str:
    """Return the quantity that a channel's title says it holds: pressure, flow, ecg, or empty."""
    plain, title_words = _plain(title), _words(title)
    if _is_of_elsewhere(title, site):
        return ""
    channel_words = _VENTRICULAR_WORDS if site == VENTRICLE else _CHANNEL_WORDS
    return next((name for name, words in channel_words.items() if plain in words or title_words & set(words)), "")


def _named(channels: Sequence[T], title: str) -> tuple[list[T], str]:
    """Return the channels with a title, in its case or in any."""
    same = [c for c in channels if c.title.strip() == title.strip()]
    return same or [c for c in channels if c.title.strip().lower() == title.strip().lower()], ""


def _found(free: Sequence[T], name: str, site: str, structure: str) -> tuple[list[T], str]:
    """Return the channels that may hold a quantity, and why, where a title alone did not decide."""
    channel_words = _VENTRICULAR_WORDS if site == VENTRICLE else _CHANNEL_WORDS
    exact = [c for c in free if c.title.removeprefix(structure).strip().lower() in channel_words[name]]
    exact = [c for c in exact if not _is_of_elsewhere(c.title, site)]
    hits = exact or [c for c in free if quantity_of(c.title, site) == name]
    if len(hits) > 1:
        arterial = [c for c in hits if _speaks_of(c.title, site)]
        return (
            (arterial, f"of {len(hits)} channels its title speaks of the {site}") if len(arterial) == 1 else (hits, "")
        )
    if hits:
        return hits, ""
    by_unit = [c for c in free if not quantity_of(c.title, site) and _has_unit(c, name) and c.title.strip()]
    by_unit = [c for c in by_unit if not _is_of_elsewhere(c.title, site)]
    reason = "no other has such a unit" if len(by_unit) == 1 else ""
    return (by_unit if reason or name != "ecg" else []), reason


def _speaks_of(title: str, site: str) -> bool:
    """Whether a title speaks of an artery."""
    words = _words(title)
    if site == VENTRICLE:
        return bool(words & _OF_VENTRICLES) or any(word.startswith("ventri") for word in words)
    if site not in SITES:
        return bool(words & set(_PULMONARY_WORDS))
    return bool(words & set(SITES[site].words)) or any(word.startswith(SITES[site].stems) for word in words)


def _is_of_elsewhere(title: str, site: str = PULMONARY) -> bool:
    """Whether a title speaks of another place than the artery that is looked for."""
    words = _words(title)
    if site in SITES or site == VENTRICLE:
        lung = any(word.startswith("pulm") for word in words) or bool(words & set(_PULMONARY_WORDS))
        return not _speaks_of(title, site) and (lung or _is_of_elsewhere(title))
    stems = any(word.startswith(_OTHER_SITE_STEMS) for word in words) and not any(
        word.startswith("pulm") for word in words
    )
    return stems or bool(words & set(_OTHER_SITE_WORDS))


def _of_elsewhere(channels: Sequence[T], name: str, site: str) -> str:
    """Say which channels have the unit of a quantity and are passed over because their titles speak of other places."""
    passed = [c.title for c in channels if _has_unit(c, name) and _is_of_elsewhere(c.title, site)]
    if not passed:
        return ""
    arteries = [
        artery for artery in (PULMONARY, *SITES) if artery != site and any(_speaks_of(c, artery) for c in passed)
    ]
    option = f"; if it is meant, say that the site is {arteries[0]}" if len(arteries) == 1 and site != VENTRICLE else ""
    titles = " and ".join(f"'{title}'" for title in passed)
    return f" ({titles} may be of another place than the {site}, by its title{option})"


def _velocity_instead(channels: Sequence[Titled]) -> str:
    """Say which channels are velocities, of which a diameter makes a flow."""
    titles = " and ".join(f"'{c.title}'" for c in channels if _has_unit(c, "velocity"))
    return f" ({titles}: a velocity is a flow where the vessel's diameter is given)" if titles else ""


def owner(title: str) -> str:
    """Return the numbered animal that a title speaks of beside its quantity, ``rat 2`` of ``Rat 2 P``; else nothing."""
    quantities = {word for words in _CHANNEL_WORDS.values() for word in words}
    words = [word for word in re.split(r"[\W_]+", title.casefold()) if word and word not in quantities]
    return " ".join(words) if re.search(r"[^\W\d_]", "".join(words)) and re.search(r"\d", "".join(words)) else ""


def _of_other_animals(channels: Sequence[T], named: Sequence[str]) -> list[T]:
    """Return the channels of numbered animals with several of them, where titles of another animal are named."""
    owners = [set(owner(c.title).split()) for c in channels]
    animals = [set(whose.split()) for whose in map(owner, named) if whose]
    return [c for c, words in zip(channels, owners, strict=True) if animals and owners.count(words) > 1
            and not any(words <= animal or words >= animal for animal in animals)]  # fmt: skip


def _plain(title: str) -> str:
    """Return a title in lower case without the numbers that count channels: ``P 1`` is p."""
    return re.sub(r"[\W\d_]+", " ", title).strip().casefold()


def _words(title: str) -> set[str]:
    """Return the words of a title; single letters say too little to be among them."""
    return {word for word in _LETTERS.findall(_JOINED.sub(" ", title.casefold())) if len(word) > 1}


def _has_unit(channel: Titled, name: str) -> bool:
    return units.is_of(channel.unit, DIMENSIONS[name])
