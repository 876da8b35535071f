"""Columns of a lab's own: their types, and the slips of the pen in them."""

import pytest

from vasowave.base import InputError
from vasowave.study.cohort import Variable

ANIMALS = {f"m{i}": "CTL" for i in range(8)}


def column(title, *cells):
    return Variable.from_cells(title, dict(zip(ANIMALS, cells, strict=False)))


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
    assert column("time", "after", "before").order == ["before", "after"]
    with pytest.raises(InputError, match="'2O' of m1 is not a number"):
        column("weight", "20", "2O", "21")
    with pytest.raises(InputError, match="is not a number"):
        column("weight [g]", "heavy", "light")


def test_slips_are_seen_and_what_is_none_is_not():
    assert codes(column("sex", *["female"] * 4, *["male"] * 3, "femlae")) == ["variable.misspelt"]
    assert codes(column("sex", *"fffmmmFm")) == ["variable.same-word"]
    assert codes(column("sex", *"ffFFmmmm")) == ["variable.same-word"]
    assert codes(column("diet", "high fat", "highfat", "chow", "chow", "high fat", "chow", "chow", "high fat")) == [
        "variable.same-word"
    ]
    assert codes(column("tag", "Süd 1", "Süd1", *"abcdef")) == ["variable.same-word"]
    assert codes(column("litter", *["L1"] * 4, *["L2"] * 3, "L3")) == ["variable.one-animal"]
    for rare, common in (("male", "m"), ("mm", "m"), ("nahc", "nach"), ("f", "female")):
        (one,) = column("word", *[common] * 4, *["other"] * 3, rare).slips(ANIMALS)
        assert str(one).endswith(f"did you mean '{common}'?")
    assert codes(column("species", *["mouse"] * 8)) == ["variable.constant"]
    assert codes(column("weight [g]", "20", "21", "22", "19", "20", "23", "210", "22")) == ["variable.far-off"]
    (far,) = column("weight [g]", "20", "21", "22", "19", "20", "23", "210", "22").slips(ANIMALS)
    assert str(far).endswith("210 in m6 is 9.77 times the median: a slip of the decimal point?")
    assert codes(column("tag", *"abcdefgh")) == []
    assert codes(column("sex", *"fmfmfmfm")) == []
    assert codes(column("dose", "0", "0", "0", "1", "1", "10", "10", "100")) == []
    assert codes(column("sex", *"fmfmfmf")) == ["variable.gaps"]


def test_words_are_counted_by_animals_where_several_rows_are_of_one():
    mouse = {name: f"M{place // 2}" for place, name in enumerate(ANIMALS)}
    sex = column("sex", *"ffffffxx")
    assert codes(sex) == []
    (one,) = sex.slips(ANIMALS, mouse)
    assert (one.code, dict(one.values)) == ("variable.one-animal", {"value": "x", "animal": "M3"})
