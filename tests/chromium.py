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
const measured = frame => {
  const page = frame.contentDocument, root = page.documentElement;
  const all = selector => [...page.querySelectorAll(selector)];
  const box = one => one.getBoundingClientRect();
  all("details").forEach(one => one.open = true);
  const scrolls = one => ["auto", "scroll"].includes(getComputedStyle(one).overflowX);
  const inside = one => one.parentElement && (scrolls(one.parentElement) || inside(one.parentElement));
  const overflows = one => one.clientWidth > 0 && one.scrollWidth > one.clientWidth + 1;
  const beyond = one => box(one).right > root.clientWidth + 1;
  const wide = all("body *:not(svg *)").filter(one => !scrolls(one) && !inside(one) && (overflows(one) || beyond(one)));
  const outside = (text, at) => text.left < at.left - 2 || text.right > at.right + 2 ||
    text.top < at.top - 2 || text.bottom > at.bottom + 2;
  const cut = all("svg text").filter(text => outside(box(text), box(text.closest("svg"))));
  const shown = all("figure svg").filter(one => getComputedStyle(one).display !== "none");
  const target = one => one.getAttribute("href") || one.getAttribute("xlink:href");
  return {
    width: root.clientWidth, pageWidth: root.scrollWidth, errors: frame.contentWindow.failed || [],
    wide: wide.map(one => one.tagName + " " + one.className + " " + one.textContent.slice(0, 60)),
    cut: cut.map(text => text.closest("figure").id + ": " + text.textContent),
    drawings: all("figure svg").length,
    shown: shown.length, empty: shown.filter(one => box(one).height < 20).length,
    sideways: shown.filter(one => one.closest(".drawing")).filter(one => overflows(one.parentElement))
      .map(one => one.closest("figure").id),
    missing: all("img").filter(one => !one.complete || one.naturalWidth === 0).length,
    loaded: frame.contentWindow.performance.getEntriesByType("resource").map(one => one.name),
    unresolved: all('a[href^="#"], use').filter(one => !page.getElementById(target(one).slice(1))).length,
  };
};
addEventListener("load", () => {
  const frames = [...document.querySelectorAll("iframe")];
  document.getElementById("result").textContent = JSON.stringify(frames.map(measured));
});
"""
WATCH = "window.failed = []; addEventListener('error', e => failed.push(String(e.message)), true);"


def browser():
    """Return the path of a Chromium, or skip."""
    found = next(filter(None, map(shutil.which, NAMES)), None)
    if found is None:
        pytest.skip(f"no Chromium on this machine (none of {', '.join(NAMES)})")
    return found


def measured(page, widths, folder):
    """Return what Chromium measures of a page (text) in frames of each of `widths` px, and the lines of its console."""
    watched = html.escape(page.replace("<head>", f"<head><script>{WATCH}</script>", 1), quote=True)
    frames = [
        f'<iframe style="border:0; width:{width}px; height:900px" srcdoc="{watched}"></iframe>' for width in widths
    ]
    path = folder / "frames.html"
    path.write_text(
        f'<!DOCTYPE html><meta charset="utf-8"><script>{MEASURE}</script><pre id="result"></pre>{"".join(frames)}',
        encoding="utf-8",
    )
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
