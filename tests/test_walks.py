"""The walks that CONTRIBUTING.md draws are those of the running program: modules by the order of their first call."""

import re
import sys
from pathlib import Path

import pytest

import vasowave as vw
from lab_files import exported, recorded
from vasowave.pulse.network import write_network
from vasowave.study.running import read_study, report_study, run_alone, running

SOURCE = Path(vw.__file__).parent
DRAWN = dict(
    re.findall(
        r"^\| (LabChart file to beats|study to results|results to page) \| (.+) \|$",
        (Path(__file__).parents[1] / "CONTRIBUTING.md").read_text(encoding="utf-8"),
        re.MULTILINE,
    )
)
SETTINGS = """groups: [CTL]
calibration: {walls: [linear], starts: 1}
numerics: {cell_size: 0.3}
model_selection: false
report: {pdf: false}
"""


def called(act):
    """Return the modules whose functions `act` calls, in the order of their first call."""
    codes = {}

    def look(frame, event, arg):
        if event == "call":
            codes[frame.f_code] = None

    before = sys.getprofile()
    sys.setprofile(look)
    try:
        act()
    finally:
        sys.setprofile(before)
    files = [Path(one.co_filename) for one in codes if one.co_name != "<module>"]
    ours = [file.relative_to(SOURCE) for file in files if file.is_relative_to(SOURCE)]
    return list(dict.fromkeys(file.with_suffix("").as_posix() for file in ours))


def drawn(walk):
    return re.findall(r"`([a-z_/]+)`", DRAWN[walk])


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    folder = tmp_path_factory.mktemp("walks")
    mouse = vw.virtual_mouse()
    rows = (f"{t:.6f},{p:.6f},{q:.6f}" for t, p, q in zip(mouse.time, mouse.pressure, mouse.flow, strict=True))
    (folder / "cycle.csv").write_text("\n".join(["time [s],pressure [mmHg],flow [ml/s]", *rows, ""]), "utf-8")
    write_network(vw.Network(("1", "2", "3"), [-1, 0, 0], [0.41, 0.45, 0.37], [0.047, 0.026, 0.037]), folder / "n.csv")
    (folder / "animals.csv").write_text("animal,group,network,recording\nA,CTL,n.csv,cycle.csv\n", "utf-8")
    (folder / "study.yaml").write_text(SETTINGS, "utf-8")
    return folder


@pytest.mark.validation
def test_from_a_labchart_file_to_beats(tmp_path):
    path = tmp_path / "mouse.txt"
    path.write_text(exported(recorded(3, 15.0, 0.0)), "utf-8")
    modules = called(lambda: vw.average_beats(vw.read_raw_recording(path), 10))
    steps = drawn("LabChart file to beats")
    assert [one for one in modules if one in steps] == steps


@pytest.mark.validation
def test_from_a_study_to_its_results_and_to_its_page(study):
    with running(study) as run:
        modules = called(lambda: run_alone(run, read_study(study)))
    steps = drawn("study to results")
    assert [one for one in modules if one in steps] == steps
    modules = called(lambda: report_study(study))
    steps = drawn("results to page")
    assert [one for one in modules if one in steps] == steps


@pytest.mark.parametrize("page", sorted(SOURCE.glob("*/README.md")), ids=lambda page: page.parent.name)
def test_every_file_that_the_page_of_a_part_names_is_there(page):
    order = re.search(r"## (?:Rooms|Files) in reading order\n(.*?)\n## ", page.read_text("utf-8"), re.DOTALL)[1]
    names = {name.rstrip("/").split("/")[-1] for name in re.findall(r"`([a-z_/]+)`", order)}
    files = {path.stem for path in SOURCE.rglob("*") if path.suffix in ("", ".py") and "__pycache__" not in path.parts}
    words = {"warn", "plot", "summary", "sample", "report", "recording", "k"}  # what these files hold
    assert names - files - words == set()
    rooms = {path.name for path in page.parent.iterdir() if path.is_dir() and (path / "__init__.py").is_file()}
    assert rooms <= names
