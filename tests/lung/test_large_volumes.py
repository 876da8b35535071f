"""A volume that is too large to be smoothed at once is smoothed in parts, with the same lumen."""

import warnings

import numpy as np
import pytest

from made_phantom import phantom
from vasowave.lung import Options, extract, histogram_of
from vasowave.lung.lumen import Smoothed, levels_of, segment, segmentation
from vasowave.lung.read import Volume


@pytest.fixture(scope="module")
def scan():
    return phantom()


def test_parts_are_smoothed_as_the_whole_is_to_the_last_bit(scan, monkeypatch):
    embedding, volume = scan
    whole, once = Smoothed(volume, 45.0).whole, segment(volume, 45.0, embedding.cannula[0])
    monkeypatch.setattr(segmentation, "LARGE", 17 * 4 * volume.grey[0].size)  # 17 of 140 planes at once
    parts = Smoothed(volume, 45.0)
    for low, high in (([0, 0, 0], [140, 140, 140]), ([3, 0, 60], [20, 7, 61]), ([130, 100, 2], [140, 140, 139])):
        part = parts.part(np.array(low), np.array(high))
        np.testing.assert_array_equal(part, whole[tuple(slice(a, b) for a, b in zip(low, high, strict=True))])
    np.testing.assert_array_equal(parts.brighter(45.0), whole > 45.0)
    assert "whole" not in vars(parts)  # nor was it made
    lumen = segment(volume, 45.0, embedding.cannula[0])
    for name in ("mask", "grey", "corner"):
        np.testing.assert_array_equal(getattr(lumen, name), getattr(once, name))


@pytest.mark.parametrize(
    "kind", [np.uint8, *(pytest.param(one, marks=pytest.mark.validation) for one in (np.int16, np.uint16, ">u2"))]
)
def test_whole_grey_levels_keep_their_type_and_give_the_network_of_decimal_ones(scan, kind):
    """To the last bit, though eight bits overflow where two levels are added and wrap around where one is taken off."""
    embedding, volume = scan
    scale, shift = (1.5, 0.0) if kind is np.uint8 else (50.0, -3000.0 if kind is np.int16 else 0.0)
    levels = np.clip(
        np.round(scale * volume.grey + shift), 0 if kind is not np.int16 else -9000, 255 if kind is np.uint8 else 32000
    )
    options = Options(root=tuple(embedding.cannula[0]), threshold=45.0 * scale + shift)
    few = Volume(levels.astype(kind), volume.spacing, volume.origin)
    assert few.grey.dtype == np.dtype(kind).newbyteorder("=")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        whole = extract(Volume(levels.astype(np.float32), volume.spacing, volume.origin), options)
        found = extract(few, options)
    for name in ("length", "radius", "radius_sd"):
        np.testing.assert_array_equal(getattr(found.network, name), getattr(whole.network, name))
    np.testing.assert_array_equal(found.measured.length_sd, whole.measured.length_sd)
    assert [str(one) for one in found.doubts] == [str(one) for one in whole.doubts]
    assert [str(one) for one in found.notes] == [str(one) for one in whole.notes]
    assert levels_of(few) == levels_of(Volume(levels.astype(np.float32), volume.spacing, volume.origin))
    for one, other in zip(vars(histogram_of(few)).values(), vars(histogram_of(whole.image)).values(), strict=True):
        np.testing.assert_array_equal(one, other)
