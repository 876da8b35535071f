import pandas as pd
import pytest

from approval import approve, parts
from vasowave.catheter import SYNTHETIC_NOTICE, average_beats
from vasowave.catheter.read import read_raw_recording
from vasowave.pulse.examples import published_table
from vasowave.pulse.network_formats import read_network
from vasowave.study.datasets import virtual_cohort, write_virtual_cohort

pytestmark = pytest.mark.filterwarnings("ignore:.*beats between the first and the last averaged were rejected")


@pytest.fixture(scope="module")
def cohort():
    return virtual_cohort(seed=1)


@pytest.fixture(scope="module")
def folder(cohort, tmp_path_factory):
    """Return a folder with the cohort's files."""
    folder = tmp_path_factory.mktemp("cohort")
    write_virtual_cohort(cohort, folder)
    return folder


def test_approved_the_animals_of_a_virtual_cohort(cohort):
    approve("virtual cohort", parts("cohort", [cohort[0], cohort[-1]]), 1e-9)


def test_group_means_of_the_raw_recordings_lie_within_the_published_standard_deviations(cohort):
    measured = pd.DataFrame([{"group": a.group, **average_beats(a.raw).recording.indices()} for a in cohort])
    means = measured.groupby("group").mean()
    published = published_table("hemodynamics").set_index("quantity")
    off = {
        (group, name): (means.loc[group, name] - row[f"{group} mean"]) / row[f"{group} SD"]
        for name, row in published.iterrows()
        for group in ("CTL", "HPH")
    }
    assert len(off) == 14
    assert {key: round(value, 2) for key, value in off.items() if abs(value) > 1} == {}


def test_the_resistance_of_every_animal_is_the_published_one(cohort):
    published = published_table("nominal")["R_T0 [mmHg s/ml]"]
    for animal, resistance in zip(cohort, published, strict=True):
        # what remains is the noise in the mean pressure: its power at harmonic 0, 2.5 SD
        sd = animal.truth["discrepancy"] * 0.5 / animal.truth["CO"]
        assert animal.cycle.vascular_resistance == pytest.approx(resistance, abs=2.5 * sd)


def test_the_same_seed_makes_the_same_animals_and_another_seed_others(cohort):
    again, other = virtual_cohort(seed=1), virtual_cohort(seed=2)
    assert all((a.raw.pressure == b.raw.pressure).all() for a, b in zip(cohort, again, strict=True))
    assert not any((a.raw.pressure == b.raw.pressure).all() for a, b in zip(cohort, other, strict=True))


def test_the_files_read_back_as_the_recordings_they_were_made_from(cohort, folder):
    table = pd.read_csv(folder / "animals.csv", comment="#")
    assert list(table["animal"]) == [animal.name for animal in cohort]
    assert set(table["synthetic"]) == {"yes"}
    for row, animal in zip(table.itertuples(), cohort, strict=True):
        raw = read_raw_recording(folder / row.recording)
        assert raw.sampling_rate == pytest.approx(animal.raw.sampling_rate)
        assert abs(raw.pressure - animal.raw.pressure).max() < 1e-4
        assert abs(raw.flow - animal.raw.flow).max() < 1e-6
        assert abs(raw.ecg - animal.raw.ecg).max() < 1e-4
        network = read_network(folder / row.network)
        assert network.radius == pytest.approx(animal.network.radius)
        assert list(network.parent) == list(animal.network.parent)


def test_every_file_says_that_it_is_synthetic(folder):
    files = [path for path in folder.rglob("*") if path.is_file()]
    assert len(files) == 12 + 2 + 2
    for path in files:
        assert SYNTHETIC_NOTICE in path.read_text(encoding="utf-8")[:1000], path.name


def test_the_truth_stands_with_units_beside_the_files(cohort, folder):
    truth = pd.read_csv(folder / "truth.csv", comment="#").set_index("animal")
    assert truth.loc["HPH 1", "beta [mmHg]"] == 151.3
    assert truth["R_T [mmHg s/ml]"].to_list() == pytest.approx([animal.truth["R_T"] for animal in cohort])
