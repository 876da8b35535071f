"""The workbench as a person uses it, in headless Chromium: by clicks and keys, and by what the files say afterwards."""

import json
import shutil
import subprocess
import sys
import time
from itertools import count

import pytest
from served import served

import vasowave as vw
from lab_files import exported, recorded
from vasowave.lung.read import write_volume
from vasowave.study.entering import read_rows
from vasowave.workbench import in_a_browser

READ = "document.querySelector('#checking')?.textContent === ''"
CANVAS = "canvas.signals"


def opened(program, door, desk=""):
    """Return a page of the workbench at a desk, whose fault fails the test."""
    page = program.page(f"{door.origin}{door.root}{desk and '#' + desk}")
    if desk.startswith("recording"):
        page.until(f"Number(document.querySelector('{CANVAS}')?.dataset.drawn) > 0")
    return page


def row(study, animal):
    return next(one for one in read_rows(study / "animals.csv").rows if one["animal"] == animal)


@pytest.mark.validation
def test_whoever_changes_desks_faster_than_they_come_sees_the_last_and_its_numbers(program, study, asker):
    page = opened(program, asker)
    desks = ["study", "recording/mouse_c1", "lung", "explorer", "recording/mouse_h2"]
    page.js(
        f"(async () => {{ for (let k = 0; k < 12; k += 2) for (const one of {json.dumps(desks)}) "
        "{ location.hash = one; await new Promise(done => setTimeout(done, 7 * k)); } })()"
    )
    expected = f"{asker.get('recording', animal='mouse_h2')['indices']['mPAP']:.4g}"
    page.until(f"document.querySelector('[data-index=mPAP]')?.textContent === '{expected}'")
    page.until(f"Number(document.querySelector('{CANVAS}')?.dataset.drawn) > 0")
    time.sleep(1.0)
    assert page.js("document.querySelector('[data-key=animal]').value") == "mouse_h2"
    assert page.js("document.querySelector('[data-index=mPAP]').textContent") == expected
    assert page.js("document.querySelectorAll('h1').length") == 1
    page.errors.clear()  # the Explorer has no results to show


@pytest.mark.validation
def test_a_problem_stands_beside_its_cell_and_a_click_mends_it(program, study, asker):
    page = opened(program, asker)
    page.until(READ)
    page.choose("[data-key='mouse_h1/group']", "")
    page.until("document.querySelector('[data-animal=mouse_h1] td.bad')")
    assert page.js("document.querySelector('#run').disabled")
    page.choose("[data-key='mouse_h1/group']", "hypoxic")
    page.until("!document.querySelector('td.bad')")
    page.type("[data-key='mouse_c2/recording']", row(study, "mouse_c1")["recording"])
    page.click_text("Both are meant to share it")
    page.until("!document.querySelector('.finding.bad')")
    assert row(study, "mouse_c2")["shared recording"] == "yes"
    assert page.errors == []


READY = {
    "study": READ,
    "recording": "document.querySelector('canvas.panel')",
    "lung": "document.querySelector('h1')",
    "explorer": "Number(document.querySelector('[data-panel=pressure]')?.dataset.drawn) > 0",
    "figures": "document.querySelector('img.preview')?.dataset.drawn",
}
"""What tells that a desk is drawn."""

SHIFTS = """(async () => {
  const seen = [];
  new PerformanceObserver(list => seen.push(...list.getEntries())).observe({type: 'layout-shift', buffered: true});
  await new Promise(done => setTimeout(done, 300));
  return seen.flatMap(one => one.sources.map(({node}) => `${one.value} ${node?.outerHTML?.slice(0, 80)}`));
})()"""
"""What on the page was moved that nobody moved, and how far, by W3C's Layout Instability, recent input or not."""


@pytest.mark.validation
def test_a_message_covers_the_foot_of_the_page_moves_nothing_and_can_be_closed(program, study, asker):
    page = opened(program, asker)
    page.until(READ)
    page.wide(1280, 900)
    page.choose("[data-key='mouse_h1/group']", "control")
    page.until(f"!document.querySelector('#undo').disabled && {READ}")
    before = page.js(SHIFTS)
    page.click("#undo")
    page.until("document.querySelector('#said').textContent.includes('group of mouse_h1')")
    page.until(READ)
    assert page.js(SHIFTS) == before
    page.click("#close")
    page.until("getComputedStyle(document.querySelector('#message')).display === 'none'")
    assert page.js(SHIFTS) == before


@pytest.mark.validation
def test_a_file_that_a_recorder_saves_becomes_a_row_and_is_read_while_the_page_is_open(program, study, asker):
    page = opened(program, asker)
    page.until(READ)
    (study / "recordings" / "hypoxic" / "mouse_h9.txt").write_text(exported(recorded(30, mean=26.0)), encoding="utf-8")
    page.until("document.querySelector('tr[data-animal=mouse_h9]')", 60)
    page.until(f"{READ} && !document.querySelector('#run').disabled", 60)
    assert row(study, "mouse_h9")["group"] == "hypoxic"
    page.click("#undo")
    page.until("!document.querySelector('tr[data-animal=mouse_h9]')")
    page.click_text("Add them")
    page.until("document.querySelector('tr[data-animal=mouse_h9]')", 60)
    assert page.errors == []


@pytest.mark.validation
def test_what_another_hand_or_another_tab_writes_is_seen_and_a_reload_loses_nothing(program, study, asker):
    one, other = opened(program, asker), opened(program, asker)
    for page in (other, one):
        page.front()
        page.until(READ)
    one.type("[data-key='mouse_c3/animal']", "Maus Ä")
    one.until("document.querySelector('[data-animal=\"Maus Ä\"]')")
    other.front()
    other.until("document.querySelector('[data-animal=\"Maus Ä\"]')")
    table = study / "animals.csv"
    table.write_text(table.read_text(encoding="utf-8").replace("mouse_h3,", "other,"), encoding="utf-8")
    for page in (other, one):
        page.front()
        page.until("document.querySelector('[data-animal=other]')")
    one.ask("Page.reload")
    one.until(READ)
    assert set(one.js("[...document.querySelectorAll('tr[data-animal]')].map(one => one.dataset.animal)")) >= {
        "Maus Ä", "other"}  # fmt: skip
    assert (one.errors, other.errors) == ([], [])


def test_names_that_look_like_markup_are_text(program, study, asker):
    """The title of a study and the names of its files are a stranger's."""
    path = study / "study.yaml"
    title = "<img src=x onerror=document.title='broken'>"
    path.write_text(f"title: \"{title}\"\n" + "".join(
        line for line in path.read_text(encoding="utf-8").splitlines(True) if not line.startswith("title")
    ), encoding="utf-8")  # fmt: skip
    page = opened(program, asker)
    page.until(READ)
    assert page.js("document.querySelector('h1').textContent") == title
    assert (page.js("document.images.length"), page.errors) == (0, [])


def test_the_keyboard_reaches_every_control(program, study, asker):
    """Tab from the first to the last and round again meets all that can be used."""
    page = opened(program, asker, "recording/mouse_c1")
    controls = page.js(
        "(() => { const all = [...document.querySelectorAll('a[href], button:not(:disabled), select, summary, "
        "canvas[tabindex], input:not(:disabled)')].filter(one => one.checkVisibility()); "
        "all.forEach((one, k) => one.dataset.at = k); "
        "document.activeElement.blur(); return all.length; })()"
    )
    assert controls > 20
    met = set()
    for _ in range(controls + 5):
        page.key("Tab")
        met.add(page.js("document.activeElement.dataset.at"))
    assert {str(k) for k in range(controls)} <= met
    clicked = page.js(
        "[...document.querySelectorAll('*')].filter(one => one.onclick && !one.matches('button, a')).length"
    )
    assert clicked == 0


@pytest.mark.validation
def test_six_raw_files_and_a_lung_become_a_report_by_few_clicks_and_the_same_as_by_commands(program, lab, tmp_path):
    """Dropped and run in the page; made and run by `new`, `add` and `run`: files and numbers are equal."""
    by_page, by_hand = tmp_path / "page", tmp_path / "commands"
    by_page.mkdir()
    with served(by_page) as door:
        page = opened(program, door)
        page.give("#folder", [lab])
        page.until("document.querySelectorAll('tr[data-animal]').length === 6")
        page.until(READ)
        page.click("#settings summary")
        for key, value in (("calibration.walls", "[linear]"), ("calibration.starts", "2")):
            page.type(f"[data-key='setting {key}']", value)
            page.until(f"document.querySelector('[data-key=\"setting {key}\"]')?.defaultValue === {json.dumps(value)}")
        page.until("!document.querySelector('#run').disabled", 60)  # its recordings have been read
        page.click("#run")
        page.until("document.querySelector('#stop') && document.querySelector('progress')")
        page.until("document.querySelector('#report') && document.querySelector('#run')", 300)
        page.until("[...document.querySelectorAll('td.state')].every(one => one.textContent === 'done')")
        assert page.clicks <= 25
        address, errors = page.js("document.querySelector('#report').href"), page.errors
        page.open(address)
        page.until("document.body?.innerText.includes('mouse_h3')")
        # The browser itself asks for an icon of the report, which may load nothing.
        assert [one for one in errors if "favicon.ico" not in one] == []

    def command(*words):
        subprocess.run([sys.executable, "-m", "vasowave", *map(str, words)], check=True, capture_output=True)

    command("new", by_hand)
    shutil.copytree(lab, by_hand / "recordings" / "lab")
    (by_hand / "recordings" / "lab" / "lung.csv").rename(by_hand / "networks" / "lung.csv")
    command("add", by_hand, by_hand / "recordings", by_hand / "networks")
    text = (by_hand / "study.yaml").read_text(encoding="utf-8")
    text = text.replace("  walls: [linear, tangent]", "  walls: [linear]").replace("  starts: 20", "  starts: 2")
    (by_hand / "study.yaml").write_text(text, encoding="utf-8")
    command("run", by_hand)
    for name in ("study.yaml", "animals.csv"):
        assert (by_page / name).read_bytes() == (by_hand / name).read_bytes()
    for folder in ("networks", "recordings", "report"):
        assert names(by_page / folder) == names(by_hand / folder)
    ours, theirs = vw.read_results(by_page), vw.read_results(by_hand)
    assert list(ours) == list(theirs)
    for animal in ours:
        for law in ours[animal].laws:
            assert ours[animal].laws[law].quantities.identical(theirs[animal].laws[law].quantities)


def names(folder):
    return sorted(path.relative_to(folder) for path in folder.rglob("*"))


@pytest.mark.validation
def test_the_file_that_a_browser_is_started_with_leads_to_the_page(program, asker, started):
    file = in_a_browser(asker.address, "#recording/mouse_c1", asker.guard)
    page = program.page(file.as_uri())
    page.until(f"Number(document.querySelector('{CANVAS}')?.dataset.drawn) > 0")
    assert page.js("location.href") == f"{asker.address}#recording/mouse_c1"
    assert (page.errors, file.exists()) == ([], False)


def tab_to(page, selector):
    """Press Tab until the keyboard is on an element; fails after a round through the page."""
    for _ in range(300):
        if page.js(f"document.activeElement.matches({json.dumps(selector)})"):
            return
        page.key("Tab")
    pytest.fail(f"Tab does not reach {selector}")


@pytest.mark.validation
def test_the_study_desk_by_keys_alone_mends_a_table_and_runs(program, study, asker):
    page = opened(program, asker, "study")
    page.until(READ)
    tab_to(page, "[data-key='mouse_h1/group']")
    page.key("ArrowUp", windowsVirtualKeyCode=38)  # from hypoxic to control
    page.until("!document.querySelector('#undo').disabled")
    assert row(study, "mouse_h1")["group"] == "control"
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


@pytest.mark.validation
def test_the_recording_desk_by_keys_alone_chooses_a_stretch_and_rejects_a_beat(program, study, asker):
    page = opened(program, asker, "recording/mouse_c1")
    tab_to(page, CANVAS)
    rejected = asker.get("recording", animal="mouse_c1")["beats"]["rejected"]
    for _ in range(next(place for place in count() if str(place) not in rejected) + 1):
        page.key("n")  # to the first that may be averaged
    page.key("x")
    page.until("document.body.innerText.includes('1 beats edited')")
    tab_to(page, CANVAS)
    page.key("b")  # from the middle of the window on
    tab_to(page, "[data-key='Average this stretch']")
    page.key("Enter")
    page.until("document.querySelector('[data-key=\"Average the whole recording\"]')")
    found = row(study, "mouse_c1")
    whole = vw.read_raw_recording(study / found["recording"]).duration
    assert float(found["start [s]"]) == pytest.approx(whole / 2, rel=0.02)
    assert [one.action for one in vw.read_edits(study / found["beat edits"])] == ["reject"]
    assert page.errors == []


@pytest.mark.validation
def test_the_grip_of_the_stretch_that_is_dragged_is_where_the_averaging_begins(program, study, asker):
    page = opened(program, asker, "recording/mouse_c1")
    page.js("import('./page/recording.js').then((desk) => desk.lookAt(0, 8))")
    left, top, wide = page.js(
        f"(({{x, y, width}}) => [x, y, width])(document.querySelector('{CANVAS}').getBoundingClientRect())"
    )
    second = (wide - 60) / 8  # the axis has 54 px on its left and 6 on its right
    page.mouse("mousePressed", left + 56, top + 8)
    for end in (1.0, 2.0):
        page.mouse("mouseMoved", left + 54 + end * second, top + 8, buttons=1)
    page.mouse("mouseReleased", left + 54 + 2.0 * second, top + 8)
    page.until("document.querySelector('[data-key=\"Average the whole recording\"]')")
    found = row(study, "mouse_c1")
    assert float(found["start [s]"]) == pytest.approx(2.0, abs=1.5 / second)
    whole = asker.get("recording", animal="mouse_c1")
    assert min(whole["beats"]["starts"][k] for k in whole["beats"]["averaged"]) >= float(found["start [s]"])
    assert page.errors == []


@pytest.mark.validation
def test_the_beginning_of_a_beat_that_is_dragged_is_where_a_run_begins_it(program, study, asker):
    page = opened(program, asker, "recording/mouse_c1")
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
    found = row(study, "mouse_c1")
    (edit,) = vw.read_edits(study / found["beat edits"])
    assert (edit.action, edit.time) == ("move", pytest.approx(start, abs=1e-4))
    assert edit.to == pytest.approx(start + 0.006, abs=1.5 / second)
    raw = vw.read_raw_recording(study / found["recording"])
    again = vw.average_beats(raw, edits=vw.read_edits(study / found["beat edits"])).beats
    assert min(abs(one.start - edit.to) for one in again) < 1e-9
    assert page.errors == []


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


@pytest.mark.validation
def test_nothing_on_a_desk_is_moved_by_what_comes_later(program, ran):
    with served(ran) as door:
        page = program.page(f"{door.origin}{door.root}#study")
        page.wide(1280, 900)
        page.until(READ)
        before = page.js(SHIFTS)
        for desk in ("recording", "explorer", "figures", "lung", "study"):
            page.js(f"location.hash = '{desk}'")
            page.until(f"document.body.dataset.ready === '{desk}' && {READY[desk]}", 90)
            time.sleep(1.0)
            assert page.js(SHIFTS) == before, desk
        assert page.errors == []


@pytest.mark.validation
def test_every_desk_fits_windows_from_400_to_1920_px_light_and_dark(program, ran, scan):
    """Nothing but a table that scrolls by itself sticks out; letters have the contrast of WCAG's level AAA."""
    (ran / "images").mkdir()
    write_volume(scan, ran / "images" / "lung.nrrd")
    ready = READY | {"lung": "Number(document.querySelector('canvas.slice')?.dataset.drawn) > 0"}
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
