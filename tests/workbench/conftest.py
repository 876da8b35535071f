"""A study of six animals with continuous recordings, and a workbench over it."""

import shutil

import pytest
from served import served

from lab_files import SMALL, exported, recorded
from vasowave.network.vessel_table import write_network
from vasowave.study.adding import add_files
from vasowave.study.template import new_study


@pytest.fixture(scope="session")
def lab(tmp_path_factory):
    """A folder as a lab has it: two groups of three continuous recordings, and a network."""
    folder = tmp_path_factory.mktemp("lab") / "lab"
    for group, mean in (("control", 14.0), ("hypoxic", 24.0)):
        (folder / group).mkdir(parents=True)
        for i in range(3):
            text = exported(recorded(i + (10 if group == "hypoxic" else 0), mean=mean + i))
            (folder / group / f"mouse_{group[0]}{i + 1}.txt").write_text(text, encoding="utf-8")
    write_network(SMALL, folder / "lung.csv")
    return folder


@pytest.fixture(scope="session")
def kept_study(lab, tmp_path_factory):
    folder = tmp_path_factory.mktemp("kept") / "study"
    new_study(folder)
    shutil.copytree(lab, folder / "recordings", dirs_exist_ok=True)
    (folder / "recordings" / "lung.csv").rename(folder / "networks" / "lung.csv")
    add_files(folder, [folder / "recordings", folder / "networks"])
    text = (folder / "study.yaml").read_text(encoding="utf-8")
    text = text.replace("  walls: [linear, tangent]", "  walls: [linear]").replace("  starts: 20", "  starts: 1")
    text = text.replace("model_selection: true", "model_selection: false").replace("  pdf: true", "  pdf: false")
    (folder / "study.yaml").write_text(text, encoding="utf-8")
    return folder


@pytest.fixture
def study(kept_study, tmp_path):
    """A study of six animals that is this test's own."""
    return shutil.copytree(kept_study, tmp_path / "study")


@pytest.fixture
def asker(study):
    with served(study) as one:
        yield one
