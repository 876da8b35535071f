"""Open a page in headless Chromium without network and measure it."""

import html
import json
import re
import shutil
import subprocess

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")

# The page stands in a frame of the width asked for, since a window cannot be as narrow as a phone. Everything folded is
# opened. A box that scrolls by itself may be wider inside; anything else may not.
MEASURE = """
const frame = document.getElementById("frame");
frame.onload = () => {
  const page = frame.contentDocument, root = page.documentElement;
  page.querySelectorAll("details").forEach(one => one.open = true);
  const scrolls = one => ["auto", "scroll"].includes(getComputedStyle(one).overflowX);
  const inside = one => { for (let up = one.parentElement; up; up = up.parentElement) if (scrolls(up)) return true; return false; };
  const wide = [...page.body.querySelectorAll("*:not(svg *)")].filter(one => !scrolls(one) && !inside(one) &&
    (one.scrollWidth > one.clientWidth + 1 && one.clientWidth > 0 || one.getBoundingClientRect().right > root.clientWidth + 1));
  const cut = [...page.querySelectorAll("svg")].flatMap(drawing => {
    const box = drawing.getBoundingClientRect();
    return [...drawing.querySelectorAll("text")].filter(text => { const at = text.getBoundingClientRect();
      return at.left < box.left - 2 || at.right > box.right + 2 || at.top < box.top - 2 || at.bottom > box.bottom + 2; })
      .map(text => drawing.parentElement.parentElement.id + ": " + text.textContent); });
  document.getElementById("result").textContent = JSON.stringify({
    pageWidth: root.scrollWidth, frameWidth: root.clientWidth, errors: frame.contentWindow.failed || [],
    wide: wide.map(one => one.tagName + " " + one.className + " " + one.textContent.slice(0, 60)), cut: cut,
    drawings: page.querySelectorAll("figure svg").length,
    empty: [...page.querySelectorAll("figure svg")].filter(one => one.getBoundingClientRect().height < 20).length,
    missing: [...page.images].filter(one => !one.complete || one.naturalWidth === 0).length,
    loaded: frame.contentWindow.performance.getEntriesByType("resource").map(one => one.name),
    unresolved: [...page.querySelectorAll('a[href^="#"], use')].filter(one =>
      !page.getElementById((one.getAttribute("href") || one.getAttribute("xlink:href")).slice(1))).length,
  });
};
"""


def browser():
    """Return the path of a Chromium, or skip."""
    found = next(filter(None, map(shutil.which, NAMES)), None)
    if found is None:
        pytest.skip(f"no Chromium on this machine (none of {', '.join(NAMES)})")
    return found


def measured(page, width, folder):
    """Return what Chromium measures of a page (text) in a frame of `width` px, and the lines of its console."""
    watched = page.replace(
        "<head>",
        "<head><script>window.failed = []; addEventListener('error', e => failed.push(String(e.message)), true);</script>",
        1,
    )
    outer = (
        f'<!DOCTYPE html><iframe id="frame" style="border:0; width:{width}px; height:900px" '
        f'srcdoc="{html.escape(watched, quote=True)}"></iframe><pre id="result"></pre><script>{MEASURE}</script>'
    )
    path = folder / f"frame-{width}.html"
    path.write_text(outer, encoding="utf-8")
    done = run(["--dump-dom", "--virtual-time-budget=20000", "--enable-logging=stderr", path.as_uri()], folder)
    result = re.search(r'<pre id="result">(.*?)</pre>', done.stdout, re.DOTALL)
    console = [line for line in done.stderr.splitlines() if "CONSOLE" in line]
    return json.loads(html.unescape(result[1])), console


def run(arguments, folder):
    """Run Chromium without a window, a network or a profile of its own."""
    command = [
        browser(), "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--hide-scrollbars",
        "--host-resolver-rules=MAP * ~NOTFOUND", f"--user-data-dir={folder / 'profile'}", *arguments,
    ]  # fmt: skip
    return subprocess.run(command, capture_output=True, text=True, timeout=180, check=True)
