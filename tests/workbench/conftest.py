"""A study of six animals with continuous recordings, and a workbench over it."""

import shutil
import warnings
from concurrent.futures import ThreadPoolExecutor
from urllib.parse import urlsplit

import numpy as np
import pytest
from served import served

import vasowave as vw
from driven import driven
from lab_files import SMALL, exported, recorded
from vasowave.lung.read import Volume
from vasowave.pulse.network import write_network
from vasowave.study.entering import add_files, new_study


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


@pytest.fixture(scope="session")
def scan():
    """A vessel of 0.09 cm that divides into two."""
    z, y, x = np.indices((90, 60, 30)) * 0.002  # cm
    side = np.where(z < 0.09, 0.0, 0.5 * (z - 0.09))
    axis = np.minimum(np.abs(y - 0.06 - side), np.abs(y - 0.06 + side))
    grey = 200.0 * ((np.hypot(axis, x - 0.03) < 0.011) & (z < 0.17))
    return Volume(grey, (0.002,) * 3, (0, 0, 0))


@pytest.fixture
def started(monkeypatch, tmp_path):
    """The addresses that a browser was started with."""
    found = []
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.setattr("webbrowser.open", found.append)
    return found


TREE = vw.Network(("2", "3", "1"), [2, 2, -1], [0.45, 0.37, 0.41], [0.026, 0.037, 0.047])
"""The tree of three vessels, whose root is not the first of its rows."""

RING = vw.Network(
    tuple("abcdef"), None, [0.41, 0.45, 0.4, 0.37, 0.3, 0.2], [0.047, 0.03, 0.033, 0.028, 0.026, 0.02],
    nodes=[[0, 1], [1, 2], [1, 3], [2, 4], [3, 5], [2, 3]],
)  # fmt: skip
"""Two branches, and a vessel across them."""


@pytest.fixture(scope="session")
def kept_results(made_once):
    """A study of three animals that was run; the vessels of one join again."""
    return made_once("ran", run_three)


def run_three(folder):
    (folder / "recordings").mkdir(parents=True)
    lines = ["animal,group,network,recording,synthetic"]
    for i, (group, network) in enumerate((("CTL", TREE), ("CTL", RING), ("HPH", TREE))):
        write_network(network, folder / f"net{i % 2}.csv")
        mouse = vw.virtual_mouse(seed=i)
        titles, rows = "time [s],pressure [mmHg],flow [ml/s]", zip(mouse.time, mouse.pressure, mouse.flow, strict=True)
        text = "\n".join([titles, *(f"{t:.6f},{p + 3 * i:.6f},{q:.6f}" for t, p, q in rows), ""])
        (folder / "recordings" / f"{i}.csv").write_text(text, encoding="utf-8")
        lines.append(f"{group} {i},{group},net{i % 2}.csv,recordings/{i}.csv,yes")
    (folder / "animals.csv").write_text("\n".join([*lines, ""]), encoding="utf-8")
    (folder / "study.yaml").write_text(
        "groups: [CTL, HPH]\ncalibration: {walls: [linear, tangent], starts: 1}\n", encoding="utf-8"
    )
    with warnings.catch_warnings(), ThreadPoolExecutor(1) as here:
        warnings.simplefilter("ignore")
        vw.run_study(vw.read_study(folder / "study.yaml"), executor=here)


@pytest.fixture
def ran(kept_results, tmp_path):
    """A study with results that is this test's own."""
    return shutil.copytree(kept_results, tmp_path / "ran")


@pytest.fixture(scope="session")
def program(tmp_path_factory):
    """A browser that has asked no other address than this machine's by the end."""
    with driven(tmp_path_factory.mktemp("browser")) as one:
        yield one
        asked = {urlsplit(url).hostname for page in one.pages.values() for url in page.requests if "://" in url}
        assert asked <= {"127.0.0.1", None}
