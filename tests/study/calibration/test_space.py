"""The networks in space: lengths are true, junctions hold together, numbers are the results', a browser turns it."""

import html
import json
import re

import numpy as np
import pytest

from chromium import run
from vasowave.pulse.examples import control_network
from vasowave.study.cohort import gathered
from vasowave.study.figures import axes_in_space
from vasowave.study.report.sections import space_block

DRIVE = """
addEventListener("load", () => {
  const figure = document.querySelector("figure.space"), out = {};
  const part = (name) => figure.querySelector(`[data-part="${name}"]`);
  const painted = () => {
    const canvas = part("canvas"), data = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
    let sum = 0;
    for (let i = 0; i < data.length; i += 4) if (data[i + 3]) sum += data[i] + 2 * data[i + 1] + i % 9973;
    return sum;
  };
  out.hidden = figure.hidden;
  out.before = painted();
  out.first = part("said").textContent;
  part("canvas").dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowLeft", bubbles: true }));
  out.turned = painted();
  part("quantity").selectedIndex = 1;
  part("quantity").dispatchEvent(new Event("change"));
  out.colored = painted();
  out.range = [part("low").textContent, part("high").textContent];
  part("network").selectedIndex = 1;
  part("network").dispatchEvent(new Event("change"));
  out.other = painted();
  out.waves = part("waveforms").querySelectorAll("path").length;
  const told = document.body.appendChild(document.createElement("pre"));
  told.id = "driven";
  told.textContent = JSON.stringify(out);
});
"""


def test_vessels_have_their_lengths_and_daughters_begin_where_their_parent_ends():
    network = control_network()
    axes = axes_in_space(network)
    np.testing.assert_allclose(np.linalg.norm(axes[:, 1] - axes[:, 0], axis=1), network.length, rtol=1e-12)
    below = np.flatnonzero(network.parent >= 0)
    np.testing.assert_array_equal(axes[below, 0], axes[network.parent[below], 1])
    assert np.linalg.matrix_rank(axes[:, 1] - axes[:, 0], tol=1e-2) == 3  # not flat


def test_what_is_drawn_is_what_the_results_say(cohort_results):
    cohort = gathered(cohort_results)
    (block,) = space_block(cohort, cohort.walls[0])
    for drawn, result in zip(block.data["networks"], cohort.shown.values(), strict=True):
        simulation = result.laws[cohort.walls[0]].simulation.sel(station="middle")
        mean = next(one["values"] for one in drawn["quantities"] if one["label"] == "mean pressure [mmHg]")
        expected = simulation["pressure"].mean("time").sel(vessel=drawn["names"]).values
        np.testing.assert_allclose(mean, expected, rtol=1e-3)
        assert len(drawn["pressure"]) == len(drawn["axes"]) == len(drawn["names"])
        assert all(re.search(r"\[.+\]$", one["label"]) for one in drawn["quantities"])


def test_in_a_browser_networks_turn_and_change_their_color(cohort_page, tmp_path):
    path = tmp_path / "supplement.html"
    path.write_text(cohort_page.replace("</body>", f"<script>{DRIVE}</script></body>"), encoding="utf-8")
    done = run(["--dump-dom", "--virtual-time-budget=10000", path.as_uri()], tmp_path)
    out = json.loads(html.unescape(re.search(r'<pre id="driven">(.*?)</pre>', done.stdout, re.DOTALL)[1]))
    assert out["hidden"] is False
    assert out["first"].startswith("Vessel ")
    assert len({out["before"], out["turned"], out["colored"], out["other"]}) == 4
    assert out["waves"] == 4
    low, high = map(float, out["range"])
    assert 0 < low < high


@pytest.mark.parametrize("name", ["</script>", "a\u2028b"])
def test_names_cannot_end_the_script(name, cohort_results, tmp_path):
    from vasowave.study.report import REPORT, Report, Section, page

    cohort = gathered(cohort_results)
    (block,) = space_block(cohort, cohort.walls[0])
    block.data["networks"][0]["names"][0] = name
    text = page(Report(REPORT, "t", "", "", [Section("s", "S", [block])], {"vasowave": "1"}), {})
    inside = re.search(r'<script type="application/json">(.*?)</script>', text, re.DOTALL)[1]
    assert json.loads(inside)["networks"][0]["names"][0] == name
