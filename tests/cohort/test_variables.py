"""Columns of a lab's own: their types, and the slips of the pen in them."""

import pytest

from vasowave.cohort import Variable
from vasowave.errors import InputError

ANIMALS = {f"m{i}": "CTL" for i in range(8)}


def column(title, *cells):
    return Variable.of(title, dict(zip(ANIMALS, cells, strict=False)))


def codes(one):
    return [found.code for found in one.slips(ANIMALS)]


def test_a_column_is_of_numbers_of_dates_or_of_words():
    weight = column("weight [g]", "21", "22.5", "", "20", "19", "23", "24", "25")
    assert (weight.kind, weight.name, weight.unit, weight.label) == ("number", "weight", "g", "weight [g]")
    assert weight.values["m1"] == 22.5
    assert "m2" not in weight.values
    born = column("born", "2024-03-01", "2024-02-28", "2024-03-05")
    assert (born.kind, born.numbers) == ("date", {"m0": 2.0, "m1": 0.0, "m2": 6.0})
    assert column("sex", *"fmfmfmfm").kind == "category"
    assert column("week", "10", "2", "2", "10").order == ["2", "10"]
    with pytest.raises(InputError, match="'2O' of m1 is not a number"):
        column("weight", "20", "2O", "21")
    with pytest.raises(InputError, match="is not a number"):
        column("weight [g]", "heavy", "light")


def test_slips_are_seen_and_what_is_none_is_not():
    assert codes(column("sex", *["female"] * 4, *["male"] * 3, "femlae")) == ["variable.misspelt"]
    assert codes(column("sex", *"fffmmmFm")) == ["variable.misspelt"]
    assert codes(column("litter", *["L1"] * 4, *["L2"] * 3, "L3")) == ["variable.one-animal"]
    assert codes(column("species", *["mouse"] * 8)) == ["variable.constant"]
    assert codes(column("weight [g]", "20", "21", "22", "19", "20", "23", "210", "22")) == ["variable.far-off"]
    (far,) = column("weight [g]", "20", "21", "22", "19", "20", "23", "210", "22").slips(ANIMALS)
    assert str(far).endswith("210 in m6 is 9.77 times the median: a slip of the decimal point?")
    assert codes(column("tag", *"abcdefgh")) == []
    assert codes(column("sex", *"fmfmfmfm")) == []
    assert codes(column("dose", "0", "0", "0", "1", "1", "10", "10", "100")) == []
    assert codes(column("sex", *"fmfmfmf")) == ["variable.gaps"]
