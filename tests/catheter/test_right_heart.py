"""The numbers of a right-heart catheter: what follows from them, by hand, and what is refused."""

import pytest

from vasowave.base import InputError
from vasowave.catheter import RightHeart, read_right_heart

ROWS = "systolic,62,mmHg\ndiastolic,24,mmHg\nmean,38,mmHg\nwedge,11,mmHg\nCO,4.6,l/min\nheart rate,78,1/min\n"


def written(folder, text):
    (folder / "n.csv").write_text(text)
    return folder / "n.csv"


def values(numbers):
    return {item.name: item.value for item in numbers.derived()}


def test_what_follows_from_the_numbers_is_as_by_hand(tmp_path):
    (numbers,) = read_right_heart(written(tmp_path, f"quantity,value,unit\n{ROWS}"))
    by_hand = {"PVR in Wood units": 27 / 4.6, "PVR in dynes": 79.9934 * 27 / 4.6, "TPG": 27, "DPG": 13,
               "pulse pressure": 38, "stroke volume": 4600 / 78, "C": 4600 / 78 / 38, "mean flow": 4600 / 60,
               "RC time": 27 / (4600 / 60) * 4600 / 78 / 38}  # fmt: skip
    assert {name: values(numbers)[name] for name in by_hand} == pytest.approx(by_hand, rel=1e-5)


def test_a_row_an_animal_in_other_units_gives_the_same(tmp_path):
    head = "patient,mPAP [kPa],sPAP [mmHg],dPAP [mmHg],PAWP [mmHg],CO [ml/s],HR [bpm]\n"
    table = written(tmp_path, f"{head}A,{38 * 0.133322},62,24,11,{4600 / 60},78\nB,2.0,NA,,-,80,\n")
    first, second = read_right_heart(table)
    (rows,) = read_right_heart(written(tmp_path, f"quantity,value,unit\n{ROWS}"))
    assert values(first) == pytest.approx(values(rows), rel=1e-5)
    assert set(values(second)) == {"mean flow", "R_T"}
    assert "left out: systolic, diastolic, wedge, heart rate" in str(second)
    assert "impedance" in str(second)


def test_german_titles_are_read_and_a_wedge_above_the_diastolic_pressure_is_told(tmp_path):
    (german,) = read_right_heart(
        written(tmp_path, "Tier;Systolisch [mmHg];Diastolisch [mmHg];PAP mittel [mmHg];PCWP [mmHg];HZV [l/min];"
                          "HF [1/min]\nMüller;62;24;38;26;4,6;78\n")
    )  # fmt: skip
    assert (german.name, german.mean, german.heart_rate) == ("Müller", 38, 78)
    assert values(german)["PVR in Wood units"] == pytest.approx(12 / 4.6, rel=1e-5)
    assert "the wedge is above the diastolic pressure" in str(german)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("animal,mean [mmHg],Fluss [l/min]\nA,38,4\n", "no column says cardiac output; it has .*'fluss'"),
        ("quantity,value,unit\nmean,38,mmHg\n", "no cardiac output"),
        ("quantity,value,unit\nmean,38,\nCO,4,l/min\n", "line 2: mean needs its unit"),
        ("quantity,value,unit\nmean,38,l/min\nCO,4,l/min\n", "line 2, mean: 'l/min' is not a unit of pressure"),
        ("quantity,value,unit\nmean,x,mmHg\nCO,4,l/min\n", "line 2, mean: 'x' is not a number"),
        ("quantity,value,unit\nmean,38,mmHg\nmPAP,38,mmHg\nCO,4,l/min\n", "line 3: 'mPAP' stands twice"),
        ("quantity,value,unit\nmaen,38,mmHg\nCO,4,l/min\n", "line 2: 'maen' is not known"),
        ("quantity,value,unit\nmean,38,mmHg\nCO,4,l/min\nheart rate,78,Hz\n", "line 4: heart rate needs its unit"),
        ("quantity,value,unit\nmean,38,mmHg\nCO,inf,l/min\n", "all numbers are finite"),
        ("quantity,value,unit\nmean,-5,mmHg\nCO,4,l/min\n", "the mean is above 0"),
        ("quantity,value,unit\nmean,38,mmHg\nCO,4,l/min\nwedge,40,mmHg\n", "a wedge of 40 mmHg is above the mean"),
    ],
)
def test_what_is_missing_or_contradicts_itself_is_refused_with_its_place(tmp_path, text, words):
    with pytest.raises(InputError, match=words):
        read_right_heart(written(tmp_path, text))


def test_a_mean_above_the_systolic_pressure_is_refused():
    with pytest.raises(InputError, match="does not lie between"):
        RightHeart(mean=38, cardiac_output=70, systolic=30)
