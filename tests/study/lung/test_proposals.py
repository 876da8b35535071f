"""The edits that the review page proposes: readable as edits, and an answer to the doubt they stand below."""

from types import SimpleNamespace

import numpy as np
import pytest

from made_tree import forked_tree
from vasowave.base import OTHER
from vasowave.lung.measure import network_of
from vasowave.lung.revise import edited, read_edits
from vasowave.lung.witness import Doubt
from vasowave.study.report import proposals


@pytest.fixture
def tree():
    return forked_tree()


def suggested(tree, *doubts, factor=1.0):
    scaled = tree.times(factor)
    return proposals(SimpleNamespace(tree=scaled, factor=factor, network=network_of(scaled), doubts=doubts))


def taken(edits, tmp_path):
    """Return the proposed edits as a person takes them up: the # before each of them is taken away."""
    lines = [line[2:] if line[2:].split()[0] in ("remove", "merge") else line for line in edits]
    (tmp_path / "edits.txt").write_text("\n".join(lines) + "\n")
    return read_edits(tmp_path / "edits.txt")


@pytest.mark.parametrize("factor", [1.0, 1.02])
def test_a_doubted_end_may_be_removed(tree, tmp_path, factor):
    doubt = Doubt("topology", OTHER(text="the second tree has it not"), ("5",), tree.lines[4].points[-1:])
    found = suggested(tree, doubt, doubt, factor=factor)
    assert len(found.edits) == 2  # the reason and the edit, once
    assert doubt.text in found.edits[0]
    assert len(found.outlets) == 0
    after = edited(tree, taken(found.edits, tmp_path))
    np.testing.assert_array_equal(after.parent, [-1, 0, 0])


def test_a_doubted_inner_vessel_may_be_merged(tree, tmp_path):
    doubt = Doubt("topology", OTHER(text="joins other vessels"), ("2",), tree.lines[1].points[-1:])
    after = edited(tree, taken(suggested(tree, doubt).edits, tmp_path))
    np.testing.assert_array_equal(after.parent, [-1, 0, 0, 0])


def test_an_end_that_the_tree_lacks_is_an_outlet_to_add(tree):
    place = np.array([[0.0, -0.5, 1.6]])
    found = suggested(tree, Doubt("topology", OTHER(text="one more end"), ("3",), place))
    assert found.edits == []
    np.testing.assert_array_equal(found.outlets, place)


def test_a_number_in_doubt_proposes_nothing(tree):
    found = suggested(tree, Doubt("length", OTHER(text="uncertain"), ("2",), tree.lines[1].points[-1:]))
    assert found.edits == []
