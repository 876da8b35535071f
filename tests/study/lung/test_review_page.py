"""The review page in a real browser: it draws, it answers clicks, it loads nothing and reports no error."""

import html
import json
import re
import shutil
import subprocess

import numpy as np
import pytest

from made_phantom import NETWORK
from vasowave.lung import read_places
from vasowave.lung.revise import read_edits

BROWSER = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")

PROBE = """
<script>
window.addEventListener("load", () => {
  const canvas = document.getElementById("tree"), out = {};
  const box = canvas.getBoundingClientRect();
  const painted = () => {
    const image = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
    let count = 0, sum = 0;
    for (let i = 3; i < image.length; i += 4) if (image[i]) { count++; sum += (i * (image[i - 1] + 1)) % 9973; }
    return [count, sum];
  };
  const send = (kind, x, y) => canvas.dispatchEvent(new PointerEvent(kind,
    { clientX: box.left + x, clientY: box.top + y, pointerId: 1, bubbles: true }));
  canvas.setPointerCapture = () => {};
  out.before = painted();
  send("pointerdown", 100, 100); send("pointermove", 160, 130); send("pointerup", 160, 130);
  out.turned = painted();
  send("pointerdown", 160, 130); send("pointermove", 100, 130); send("pointermove", 100, 100);
  send("pointerup", 100, 100);
  canvas.dispatchEvent(new WheelEvent("wheel", { deltaY: -300, cancelable: true }));
  out.zoomed = painted();
  canvas.dispatchEvent(new WheelEvent("wheel", { deltaY: 300, cancelable: true }));
  out.picked = [];
  for (let x = 0; x < box.width; x += 12) for (let y = 0; y < box.height; y += 12) {
    send("pointerdown", x, y); send("pointerup", x, y);
    const text = document.getElementById("picked").textContent;
    if (text.includes("Its outlet") && !out.picked.includes(text)) {
      out.picked.push(text);
      document.querySelector("button[data-edit=outlet]").click();
      document.querySelector("button[data-edit=remove]").click();
    }
  }
  out.outlets = document.getElementById("outlets").value;
  out.edits = document.getElementById("edits").value;
  out.loaded = performance.getEntriesByType("resource").map((entry) => entry.name);
  out.wide = document.documentElement.scrollWidth > document.documentElement.clientWidth;
  const said = document.createElement("pre");
  said.id = "probe";
  said.textContent = JSON.stringify(out);
  document.body.append(said);
});
</script>
"""


@pytest.fixture
def page(extracted, scan):
    return extracted[0] / "review.html", scan[1]


def test_the_page_names_nothing_outside_itself(page):
    text = page[0].read_text(encoding="utf-8")
    assert not re.findall(r"""(?:src|href)\s*=\s*["'](?!data:|#)[^"']+""", text)
    assert not re.findall(r"@import|fetch\(|XMLHttpRequest|url\((?!#|['\"]?data:)", text)


def test_every_vessel_stands_in_the_table_and_in_the_view(page):
    text = page[0].read_text(encoding="utf-8")
    data = json.loads(re.search(r'id="tree-data">(.*?)</script>', text, re.DOTALL)[1])
    assert [vessel["name"] for vessel in data["vessels"]] == list(NETWORK.name)
    rows = re.search(r'<table id="vessels">.*?</table>', text, re.DOTALL)[0].count("<tr>")
    assert rows == 1 + len(NETWORK)
    ends = np.array([vessel["points"][-1] for vessel in data["vessels"] if vessel["terminal"]])  # x, y, z, radius
    true = np.array([page[1].lines[row][-1] for row in NETWORK.terminals])
    assert ends.shape == (len(true), 4)
    np.testing.assert_array_less(np.linalg.norm(ends[:, None, 2::-1] - true, axis=2).min(axis=0), 0.05)
    assert ends[:, 3].max() < NETWORK.radius.max()


@pytest.mark.validation
@pytest.mark.skipif(BROWSER is None, reason="no Chromium on this machine")
def test_in_a_browser_the_tree_turns_and_a_click_gives_an_outlets_place(page, tmp_path):
    path, embedding = page
    probed = tmp_path / "page.html"
    probed.write_text(path.read_text(encoding="utf-8").replace("</body>", PROBE + "</body>"), encoding="utf-8")
    done = subprocess.run(
        [BROWSER, "--headless=new", "--no-sandbox", "--disable-gpu", f"--user-data-dir={tmp_path / 'profile'}",
         "--window-size=1000,900", "--enable-logging=stderr", "--virtual-time-budget=8000", "--dump-dom",
         probed.as_uri()], capture_output=True, text=True, timeout=120, check=True,
    )  # fmt: skip
    # The one hint that is allowed is about this test's own reading of pixels.
    said = [line for line in done.stderr.splitlines() if "CONSOLE" in line and "willReadFrequently" not in line]
    assert said == []
    out = json.loads(html.unescape(re.search(r'<pre id="probe">(.*?)</pre>', done.stdout, re.DOTALL)[1]))
    assert out["before"][0] > 2000
    assert out["turned"] != out["before"]
    assert out["zoomed"] != out["before"]
    assert out["loaded"] == []
    assert not out["wide"]
    # What the page offers to copy is what the command reads, and lies at the phantom's outlets.
    (tmp_path / "outlets.csv").write_text(out["outlets"])
    places = read_places(tmp_path / "outlets.csv")
    true = np.array([embedding.lines[row][-1] for row in NETWORK.terminals])
    assert len(places) == len(out["picked"]) == len(true)
    gaps = np.linalg.norm(places[:, None] - true[None], axis=2)
    assert gaps.min(axis=1).max() < 0.02
    assert sorted(gaps.argmin(axis=1).tolist()) == [0, 1, 2]
    (tmp_path / "edits.txt").write_text(out["edits"])
    edits = read_edits(tmp_path / "edits.txt")
    assert [edit.action for edit in edits] == ["remove"] * 3
    np.testing.assert_allclose([edit.point for edit in edits], places, atol=1e-9)
