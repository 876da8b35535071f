"""Every desk by keys alone, and what a pointer does on the signals and the tree, in headless Chromium."""

import json
import shutil
from itertools import count

import numpy as np
import pytest
from served import served

import vasowave as vw
from phantom import embed, render
from vasowave.imaging import write_volume
from vasowave.imaging.places import written
from vasowave.network.network import Network
from vasowave.study.table import read_rows
from vasowave.study.template import new_study

pytestmark = [
    pytest.mark.validation,
    pytest.mark.filterwarnings("ignore::vasowave.errors.VasowaveWarning"),  # the phantom's doubts
]
CANVAS = "canvas.signals"
CODES = {"ArrowUp": 38, "ArrowDown": 40, "ArrowRight": 39, "ArrowLeft": 37, "PageUp": 33, "PageDown": 34, "Home": 36}


def opened(program, door, desk, ready):
    page = program.page(f"{door.origin}{door.root}#{desk}")
    page.until(ready)
    return page


def press(page, key, times=1):
    """Press a key so that controls of the browser itself hear it, too."""
    for _ in range(times):
        page.key(key, **({"windowsVirtualKeyCode": CODES[key]} if key in CODES else {}))


def tab_to(page, selector):
    """Press Tab until the keyboard is on an element; fails after a round through the page."""
    for _ in range(300):
        if page.js(f"document.activeElement.matches({json.dumps(selector)})"):
            return
        page.key("Tab")
    pytest.fail(f"Tab does not reach {selector}")


def cells(study, animal):
    return next(one for one in read_rows(study / "animals.csv").rows if one["animal"] == animal)


def test_the_study_desk_by_keys_alone_mends_a_table_and_runs(program, study, asker):
    page = opened(program, asker, "study", "document.querySelector('#checking')?.textContent === ''")
    tab_to(page, "[data-key='mouse_h1/group']")
    press(page, "ArrowUp")  # from hypoxic to control
    page.until("!document.querySelector('#undo').disabled")
    assert cells(study, "mouse_h1")["group"] == "control"
    page.until("!document.querySelector('#run').disabled")
    tab_to(page, "#run")  # in a list, Ctrl+Z is the browser's
    page.key("z", modifiers=2)
    page.until("document.querySelector('[data-key=\"mouse_h1/group\"]').value === 'hypoxic'")
    page.until("!document.querySelector('#run').disabled")
    tab_to(page, "#run")
    page.key("Enter")
    page.until("document.querySelector('#stop')")
    tab_to(page, "#stop")
    page.key("Enter")
    page.until("document.querySelector('#run')", 60)
    assert page.errors == []


def test_the_recording_desk_by_keys_alone_chooses_a_stretch_and_rejects_a_beat(program, study, asker):
    page = opened(
        program, asker, "recording/mouse_c1", f"Number(document.querySelector('{CANVAS}')?.dataset.drawn) > 0"
    )
    tab_to(page, CANVAS)
    rejected = asker.get("recording", animal="mouse_c1")["beats"]["rejected"]
    for _ in range(next(place for place in count() if str(place) not in rejected) + 1):
        press(page, "n")  # to the first that may be averaged
    press(page, "x")
    page.until("document.body.innerText.includes('1 beats edited')")
    tab_to(page, CANVAS)
    press(page, "b")  # from the middle of the window on
    tab_to(page, "[data-key='Average this stretch']")
    page.key("Enter")
    page.until("document.querySelector('[data-key=\"Average the whole recording\"]')")
    row = cells(study, "mouse_c1")
    whole = vw.read_raw_recording(study / row["recording"]).duration
    assert float(row["start [s]"]) == pytest.approx(whole / 2, rel=0.02)
    assert [one.action for one in vw.read_edits(study / row["beat edits"])] == ["reject"]
    assert page.errors == []


def test_the_beginning_of_a_beat_that_is_dragged_is_where_a_run_begins_it(program, study, asker):
    page = opened(
        program, asker, "recording/mouse_c1", f"Number(document.querySelector('{CANVAS}')?.dataset.drawn) > 0"
    )
    start = asker.get("recording", animal="mouse_c1")["beats"]["starts"][6]
    page.js(f"import('./page/recording.js').then((desk) => desk.lookAt({start - 0.2}, {start + 0.3}))")
    left, top, wide = page.js(
        f"(({{x, y, width}}) => [x, y, width])(document.querySelector('{CANVAS}').getBoundingClientRect())"
    )
    second = (wide - 60) / 0.5  # the axis has 54 px on its left and 6 on its right
    at = left + 54 + 0.2 * second
    for kind in ("mousePressed", "mouseReleased"):  # picks the beat
        page.mouse(kind, at + 0.02 * second, top + 60)
    page.until("document.querySelector('[data-beat=\"6\"]')")
    page.mouse("mousePressed", at, top + 60)
    for step in (0.003, 0.006):
        page.mouse("mouseMoved", at + step * second, top + 60, buttons=1)
    page.mouse("mouseReleased", at + 0.006 * second, top + 60)
    page.until("document.body.innerText.includes('1 beats edited')")
    row = cells(study, "mouse_c1")
    (edit,) = vw.read_edits(study / row["beat edits"])
    assert (edit.action, edit.time) == ("move", pytest.approx(start, abs=1e-4))
    assert edit.to == pytest.approx(start + 0.006, abs=1.5 / second)
    raw = vw.read_raw_recording(study / row["recording"])
    again = vw.average_beats(raw, edits=vw.read_edits(study / row["beat edits"])).beats
    assert min(abs(one.start - edit.to) for one in again) < 1e-9
    assert page.errors == []


TREE = Network(
    ("1", "2", "3", "4", "5"),
    np.array([-1, 0, 0, 1, 1]),
    np.array([0.3, 0.3, 0.25, 0.2, 0.25]),
    np.array([0.052, 0.042, 0.032, 0.034, 0.03]),
)
COUNT = "document.querySelectorAll('tr[data-vessel]').length"
SEEN = "Number(document.querySelector('canvas.slice')?.dataset.drawn) > 0"


@pytest.fixture
def imaged(tmp_path):
    """A study of one image of five vessels, whose root is said."""
    rng = np.random.default_rng(5)
    placed = embed(TREE, rng)
    folder = tmp_path / "imaged"
    new_study(folder)
    for name in ("images", "edits"):
        (folder / name).mkdir()
    write_volume(render(placed, 100, 0.012, rng, noise=6.0), folder / "images" / "lung.nrrd")
    root = written(placed.cannula[0]).replace(",", " ")
    (folder / "edits" / "lung.txt").write_text(f"root {root}\n", encoding="utf-8")
    return folder


OUTSIDE = """[...document.querySelectorAll('main *, header *')].filter((one) => {
  if (!one.checkVisibility() || one.closest('.table')) return false;
  return one.getBoundingClientRect().right > document.documentElement.clientWidth + 1;
}).map((one) => `${one.tagName} ${one.className} ${one.textContent.slice(0, 40)}`)"""
CONTRAST = """(() => {
  const light = (text) => text.match(/[\\d.]+/g).slice(0, 3).map((one) => one / 255)
    .map((one) => (one <= 0.04045 ? one / 12.92 : ((one + 0.055) / 1.055) ** 2.4))
    .reduce((sum, one, k) => sum + one * [0.2126, 0.7152, 0.0722][k], 0);
  const all = getComputedStyle(document.body);
  const pair = [light(all.color), light(all.backgroundColor)].sort((a, b) => b - a);
  return [(pair[0] + 0.05) / (pair[1] + 0.05), light(all.backgroundColor)];
})()"""


def test_every_desk_fits_windows_from_400_to_1920_px_light_and_dark(program, ran, imaged):
    """Nothing but a table that scrolls by itself sticks out; letters have the contrast of WCAG's level AAA."""
    shutil.copytree(imaged / "images", ran / "images")
    shutil.copytree(imaged / "edits", ran / "edits")
    ready = {
        "study": "document.querySelector('#checking')?.textContent === ''",
        "recording": "document.querySelector('canvas.panel')",
        "lung": f"{COUNT} === 5",
        "explorer": "Number(document.querySelector('[data-panel=pressure]')?.dataset.drawn) > 0",
        "figures": "document.querySelector('img.preview')?.dataset.drawn",
    }
    with served(ran) as door:
        page = program.page(door.origin + door.root)
        for desk, shown in ready.items():
            page.js(f"location.hash = '{desk}'")
            page.until(f"document.body.dataset.ready === '{desk}' && {shown}", 90)
            for width, dark in ((400, False), (400, True), (1280, False), (1280, True), (1920, False)):
                page.wide(width, 900, dark)
                page.until(f"innerWidth === {width}")
                assert page.js("document.documentElement.scrollWidth") <= width, (desk, width)
                assert page.js(OUTSIDE) == [], (desk, width)
                contrast, paper = page.js(CONTRAST)
                assert contrast > 7
                assert (paper < 0.2) is dark
            page.wide(1280)
        assert page.errors == []
