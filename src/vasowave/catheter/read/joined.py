"""Pressure and flow of one animal in two files, joined on their clocks."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from vasowave.base import units
from vasowave.base.errors import InputError
from vasowave.base.findings import note_kind
from vasowave.catheter.signals.channels import Block, Channel
from vasowave.catheter.signals.raw import MIN_DURATION_S

JOINED = note_kind(
    "recording.joined",
    "{first} and {second} were joined on their clocks: the second begins {offset:.6g} s after the first, and both hold "
    "{lasts:.4g} s",
)
_QUANTITIES = ("pressure", "flow")
_SAME_SAMPLE = 0.01  # of a sampling interval: clocks that differ by less are the same


def joined_blocks(paths: Sequence[Path], blocks: Sequence[Sequence[Block]]) -> list[Block]:
    """Return the longest block of each of two files as one, from when both have begun until one ends.

    Raises
    ------
    InputError
        They share less than a second; each holds pressure and flow, as recordings of two animals do.
    """
    longest = [max(of_file, key=lambda block: block.duration) for of_file in blocks]
    if all(map(_is_whole, longest)):
        raise InputError(f"{paths[0]} and {paths[1]}: both hold pressure and flow; give one recording alone")
    clocks = [block.start or 0.0 for block in longest]
    spans = [(clock, clock + block.duration) for clock, block in zip(clocks, longest, strict=True)]
    start, end = max(first for first, _ in spans), min(last for _, last in spans)
    if not end - start >= MIN_DURATION_S:
        shown = " and ".join(f"{path} from {a:.6g} to {b:.6g} s" for path, (a, b) in zip(paths, spans, strict=True))
        raise InputError(f"the clocks of two files share less than a second: {shown}; give files of one recording")
    channels, titles = list[Channel](), list[str]()
    for path, clock, block in zip(paths, clocks, longest, strict=True):
        for channel in block.channels:
            title = f"{channel.title} ({path.stem})" if channel.title in titles else channel.title
            titles.append(title)
            channels.append(replace(_between(channel, start - clock, end - clock), title=title))
    comments = [
        replace(comment, time=comment.time + clock - start)
        for clock, block in zip(clocks, longest, strict=True)
        for comment in block.comments
    ]
    note = JOINED(first=paths[0].name, second=paths[1].name, offset=clocks[1] - clocks[0], lasts=end - start)
    suspicions = [suspicion for block in longest for suspicion in block.suspicions]
    return [Block(tuple(channels), tuple(comments), (*suspicions, note), longest[0].program, start)]


def _is_whole(block: Block) -> bool:
    """Whether units tell that a block holds pressure and flow."""
    return all(any(units.is_of(channel.unit, quantity) for channel in block.channels) for quantity in _QUANTITIES)


def _between(channel: Channel, start: float, end: float) -> Channel:
    """Return a channel from one time to another, by cubic splines where its samples do not fall on the first."""
    rate = channel.sampling_rate
    place = start * rate
    count = int((end - start) * rate + _SAME_SAMPLE)
    first = round(place)
    if abs(place - first) <= _SAME_SAMPLE or not np.isfinite(channel.values).all():
        return replace(channel, values=channel.values[first : first + count])
    from scipy.interpolate import CubicSpline

    places = place + np.arange(count)
    spline = CubicSpline(np.arange(len(channel.values)), channel.values)
    return replace(channel, values=spline(places[places <= len(channel.values) - 1]))
