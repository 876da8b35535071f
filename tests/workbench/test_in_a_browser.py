"""The workbench as a person uses it, in headless Chromium: by clicks and keys, and by what the files say afterwards."""

import json
import shutil
import subprocess
import sys
import time

import pytest
from served import served

import vasowave as vw
from vasowave.study.table import read_rows
from vasowave.workbench.browser import in_a_browser

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
