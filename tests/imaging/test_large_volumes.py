"""A volume that is too large to be smoothed at once is smoothed in parts, with the same lumen."""

import numpy as np
import pytest
from made_phantom import phantom

from vasowave.imaging.lumen import segmentation
from vasowave.imaging.lumen.segmentation import Smoothed, segment


@pytest.fixture(scope="module")
def scan():
    return phantom()


def test_parts_are_smoothed_as_the_whole_is_to_the_last_bit(scan, monkeypatch):
    _, volume = scan
    whole = Smoothed(volume, 45.0).whole
    monkeypatch.setattr(segmentation, "LARGE", 17 * volume.grey[0].nbytes)  # 17 of 140 planes at once
    parts = Smoothed(volume, 45.0)
    for low, high in (([0, 0, 0], [140, 140, 140]), ([3, 0, 60], [20, 7, 61]), ([130, 100, 2], [140, 140, 139])):
        part = parts.part(np.array(low), np.array(high))
        np.testing.assert_array_equal(part, whole[tuple(slice(a, b) for a, b in zip(low, high, strict=True))])
    np.testing.assert_array_equal(parts.brighter(45.0), whole > 45.0)
    assert "whole" not in vars(parts)  # nor was it made


def test_the_lumen_of_a_large_volume_is_that_of_the_same_volume_taken_at_once(scan, monkeypatch):
    embedding, volume = scan
    once = segment(volume, 45.0, embedding.cannula[0])
    monkeypatch.setattr(segmentation, "LARGE", 9 * volume.grey[0].nbytes)
    parts = segment(volume, 45.0, embedding.cannula[0])
    np.testing.assert_array_equal(parts.mask, once.mask)
    np.testing.assert_array_equal(parts.grey, once.grey)
    np.testing.assert_array_equal(parts.corner, once.corner)
