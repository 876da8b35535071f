"""Drive headless Chromium by its own protocol over a pipe: click, type, look, measure; needs no package."""

import base64
import itertools
import json
import os
import queue
import subprocess
import sys
import threading
import time
from contextlib import contextmanager

from chromium import browser

LAUNCHER = (
    "import fcntl, os, sys; down, up = (fcntl.fcntl(int(one), fcntl.F_DUPFD, 20) for one in sys.argv[1:3]); "
    "os.dup2(down, 3); os.dup2(up, 4); os.execv(sys.argv[3], sys.argv[3:])"
)
"""A browser reads what it is told from handle 3 and answers into handle 4."""

ANY_HOST = "MAP * ~NOTFOUND, EXCLUDE 127.0.0.1, EXCLUDE localhost"


MIDDLE = (
    "(() => { const one = %s; if (!one) return null; one.scrollIntoView({block: 'center'}); "
    "const box = one.getBoundingClientRect(); return [box.x + box.width / 2, box.y + box.height / 2]; })()"
)
"""Scroll an element into view and return its middle in one step: a page that is drawn anew has no moment between."""


class NotDoneError(AssertionError):
    """The page does not do what was asked."""


class Page:
    """One page of a browser. `clicks` counts what a person did; `requests` and `errors` what the page did."""

    def __init__(self, program):
        self.program, self.replies, self.numbers = program, {}, itertools.count(1)
        self.requests, self.errors, self.clicks = [], [], 0
        self.session = self.context = None

    def ask(self, method, **given):
        return self.program.ask(self, method, given)

    def heard(self, method, params):
        if method == "Network.requestWillBeSent":
            self.requests.append(params["request"]["url"])
        elif method == "Runtime.exceptionThrown":
            details = params["exceptionDetails"]
            self.errors.append(details.get("exception", {}).get("description") or details["text"])
        elif method == "Log.entryAdded" and params["entry"]["level"] == "error":
            self.errors.append(f"{params['entry']['text']} {params['entry'].get('url', '')}")

    def open(self, address):
        self.ask("Page.navigate", url=address)

    def js(self, text):
        """Return the value of an expression in the page; promises are awaited."""
        done = self.ask("Runtime.evaluate", expression=text, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in done:
            raise NotDoneError(done["exceptionDetails"].get("exception", {}).get("description", text))
        return done["result"].get("value")

    def until(self, text, seconds=30.0):
        """Wait until an expression is true."""
        self.found(f"Boolean({text}) || null", seconds)

    def found(self, text, seconds=30.0):
        """Return the value of an expression as soon as it is not null."""
        end = time.monotonic() + seconds
        while True:
            try:
                if (value := self.js(text)) is not None:
                    return value
            except NotDoneError:  # the page is being loaded
                pass
            if time.monotonic() > end:
                shown = self.js("document.body.innerText.slice(0, 3000)")
                raise NotDoneError(f"not within {seconds:g} s: {text}\n{shown}")
            time.sleep(0.05)

    def front(self):
        """Be the tab that is looked at."""
        self.ask("Page.bringToFront")

    def wide(self, width, height=900, dark=False):
        self.ask("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)
        scheme = [{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]
        self.ask("Emulation.setEmulatedMedia", features=scheme)

    def place(self, selector):
        """Return the middle of an element that is scrolled into view."""
        return self.found(MIDDLE % f"document.querySelector({json.dumps(selector)})")

    def mouse(self, kind, x, y, **more):
        self.ask("Input.dispatchMouseEvent", type=kind, x=x, y=y, **({"button": "left", "clickCount": 1} | more))

    def click(self, selector):
        self.press(*self.place(selector))

    def press(self, x, y):
        """Press and let go of the mouse where nothing but a place is known."""
        self.clicks += 1
        self.mouse("mousePressed", x, y)
        self.mouse("mouseReleased", x, y)

    def click_text(self, text, inside="body"):
        """Click the button or link with this text."""
        wanted = json.dumps(f"{inside} button, {inside} a")
        named = f"one => one.textContent.trim() === {json.dumps(text)} && !one.disabled"
        self.press(*self.found(MIDDLE % f"[...document.querySelectorAll({wanted})].find({named})"))

    def drag(self, selector, start, end):
        """Drag over an element, between shares of its width."""
        x, y = self.place(selector)
        width = self.js(f"document.querySelector({json.dumps(selector)}).getBoundingClientRect().width")
        left = x - width / 2
        self.clicks += 1
        self.mouse("mousePressed", left + start * width, y)
        for share in (0.3, 0.6, 1.0):
            self.mouse("mouseMoved", left + (start + share * (end - start)) * width, y, buttons=1)
        self.mouse("mouseReleased", left + end * width, y)

    def key(self, key, **more):
        text = key if len(key) == 1 else None
        given = {"key": key, **more} | ({"text": text} if text and not more.get("modifiers") else {})
        if key == "Enter":
            given |= {"text": "\r", "windowsVirtualKeyCode": 13}
        if key == "Tab":
            given |= {"windowsVirtualKeyCode": 9}
        if key == " ":
            given |= {"windowsVirtualKeyCode": 32}
        self.ask("Input.dispatchKeyEvent", type="keyDown", **given)
        self.ask("Input.dispatchKeyEvent", type="keyUp", key=key)

    def type(self, selector, text):
        self.click(selector)
        self.js(f"document.querySelector({json.dumps(selector)}).select()")
        self.ask("Input.insertText", text=text)
        self.key("Tab")

    def choose(self, selector, value):
        """Choose in a list as a keyboard does; counts as one act."""
        self.clicks += 1
        self.until(f"document.querySelector({json.dumps(selector)}) !== null")
        self.js(
            f"(() => {{ const one = document.querySelector({json.dumps(selector)}); one.value = {json.dumps(value)}; "
            "one.dispatchEvent(new Event('change', {bubbles: true})); })()"
        )

    def give(self, selector, files):
        """Choose files in a dialog."""
        self.clicks += 1
        self.until(f"document.querySelector({json.dumps(selector)}) !== null")
        root = self.ask("DOM.getDocument")["root"]["nodeId"]
        node = self.ask("DOM.querySelector", nodeId=root, selector=selector)["nodeId"]
        self.ask("DOM.setFileInputFiles", nodeId=node, files=[str(one) for one in files])

    def shot(self, path, whole=True):
        done = self.ask("Page.captureScreenshot", format="png", captureBeyondViewport=whole)
        path.write_bytes(base64.b64decode(done["data"]))


class Program:
    """A browser; messages go through two pipes, each ended by a zero."""

    def __init__(self, folder):
        down, self.into = os.pipe()
        self.out, up = os.pipe()
        command = [browser(), "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
                   "--remote-debugging-pipe", "--no-first-run", "--hide-scrollbars", "--disable-background-networking",
                   f"--host-resolver-rules={ANY_HOST}", f"--user-data-dir={folder / 'driven profile'}"]  # fmt: skip
        self.process = subprocess.Popen(
            [sys.executable, "-c", LAUNCHER, str(down), str(up), *command], pass_fds=(down, up),
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        os.close(down)
        os.close(up)
        self.numbers, self.waiting, self.pages = itertools.count(1), {}, {}
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self):
        rest = b""
        while True:
            try:
                some = os.read(self.out, 1 << 20)
            except OSError:
                return
            if not some:
                return
            *whole, rest = (rest + some).split(b"\0")
            for text in whole:
                message = json.loads(text)
                if "id" in message:
                    self.waiting.pop(message["id"]).put(message)
                elif page := self.pages.get(message.get("sessionId")):
                    page.heard(message["method"], message["params"])

    def ask(self, page, method, given):
        number, answer = next(self.numbers), queue.Queue()
        self.waiting[number] = answer
        message = {"id": number, "method": method, "params": given}
        if page is not None:
            message["sessionId"] = page.session
        os.write(self.into, json.dumps(message).encode() + b"\0")
        reply = answer.get(timeout=300)
        if "error" in reply:
            raise NotDoneError(f"{method}: {reply['error']}")
        return reply["result"]

    def page(self, address, ready="document.body && document.body.dataset.ready"):
        """Open a page in a tab of its own, and wait until it is ready."""
        page = Page(self)
        target = self.ask(None, "Target.createTarget", {"url": "about:blank"})["targetId"]
        page.session = self.ask(None, "Target.attachToTarget", {"targetId": target, "flatten": True})["sessionId"]
        self.pages[page.session] = page
        for room in ("Page", "Runtime", "Network", "Log", "DOM"):
            page.ask(f"{room}.enable")
        page.wide(1280)
        page.open(address)
        page.until(ready)
        return page

    def close(self):
        self.process.terminate()
        self.process.wait(timeout=20)
        os.close(self.into)
        os.close(self.out)


@contextmanager
def driven(folder):
    """Give a browser that is driven, with a profile of its own in a folder."""
    program = Program(folder)
    try:
        yield program
    finally:
        program.close()
