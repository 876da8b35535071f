"""From a row of the table to an animal."""

from small_study import make_study_in

from vasowave.datasets.virtual import virtual_mouse
from vasowave.study.loading import load_animal
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
