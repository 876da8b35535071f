"""openBF's files written by hand: what each key becomes, and which vessel and key each refusal names."""

import numpy as np
import pytest

from vasowave.errors import InputError, VasowaveWarning
from vasowave.exchange import openbf_reading
from vasowave.exchange.openbf import PA, POISSON, LinearTube, _friction_note, _law_note
from vasowave.exchange.openbf_reading import read_openbf

BLOOD = {"rho": 1060.0, "mu": 0.004}
ROOT = {"label": "a", "sn": 1, "tn": 2, "L": 0.01, "E": 4e5, "R0": 1e-3, "h0": 1e-4}
LEFT = ROOT | {"label": "b", "sn": 2, "tn": 3, "L": 0.02, "R0": 8e-4, "R1": 2e8, "R2": 8e8, "Cc": 1e-11}
RIGHT = LEFT | {"label": "c", "tn": 4, "L": 0.03}


def written(tmp_path, vessels=(ROOT, LEFT, RIGHT), blood=BLOOD, rows=None, **more):
    import yaml

    if rows is None:
        rows = "".join(f"{t:.4f} {1e-6 * (1 + np.sin(2 * np.pi * t / 0.64)):.9e}\n" for t in 0.01 * np.arange(65))
    (tmp_path / "in.dat").write_text(rows)
    config = {
        "project_name": "x",
        "inlet_file": "in.dat",
        "blood": blood,
        "solver": {},
        "network": list(vessels),
    } | more
    (tmp_path / "m.yaml").write_text(yaml.safe_dump({key: value for key, value in config.items() if value is not None}))
    return tmp_path / "m.yaml"


def said(path):
    with pytest.raises(InputError) as error:
        read_openbf(path)
    return str(error.value).partition("m.yaml")[2]


def test_every_key_becomes_a_part_of_the_model(tmp_path):
    model, inflow = read_openbf(written(tmp_path))
    assert model.network.length == pytest.approx([1, 2, 3])
    assert model.network.radius == pytest.approx([0.1, 0.08, 0.08])
    assert model.wall.beta == pytest.approx(4e5 * 1e-4 / (POISSON * np.array([1e-3, 8e-4, 8e-4])) / PA)
    assert model.outlets.R1 == pytest.approx(2e8 / (1e6 * PA))
    assert model.outlets.R2 == pytest.approx(8e8 / (1e6 * PA))
    assert model.outlets.C == pytest.approx(1e-11 * 1e6 * PA)
    assert (model.blood.density, model.blood.viscosity) == pytest.approx((1.06, 1e4 * 0.004 / 1060))
    assert model.blood.friction.coefficients(1.0, 1.0)[0] == pytest.approx(2 * np.pi * 4)
    assert inflow.period == pytest.approx(0.64)
    assert inflow.flow.mean() == pytest.approx(1.0)
    assert model.junctions == "static"
    assert PA == pytest.approx(133.322, rel=1e-5)


def test_beds_without_a_second_resistance_are_matched_to_their_vessel(tmp_path):
    beta = 4e5 * 1e-4 / (POISSON * 8e-4)
    Z = np.sqrt(1060 * beta / 2) / (np.pi * 8e-4**2)
    one = {key: value for key, value in LEFT.items() if key != "R2"} | {"R1": 3e9}
    two = RIGHT | {"R1": 1e9, "R2": 3e9, "inlet_impedance_matching": True}
    with pytest.warns(VasowaveWarning, match=r"its Windkessel was given R1 = ρ c0/A0") as heard:
        model, _ = read_openbf(written(tmp_path, (ROOT, one, two)))
    assert len(heard) == 2
    assert model.outlets.R1 == pytest.approx([Z / (1e6 * PA)] * 2)
    assert model.outlets.R2 == pytest.approx([(3e9 - Z) / (1e6 * PA), (4e9 - Z) / (1e6 * PA)])
    assert ", vessel 2 ('b'): its resistance 1e+07 Pa s/m³ lies below its own impedance" in said(
        written(tmp_path, (ROOT, one | {"R1": 1e7}, RIGHT))
    )


def test_keys_that_mean_nothing_are_told_with_what_they_may_have_been(tmp_path):
    with pytest.warns(VasowaveWarning) as heard:
        read_openbf(written(tmp_path, (ROOT, LEFT | {"Ro": 1}, RIGHT | {"Ro": 2}), solvr={}))
    words = [str(one.message) for one in heard]
    assert any("'solvr' means nothing to openBF and was left out (did you mean 'solver'?)" in one for one in words)
    assert any("2 of 3 vessels" in one and "'Ro' means nothing" in one for one in words)


@pytest.mark.parametrize(
    ("vessels", "more", "words"),
    [
        ((), {}, ": 'network' lists no vessel"),
        ((ROOT, 3), {}, ", vessel 2: is not a list of keys and values, as openBF's files have it"),
        ((ROOT | {"L": "x"}, LEFT, RIGHT), {}, ", vessel 1 ('a'): 'L' is 'x', not a number"),
        ((ROOT | {"L": -1.0}, LEFT, RIGHT), {}, ", vessel 1 ('a'): 'L' is -1.0; it must be a number of at least 0"),
        ((ROOT | {"L": [1]}, LEFT, RIGHT), {}, ", vessel 1 ('a'): 'L' is neither a number nor a text"),
        ((ROOT, LEFT | {"tn": 2.5}, RIGHT), {}, ", vessel 2 ('b'): 'tn' is 2.5; nodes are whole numbers"),
        ((ROOT, {k: v for k, v in LEFT.items() if k != "E"}, RIGHT), {}, ", vessel 2 ('b'): no 'E'; openBF needs it"),
        ((ROOT, {k: v for k, v in LEFT.items() if k != "Cc"}, RIGHT), {}, ", vessel 2 ('b'): ends without a"),
        ((ROOT, LEFT, RIGHT | {"Rt": 0.5}), {}, ", vessel 2 ('b'): ends without Rt, where others have it; give all"),
        ((ROOT | {"R0": 0.0}, LEFT, RIGHT), {}, ", vessel 1 ('a'): its radius is zero"),
        ((ROOT | {"Pext": 1e6}, LEFT, RIGHT), {}, ", vessel 1 ('a'): its wall (β 5.33e+04 Pa) collapses under Pext"),
        ((ROOT | {"gamma_profile": -2}, LEFT, RIGHT), {}, ", vessel 1 ('a'): 'gamma_profile' is -2; it must be a"),
        ((ROOT | {"inlet": "P"}, LEFT, RIGHT), {}, ", vessel 1 ('a'): its inlet is 'P', not a flow (Q)"),
        ((ROOT, LEFT, RIGHT), {"blood": None}, ": 'blood' is missing or is no section"),
        ((ROOT, LEFT, RIGHT), {"network": {}}, ": 'network' is missing or is no list"),
        ((ROOT, LEFT, RIGHT), {"network": None}, ": no 'network'; this is no configuration of openBF"),
        ((ROOT, LEFT, RIGHT), {"blood": {"rho": 1060.0}}, ", blood: no 'mu'; openBF needs it"),
    ],
)  # fmt: skip
def test_what_no_model_can_be_made_of_is_refused_with_vessel_and_key(tmp_path, vessels, more, words):
    assert said(written(tmp_path, vessels, **more)).startswith(words)


def test_a_file_that_no_network_is_as_long_as_is_not_read(tmp_path, monkeypatch):
    path = written(tmp_path)
    monkeypatch.setattr(openbf_reading, "_LARGEST", path.stat().st_size)
    read_openbf(path)
    monkeypatch.setattr(openbf_reading, "_LARGEST", path.stat().st_size - 1)
    assert said(path) == ": larger than 0 MB; no file of openBF is"
    path.write_text("a: [")
    assert said(path).startswith(": not YAML (")


def test_notes_of_a_file_say_how_far_it_leaves_the_model():
    assert _law_note(LinearTube(np.ones(2), np.ones(2), np.array([0.0, 9e-7])), ("a", "b")) == (
        "openBF's tube law is the model's own."
    )
    note = _law_note(LinearTube(np.ones(2), np.ones(2), np.array([0.1, 0.256])), ("a", "b"))
    assert note.endswith("their pressures differ by up to 0.26 mmHg (vessel 'b').")
    assert _friction_note(9e-10) == "Friction is the model's."
    assert "to 1.2 %; mu alone" in _friction_note(0.0123)


def test_a_bed_inside_the_tree_and_every_value_that_nothing_takes_are_told(tmp_path):
    bed = {"R1": 2e8, "R2": 8e8, "Cc": 1e-11}
    root = ROOT | bed | {"Rp": 1.1e-3, "inlet": "Q"}
    with pytest.warns(VasowaveWarning) as heard:
        model, _ = read_openbf(written(tmp_path, (root, LEFT | {"inlet_file": "b.dat", "outlet": "wk3"}, RIGHT)))
    words = sorted(str(one.message).partition("m.yaml: ")[2] for one in heard)
    assert words[0].startswith("'Rp' of 'a' is given and not used")
    assert words[1].startswith("'inlet_file' of 'b' is given and not used")
    assert words[2].startswith("a bed is given where other vessels follow (Cc, R1, R2 of 'a'); it is left out")
    assert len(words) == 3
    assert len(model.outlets.R1) == 2  # of the two vessels that end


def test_beds_beside_a_reflection_coefficient_and_more_of_blood_are_told(tmp_path):
    ends = [one | {"Rt": 0.4} for one in (LEFT, RIGHT)]
    with pytest.warns(VasowaveWarning) as heard:
        read_openbf(written(tmp_path, (ROOT, *ends), blood=BLOOD | {"Cp": 3e3}))
    words = {str(one.message).partition("m.yaml: ")[2].split(" is given")[0] for one in heard}
    assert {"'R1' of 'b', 'c'", "'R2' of 'b', 'c'", "'Cc' of 'b', 'c'", "'Cp' of 'blood'"} <= words
