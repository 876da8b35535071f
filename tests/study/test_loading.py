"""From a row of the table to an animal."""

from small_study import make_study_in

from vasowave.datasets.virtual import virtual_mouse
from vasowave.study.loading import animal_key, load_animal
from vasowave.study.plan import read_study


def test_a_recording_that_says_it_is_synthetic_is_synthetic_whatever_the_table_says(tmp_path):
    folder = make_study_in(tmp_path / "study", [virtual_mouse()])
    table = folder / "animals.csv"
    table.write_text(table.read_text().replace(",yes", ","))
    study = read_study(folder)
    row = study.animals[0]
    assert not row.synthetic
    assert not load_animal(row, study.settings, folder).synthetic
    recording = row.recordings[0]
    recording.write_text("# SYNTHETIC: made, not measured\n" + recording.read_text())
    assert load_animal(row, study.settings, folder).synthetic


def test_a_law_in_the_folder_of_a_study_is_found_and_a_changed_one_asks_for_new_results(tmp_path):
    law = tmp_path / "law_of_this_study.py"
    law.write_text(
        "from vasowave.model.walls import LinearWall as _Linear\nfrom typing import NamedTuple\n"
        "class Own(NamedTuple):\n    beta: float\n"
        "    law = staticmethod(lambda: _Linear.law()._replace(name='own'))\n"
        "    pressure_at, ratio_at = staticmethod(_Linear.pressure_at), staticmethod(_Linear.ratio_at)\n"
        "    slope_at, limits = staticmethod(_Linear.slope_at), staticmethod(_Linear.limits)\n"
    )
    (tmp_path / "study.yaml").write_text("groups: [CTL]\ncalibration: {walls: ['law_of_this_study:Own']}\n")
    (tmp_path / "animals.csv").write_text("animal,group,network,recording,period [s]\nm,CTL,n.csv,r.csv,0.11\n")
    for name in ("n.csv", "r.csv"):
        (tmp_path / name).write_text("pressure [mmHg],flow [ml/s]\n1,2\n")
    study = read_study(tmp_path)
    before = animal_key(study.animals[0], study.settings, tmp_path)
    law.write_text(law.read_text() + "# changed\n")
    again = read_study(tmp_path)
    assert animal_key(again.animals[0], again.settings, tmp_path) != before
