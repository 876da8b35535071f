"""Radii belong to the pressure of their image: areas, linear theory, fits and files know it: in a study."""

from dataclasses import replace

import numpy as np
import pytest

from choices import answers_by_image_pressure
from vasowave.base import InputError
from vasowave.catheter.read import read_recording
from vasowave.pulse.calibration import Search
from vasowave.pulse.examples import control_network, virtual_mouse
from vasowave.pulse.network import write_network
from vasowave.study.animal import network_dataset, network_of
from vasowave.study.results import animal_key, load_animal
from vasowave.study.running import read_study

FILLED = 6.3  # mmHg, the paper's


def filled(pressure=FILLED):
    return replace(control_network(), pressure=pressure)


def test_a_stored_animal_keeps_what_was_known_of_its_radii_and_tapers():
    taper = np.linspace(-0.02, 0.02, len(filled()))
    known = {"taper": taper, "taper_sd": np.abs(taper) + 0.01, "radius_sd": 0.1 * filled().radius}
    stored = network_of(network_dataset(replace(filled(), **known)))
    for field, values in known.items():
        assert np.array_equal(getattr(stored, field), values), field
    alone = network_of(network_dataset(replace(filled(), taper=taper)))
    assert np.array_equal(alone.taper, taper)
    assert alone.radius_sd is None


def study_of_one(folder, setting="", cell="", in_file=False):
    folder.mkdir()
    mouse = virtual_mouse()
    write_network(filled() if in_file else control_network(), folder / "n.csv")
    rows = (f"{t:.6f},{p:.6f},{q:.6f}" for t, p, q in zip(mouse.time, mouse.pressure, mouse.flow, strict=True))
    (folder / "r.csv").write_text("\n".join(["time [s],pressure [mmHg],flow [ml/s]", *rows, ""]))
    (folder / "study.yaml").write_text(f"groups: [CTL]\n{setting}")
    head = "animal,group,network,recording,image pressure [mmHg]"
    (folder / "animals.csv").write_text(f"{head}\nm,CTL,n.csv,r.csv,{cell}\n")
    study = read_study(folder)
    row = study.animals[0]
    return load_animal(row, study.settings, folder), animal_key(row, study.settings, folder)


def test_a_study_gives_the_pressure_of_the_image_where_the_network_does_not_say_it(tmp_path):
    unknown, key = study_of_one(tmp_path / "none")
    by_study, other = study_of_one(tmp_path / "study", "image_pressure: 5\n")
    by_row, third = study_of_one(tmp_path / "row", "image_pressure: 5\n", "7.5")
    by_file, _ = study_of_one(tmp_path / "file", "image_pressure: 5\n", "", in_file=True)
    assert [one.network.pressure for one in (unknown, by_study, by_row, by_file)] == [0.0, 5.0, 7.5, FILLED]
    assert len({key, other, third}) == 3  # another pressure asks for new results


def test_a_row_that_contradicts_the_network_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"imaged at 6.3 mmHg, the table of animals says 7.5"):
        study_of_one(tmp_path / "study", "", "7.5", in_file=True)
    with pytest.raises(InputError, match="image_pressure"):
        study_of_one(tmp_path / "wrong", "image_pressure: -3\n")


@pytest.mark.validation
def test_the_wall_question_of_mouse_c6_hangs_on_the_pressure_of_the_image(shared):
    """Numbers of an independent sketch that anchored the laws in another way (its β is that at 6.3 mmHg)."""
    folder = shared / "mouse-c6"
    mouse = read_recording(folder / "pC6_512.dat", folder / "qC6_512.dat", period=0.11)
    search = Search(starts=2, pressure_harmonics=20)
    table = answers_by_image_pressure(filled(), mouse, ("linear", "power"), search=search)
    assert table.loc[(0.0, "linear"), "beta [mmHg]"] == pytest.approx(57.8, rel=0.01)
    assert table.loc[(FILLED, "linear"), "beta [mmHg]"] + FILLED == pytest.approx(48.7, rel=0.01)
    assert table.loc[(FILLED, "linear"), "S [mmHg2]"] == pytest.approx(6.34, rel=0.01)
    assert table.loc[(FILLED, "linear"), "R_T [mmHg s/ml]"] == pytest.approx(72.7, rel=0.01)
    assert table.loc[(0.0, "power"), "m [1]"] == pytest.approx(8.3, rel=0.03)
    assert table.loc[(FILLED, "power"), "m [1]"] == pytest.approx(2.0, rel=0.05)
    assert table.loc[(FILLED, "power"), "S [mmHg2]"] == pytest.approx(5.84, rel=0.01)
