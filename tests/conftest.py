import os
import pickle
import random
import shutil
import sys
import time
from pathlib import Path
from zlib import crc32

import numpy as np
import pytest

from alone import BELOW

SHARED = Path(__file__).parents[1] / ".." / "shared" / "data"
PARTS = (*BELOW, "cli", "workbench")

# Where bytecode is not written, each of some hundred processes compiles everything that it imports.
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)


def pytest_collection_modifyitems(items):
    """Mark as `validation` what `long.txt` names, and as `fast` all but validation, weekly and what `slow.txt` names.

    Where `VASOWAVE_SHARE` is "3/20", keep the tests of a twentieth of the files, files and tests in random order; where
    it is "first", the first fast test of each file.
    """
    slow, long = (
        set((Path(__file__).parent / f"{name}.txt").read_text("utf-8").split("\n")) for name in ("slow", "long")
    )
    for item in items:
        names = {item.nodeid.partition("::")[0], item.nodeid.partition("[")[0]}
        if names & long and not item.get_closest_marker("weekly"):
            item.add_marker(pytest.mark.validation)
        if not names & slow and not any(map(item.get_closest_marker, ("validation", "weekly"))):
            item.add_marker(pytest.mark.fast)
    share = os.environ.get("VASOWAVE_SHARE", "")
    if share == "first":
        items[:] = {item.path: item for item in reversed(items) if item.get_closest_marker("fast")}.values()
    elif share:
        number, count = map(int, share.split("/"))
        items[:] = [item for item in items if crc32(item.path.name.encode()) % count == number]
        chance = random.Random(share)
        place = {path: chance.random() for path in sorted({str(item.path) for item in items})}
        items.sort(key=lambda item: (place[str(item.path)], chance.random()))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item):
    """Let nothing above a part be there while its tests run, whatever was imported for others; see `tools/alone.py`.

    A file that needs more, and is skipped where that is absent, names it in ABOVE.
    """
    part = item.path.relative_to(Path(__file__).parent).parts[0]
    there = {part, *BELOW.get(part, PARTS), *getattr(item.module, "ABOVE", ())}
    absent = tuple(f"vasowave.{name}" for name in PARTS if name not in there)
    hidden = {name: sys.modules.pop(name) for name in [*sys.modules] if name.startswith(absent)} if absent else {}
    package = vars(sys.modules.get("vasowave", sys))
    attributes = {name: package.pop(name) for name in PARTS if f"vasowave.{name}" in absent and name in package}
    sys.modules.update(dict.fromkeys(absent))  # a module that is None there cannot be imported
    try:
        return (yield)
    finally:
        for name in absent:
            del sys.modules[name]
        sys.modules.update(hidden)
        package.update(attributes)


def pytest_make_parametrize_id(val, argname):
    """Name bytes by their argument and number: their own escapes are no name, and packed ones hold the time."""
    return argname if isinstance(val, bytes) else None


@pytest.fixture(scope="session", autouse=True)
def _linear_algebra_on_one_thread():
    """Let small matrices cost what they cost: threads that wait for each other spin, beside another worker above all.

    The commands ask for this themselves (`threads.spare_threads`); what a test starts is not told by this.
    """
    import scipy.linalg  # noqa: F401  brings a library of its own, which is limited only if it is there
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1):
        yield


@pytest.fixture(scope="session", autouse=True)
def state_folder(tmp_path_factory):
    """Keep what a user allows away from the folders of whoever runs the tests; the commands that tests start, too."""
    place = tmp_path_factory.mktemp("state")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_STATE_HOME", str(place))
        yield place


@pytest.fixture(scope="session")
def shared() -> Path:
    """Return the folder of measured data beside the project, or skip."""
    if not SHARED.is_dir():
        pytest.skip(f"measured data are not beside the project ({SHARED.name} is absent)")
    return SHARED


@pytest.fixture(scope="session")
def inflow():
    """Return a smooth, strictly periodic ejection of a control mouse: 0.17 ml/s at 545 beats/min."""
    from vasowave.pulse.cycle import Inflow

    t = np.arange(256) / 256
    q = np.exp(-0.5 * ((t - 0.45) / 0.09) ** 2)
    return Inflow(0.17 * q / q.mean(), 0.11)


@pytest.fixture(scope="session", params=["linear", "tangent"])
def control(request):
    """Return the control network with either wall law at parameters of a control mouse."""
    from vasowave.pulse.examples import control_network
    from vasowave.pulse.model import LinearWall, Model, TangentWall, windkessels

    network = control_network()
    wall = LinearWall(57.0) if request.param == "linear" else TangentWall(7.0, 4.0)
    return Model(network, wall, windkessels(network, 76.0, 0.11, a=0.12))


@pytest.fixture(autouse=True)
def random_numbers_of_each_test(request):
    """Let the generator of a module, `RNG`, give every test the same numbers, whichever tests ran before."""
    generator = getattr(request.module, "RNG", None)
    if generator is not None:
        first = request.module.__dict__.setdefault("_first_state", generator.bit_generator.state)
        generator.bit_generator.state = first


@pytest.fixture(autouse=True)
def no_figures_left():
    """Close what a value's `plot` opened for a notebook."""
    yield
    if pyplot := sys.modules.get("matplotlib.pyplot"):
        pyplot.close("all")


@pytest.fixture(scope="session")
def made_once(tmp_path_factory):
    """Return what gives a folder `study` whose content the first of all workers makes that asks for its name."""

    def made(name, fill):
        folder = tmp_path_factory.mktemp(name) / "study"
        if "PYTEST_XDIST_WORKER" not in os.environ:
            folder.mkdir()
            fill(folder)
            return folder
        common = tmp_path_factory.getbasetemp().parent / f"{name} of all workers"
        while not common.exists():
            fill_alone(common, fill)
        return Path(shutil.copytree(common, folder))

    return made


def fill_alone(folder, fill):
    """Fill a folder, which is there once it is full; or wait a little where another worker is at it."""
    lock, half = (folder.with_name(f"{folder.name}, {state}") for state in ("locked", "half"))
    try:
        lock.mkdir()
    except FileExistsError:
        time.sleep(0.2)
        return
    try:
        if not folder.exists():
            shutil.rmtree(half, ignore_errors=True)
            (half / "study").mkdir(parents=True)
            fill(half / "study")
            (half / "study").rename(folder)
    finally:
        lock.rmdir()


@pytest.fixture(scope="session")
def cohort_results(made_once) -> list:
    """Return the results of 3 + 3 animals with planted values, see made_cohort."""
    from made_cohort import planted_results

    def fill(folder):
        (folder / "results").write_bytes(pickle.dumps(planted_results()))

    return pickle.loads((made_once("planted", fill) / "results").read_bytes())


@pytest.fixture(scope="session")
def cohort_report(cohort_results, made_once) -> Path:
    """Return a folder with their report, one more animal having failed."""
    from made_cohort import FAILURE
    from vasowave.study.animal import Failure, Stage
    from vasowave.study.report import write_report

    def fill(folder):
        (folder / "results.nc").write_bytes(b"not ours to touch")
        lost = [Failure("HPH 9", "HPH", "", Stage.COMPUTING, FAILURE, 61.2)]
        write_report(cohort_results, folder, lost=lost, each=as_processes_do)

    return made_once("cohort", fill)


def as_processes_do(function, things):
    """Apply a function to copies of things that went through the pipe to another process."""
    return [function(pickle.loads(pickle.dumps(thing))) for thing in things]


@pytest.fixture(scope="session")
def cohort_page(cohort_report) -> str:
    """Return the supplement of that report."""
    return (cohort_report / "supplement.html").read_text(encoding="utf-8")


@pytest.fixture(scope="session")
def cohort_answer(cohort_report) -> str:
    """Return the first page of that report."""
    return (cohort_report / "report.html").read_text(encoding="utf-8")


@pytest.fixture
def undrawn(monkeypatch) -> None:
    """Leave the figures of reports empty, for tests of their words: drawing is most of what a report costs."""
    empty = '<svg xmlns="http://www.w3.org/2000/svg" width="9pt" height="9pt" viewBox="0 0 9 9"></svg>'
    monkeypatch.setattr("vasowave.study.report.blocks.svg", lambda figure: empty)
