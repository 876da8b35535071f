"""The pages used as a reader does, in headless Chromium without network: pointer over curves, animals picked."""

import html
import json
import re
from xml.etree import ElementTree

import numpy as np
import pytest

from chromium import WATCH, browser, run
from made_cohort import crossed_cohort
from vasowave.pulse.cycle import cycle_foot
from vasowave.study.cohort import Family, primary_comparison
from vasowave.study.figures import style
from vasowave.study.report import page, report_of

DRIVE = """
const said = [], at = (one, x, y) => {
  const to = new PointerEvent("pointermove", {clientX: x, clientY: y, bubbles: true});
  (one || document.elementFromPoint(x, y) || document.body).dispatchEvent(to);
  const reading = document.getElementById("reading");
  return reading.hidden ? "" : reading.textContent;
};
addEventListener("load", () => {
  const panel = document.querySelector("#figure-Measured [data-scale] path").getBoundingClientRect();
  const shares = [0.2, 0.5, 0.8];
  const curves = shares.map(share => at(null, panel.left + share * panel.width, panel.top + 0.4 * panel.height));
  const marked = document.querySelector("#figure-Forest [data-animal]");
  const outside = at(document.body, 1, 1);
  const dot = at(marked, 1, 1);
  document.querySelector('[data-pick="CTL 2"]').click();
  const count = () => document.querySelectorAll("svg .picked").length;
  const picked = count(), others = [...document.querySelectorAll("a[data-other]")].map(one => one.hash);
  const names = [...document.querySelectorAll("svg .picked")].map(one => one.dataset.animal);
  document.querySelector('[data-pick="CTL 2"]').click();
  const tools = [...document.querySelectorAll("#figure-Forest .tools button")], saved = [];
  HTMLAnchorElement.prototype.click = function () { saved.push([this.download, this.href.slice(0, 60), this.href]); };
  const points = () => [...document.querySelectorAll("#figure-Forest svg.wide g[data-animal]")]
    .filter(one => one.getClientRects().length).length;
  const before = points();
  tools.find(one => one.textContent === "HPH").click();
  const without = points();
  tools.find(one => one.textContent === "SVG").click();
  tools.find(one => one.textContent === "HPH").click();
  const layers = {names: tools.map(one => one.textContent), before, without, again: points(),
    saved: saved.map(one => one.slice(0, 2)), text: decodeURIComponent(saved[0][2])};
  const result = {layers, curves,
    scale: document.querySelector("#figure-Measured [data-scale]").dataset.scale, dot, outside,
    picked, others, names, after: count(), errors: window.failed,
    loaded: performance.getEntriesByType("resource").map(one => one.name)};
  const shown = document.createElement("pre");
  shown.id = "result";
  shown.textContent = JSON.stringify(result);
  document.body.append(shown);
});
"""


def driven(text, folder, script, fragment=""):
    """Return what a script that drives a page found, and the lines of the console."""
    browser()
    page = folder / "driven.html"
    watched = text.replace("<head>", f"<head><script>{WATCH}</script>", 1)
    page.write_text(watched.replace("</body>", f"<script>{script}</script></body>"), encoding="utf-8")
    arguments = ["--dump-dom", "--virtual-time-budget=20000", "--enable-logging=stderr", "--window-size=1280,1600"]
    done = run([*arguments, page.as_uri() + fragment], folder)
    found = re.search(r'<pre id="result">(.*?)</pre>', done.stdout, re.DOTALL)
    return json.loads(html.unescape(found[1])), [line for line in done.stderr.splitlines() if "CONSOLE" in line]


@pytest.fixture(scope="module")
def found(cohort_answer, tmp_path_factory):
    return driven(cohort_answer, tmp_path_factory.mktemp("driven"), DRIVE)


def from_its_foot(result, share):
    """Return the pressure that was measured at a share of the cycle after its foot."""
    at, pressure = result.recording["time"].values / result.period, result.recording["pressure"].values
    return np.interp(share, at - cycle_foot(pressure), pressure, period=1.0)


def test_a_curve_under_the_pointer_is_read_with_the_value_that_was_measured(found, cohort_results):
    by_name = {result.name: result for result in cohort_results}
    result, console = found
    assert (result["errors"], result["loaded"], console) == ([], [], [])
    for said in result["curves"]:
        name, pressure, time = re.fullmatch(r"(.*): ([\d.]+) mmHg at ([\d.]+) T", said).groups()
        group = name.removeprefix("mean of ")
        animals = [by_name[name]] if name in by_name else [one for one in cohort_results if one.group == group]
        assert animals
        expected = np.mean([from_its_foot(one, float(time)) for one in animals])
        # Time is told to 0.01 T; the pressure rises by its whole range in no less than 0.1 T.
        low, high = json.loads(result["scale"])["y"]
        assert float(pressure) == pytest.approx(expected, abs=0.05 * (high - low))


def test_a_point_of_the_forest_says_whose_it_is_and_nothing_is_said_beside(found):
    result, _ = found
    assert re.match(r"(CTL|HPH) \d: [\d.]+ mmHg", result["dot"])
    assert result["outside"] == ""


def test_an_animal_that_is_picked_is_marked_everywhere_and_let_go_again(found):
    result, _ = found
    assert set(result["names"]) == {"CTL 2"}
    assert result["picked"] >= 2 + 5  # its pressure, its flow, and a point in most rows
    assert result["others"] == ["#pick=CTL%202"]
    assert result["after"] == 0


def test_groups_and_laws_of_the_forest_are_taken_out_and_the_drawing_is_saved_as_it_is_seen(found, cohort_results):
    layers = found[0]["layers"]
    assert layers["names"][:2] == ["CTL", "HPH"]
    assert layers["names"][-2:] == ["SVG", "PNG"]
    assert layers["again"] == layers["before"] > layers["without"] > 0
    ((name, kind),) = layers["saved"]
    assert (name, kind.partition(",")[0]) == ("Forest.svg", "data:image/svg+xml;charset=utf-8")
    drawing = ElementTree.fromstring(layers["text"].partition(",")[2])
    animals = [one.get("data-animal") for one in drawing.iter() if one.get("data-animal")]
    assert {result.name for result in cohort_results if result.group == "CTL"} == set(animals)


def test_the_supplement_marks_the_animal_that_was_picked_before(cohort_page, tmp_path):
    script = """addEventListener("load", () => {
      const shown = document.createElement("pre");
      shown.id = "result";
      const rows = [...document.querySelectorAll("tr.picked")];
      shown.textContent = JSON.stringify(rows.map(one => one.cells[0].textContent));
      document.body.append(shown);
    });"""
    rows, console = driven(cohort_page, tmp_path, script, "#pick=CTL%202")
    assert len(rows) > 5
    assert set(rows) == {"CTL 2"}
    assert console == []


@pytest.mark.validation
def test_an_animal_that_was_recorded_twice_is_marked_in_both_recordings(tmp_path):
    cohort, family = crossed_cohort(2), Family(quantities=("mPAP", "CO"))
    with style():
        text = page(report_of(cohort, primary_comparison(cohort, family), family), {})
    script = """addEventListener("load", () => {
      const shown = document.createElement("pre");
      shown.id = "result";
      const marked = [...document.querySelectorAll("svg .picked")].map(one => one.dataset.animal);
      shown.textContent = JSON.stringify([...new Set(marked)].sort());
      document.body.append(shown);
    });"""
    names, console = driven(text, tmp_path, script, "#pick=S%C3%BCd%201")
    assert {"Süd 1 vor", "Süd 1 nach"} <= set(names) <= {"Süd 1", "Süd 1 vor", "Süd 1 nach"}
    assert console == []
