"""Draw the pictures of docs/tutorials/workbench.md, or measure how fast the workbench's page is; needs Chromium.

uv run vasowave demo --output demo --starts 4
uv run python tools/workbench.py pictures demo
uv run python tools/workbench.py speed demo
uv run python tools/workbench.py lung 497
"""

import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[1]
sys.path += [str(ROOT / "tests"), str(ROOT / "benchmarks")]

from driven import Page, driven  # noqa: E402

PICTURES = ROOT / "docs" / "figures"
COUNT = 200  # of movements that are timed

DRAWN = """
(async () => {
  const canvas = document.querySelector(%r), took = [], count = %d, act = %s;
  for (let k = 0; k < count; k++) {
    const drawn = canvas.dataset.drawn, begun = performance.now();
    act(canvas, k, count);
    while (canvas.dataset.drawn === drawn) await new Promise((done) => requestAnimationFrame(done));
    took.push(performance.now() - begun);
  }
  return took;
})()
"""
"""Milliseconds from an act to the frame in which the canvas is drawn again, for many acts."""

SLIDE = """(canvas, k) => {
  const slider = document.querySelector("[data-knob]");
  slider.value = 500 + 200 * Math.sin(k / 5);
  slider.dispatchEvent(new Event("input"));
}"""
SCROLL = """(canvas, k, count) => canvas.dispatchEvent(
  new KeyboardEvent("keydown", {key: k % 50 < 5 ? "+" : k % 50 < 10 ? "-" : "ArrowRight"}))"""


@contextmanager
def workbench(place: Path) -> Iterator[str]:
    """Serve a study; give the address."""
    command = [sys.executable, "-m", "vasowave", "open", str(place), "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        assert server.stdout is not None
        try:
            yield next(line.split()[-1] for line in server.stdout if line.startswith("Workbench:"))
            memory = Path(f"/proc/{server.pid}/status")
            if memory.is_file():
                most = next(line for line in memory.read_text().splitlines() if line.startswith("VmHWM"))
                print(f"memory of the server, at most: {int(most.split()[1]) / 1024:.0f} MiB")
        finally:
            server.terminate()


def pictures(page: Page) -> None:
    """Draw every desk."""
    page.wide(1180, 760)
    page.open(page.js("location.href.split('#')[0]") + "#study")
    page.until("document.querySelector('#checking')?.textContent === ''")
    _shot(page, "study")
    _go(page, "recording", "canvas.signals")
    page.drag("canvas.signals", 0.4, 0.52)
    page.click_text("Zoom in")
    page.js("document.querySelector('canvas.signals').focus()")
    for _ in range(4):
        page.key("n")
    time.sleep(1.5)
    _shot(page, "recording")
    _go(page, "explorer", "canvas.panel")
    page.js("(() => { const one = document.querySelectorAll('[data-knob]')[1]; one.value = 590;"
            "one.dispatchEvent(new Event('input')); })()")  # fmt: skip
    time.sleep(2.0)
    _shot(page, "explorer")
    _go(page, "figures", "img.preview")
    time.sleep(1.0)
    _shot(page, "figures")


def picture_of_lung(page: Page) -> None:
    """Draw the Lung desk with its vessels found, one of them chosen."""
    page.wide(1180, 760)
    page.until(FIND, 300)
    page.js("document.querySelectorAll('tr[data-vessel] button')[2].click()")
    time.sleep(1.0)
    _shot(page, "lung")


def _go(page: Page, desk: str, shown: str) -> None:
    page.js(f"location.hash = '{desk}'")
    page.until(f"document.body.dataset.ready === '{desk}' && document.querySelector('{shown}')")
    time.sleep(1.5)


def _shot(page: Page, desk: str) -> None:
    """Keep what stands in the window, in colors enough for a page of documentation."""
    from PIL import Image

    path = PICTURES / f"workbench-{desk}.png"
    page.js("scrollTo(0, 0)")
    time.sleep(0.5)
    page.shot(path, whole=False)
    few = Image.open(path).convert("RGB").quantize(160, Image.Quantize.MAXCOVERAGE)  # keeps colors of thin lines
    few.save(path, optimize=True)
    print(f"{path.relative_to(ROOT)}: {path.stat().st_size / 1024:.0f} KiB")


def told(what: str, took: list[float]) -> None:
    """Print the median and the 95th percentile."""
    print(f"{what}: median {np.median(took):.0f} ms, 95th percentile {np.percentile(took, 95):.0f} ms of {len(took)}")


def speed(page: Page) -> None:
    """Time a slider of the Explorer, tangent wall, and every scroll and zoom of the recording that is open."""
    animal = page.js("fetch('results').then(one => one.json()).then(one => one.animals[0]?.name)")
    _go(page, f"explorer/{animal}/tangent".split("/")[0], "canvas.panel")
    page.js(f"location.hash = 'explorer/{animal}/tangent'")
    time.sleep(3.0)
    told("slider to redraw", page.js(DRAWN % ('[data-panel="pressure"]', COUNT, SLIDE)))


def scroll(page: Page) -> None:
    """Time scrolling and zooming."""
    page.until("Number(document.querySelector('canvas.signals')?.dataset.drawn) > 0", 120)
    page.js("document.querySelector('canvas.signals').dispatchEvent(new KeyboardEvent('keydown', {key: 'Home'}))")
    for zoomed in range(3):
        for _ in range(4):
            page.js("document.querySelector('canvas.signals').dispatchEvent(new KeyboardEvent('keydown', {key: '+'}))")
        time.sleep(1.0)
        told(f"scroll, zoom {2 ** (4 * (zoomed + 1))} times", page.js(DRAWN % ("canvas.signals", COUNT, SCROLL)))


def edits(page: Page) -> None:
    """Time from a key that rejects or restores a beat to the numbers and the table that follow."""
    page.js("document.querySelector('canvas.signals').focus()")
    page.key("n")
    took = []
    for _ in range(6):
        before = page.js("document.body.dataset.told")
        begun = time.monotonic()
        page.key("x")
        page.until(f"document.body.dataset.told !== {json.dumps(before)}", 120)
        took.append(1000 * (time.monotonic() - begun))
    told("edit of a beat", took)
    heap(page)


FIND = "document.querySelectorAll('tr[data-vessel]').length > 2"
CHANGED = """(async () => {
  const seen = () => document.querySelector("#vessels").innerText, before = seen(), begun = performance.now();
  document.querySelector(%r).click();
  while (seen() === before) await new Promise((done) => requestAnimationFrame(done));
  return performance.now() - begun;
})()"""
"""Milliseconds from a click to the table of vessels that follows."""


def corrected(page: Page) -> None:
    """Time three edits of each kind that changes which vessels there are; each is taken back."""
    rows = page.js(
        "[...document.querySelectorAll('tr[data-vessel]')].map(one => [0, 1].map(k => one.cells[k].innerText))"
    )
    parents = {parent for _, parent in rows}
    ends, inner = (
        [name for name, parent in rows if parent and (name in parents) == inside] for inside in (False, True)
    )
    for action, names in (("remove", ends[:3]), ("cut", ends[3:6]), ("merge", inner[:3])):
        took = []
        for name in names:
            page.js(f"document.querySelector('[data-key=\"look {name}\"]').click()")
            took.append(page.js(CHANGED % f"[data-edit={action}]"))
            page.until("!document.querySelector('#undo').disabled")
            page.js(CHANGED % "#undo")
        told(action, took)


def imaged(folder: Path, voxels: int) -> Path:
    """Make a study whose only file is the image of a phantom, with the end of its cannula said."""
    from imaging import EDGE
    from phantom import embed, render
    from vasowave.lung.read import write_volume
    from vasowave.pulse.examples import control_network
    from vasowave.study.entering import new_study

    placed = embed(control_network(), np.random.default_rng(0))
    volume = render(placed, voxels, EDGE / voxels, np.random.default_rng(1))
    new_study(folder)
    for name in ("images", "edits"):
        (folder / name).mkdir()
    write_volume(volume, folder / "images" / "phantom.nrrd")
    place = " ".join(f"{one:.5g}" for one in placed.cannula[0][::-1])
    (folder / "edits" / "phantom.txt").write_text(f"root {place}\n", encoding="utf-8")
    return folder


def lung(voxels: int) -> None:
    """Time edits of a tree, and slices, in the page."""
    with tempfile.TemporaryDirectory() as kept, driven(Path(kept)) as browser:
        study = imaged(Path(kept) / "study", voxels)
        with workbench(study) as address:
            begun = time.monotonic()
            page = browser.page(address + "#lung")
            page.until("Number(document.querySelector('canvas.slice')?.dataset.drawn) > 0", 300)
            print(f"{voxels}³: the image is seen after {time.monotonic() - begun:.1f} s")
            page.until(FIND, 600)
            print(f"the vessels are there after {time.monotonic() - begun:.1f} s")
            took = []
            for k in range(8):
                page.js(f"document.querySelectorAll('tr[data-vessel] button')[{k + 3}].click()")
                page.js(f"document.querySelector('[data-key=radius]').value = '0.02{k}'")
                took.append(page.js(CHANGED % "[data-key='set radius']"))
            told("a radius", took)
            told("undo", [page.js(CHANGED % "#undo") for _ in range(8)])
            corrected(page)
            keys = """(canvas, k) => canvas.dispatchEvent(
              new KeyboardEvent("keydown", {key: k % 40 < 20 ? "PageUp" : "PageDown"}))"""
            told("next slice", page.js(DRAWN % ("canvas.slice", COUNT, keys)))
            heap(page)


def heap(page: Page) -> None:
    """Print what the page's values take."""
    page.ask("Performance.enable")
    used = next(one for one in page.ask("Performance.getMetrics")["metrics"] if one["name"] == "JSHeapUsedSize")
    print(f"memory of the page's values: {used['value'] / 2**20:.0f} MiB")


def long_study(folder: Path) -> Path:
    """Make a study of one recording of two hours at 1000 samples a second."""
    import scipy.io

    from lab_files import SMALL, recorded
    from vasowave.pulse.network import write_network
    from vasowave.study.entering import new_study

    raw = recorded(1, 14.0, duration=600.0)
    new_study(folder)
    signals = {name: np.tile(getattr(raw, name), 12).astype("f4") for name in ("pressure", "flow", "ecg")}
    scipy.io.savemat(folder / "recordings" / "long.mat", signals)
    write_network(SMALL, folder / "networks" / "lung.csv")
    (folder / "animals.csv").write_text(
        "animal,group,network,recording,kind,sampling rate [1/s],pressure unit,flow unit\n"
        "long,CTL,networks/lung.csv,recordings/long.mat,raw,1000,mmHg,ml/s\n", encoding="utf-8"
    )  # fmt: skip
    return folder


def main(what: str, study: str) -> None:
    """Do one of the three."""
    if what == "lung":
        lung(int(study))
        return
    with tempfile.TemporaryDirectory() as kept, driven(Path(kept)) as browser:
        with workbench(Path(study)) as address:
            {"pictures": pictures, "speed": speed}[what](browser.page(address))
        if what == "pictures":
            with workbench(imaged(Path(kept) / "lung", 200)) as address:
                picture_of_lung(browser.page(address + "#lung"))
        if what == "speed":
            with workbench(long_study(Path(kept) / "long")) as address:
                begun = time.monotonic()
                page = browser.page(address + "#recording")
                print(f"two hours are open after {time.monotonic() - begun:.1f} s")
                scroll(page)
                edits(page)


if __name__ == "__main__":
    main(*sys.argv[1:3])
