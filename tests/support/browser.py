"""Chromium without a window, driven by its DevTools protocol: what a page shows, and presses.

The protocol needs the library `websockets` alone, which viser brings along. Playwright would bring
a browser, or another one, and Node.js with it.
"""

import base64
import itertools
import json
import os
import shutil
import signal
import subprocess
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from websockets.sync.client import connect
from websockets.sync.connection import Connection

from support.waiting import wait_until

__all__ = ["Browser", "browser", "chromium"]

_FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-dev-shm-usage",
    # WebGL on a machine without a graphics processor.
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    # Nothing leaves the machine.
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--remote-debugging-port=0",
)
# A processor draws each pixel.
_SIZE = (860, 640)
_TIMEOUT_MS = 25_000
_TEXT = (
    "[document.body?.innerText ?? '',"
    " ...[...document.querySelectorAll('input')].map(one => one.value)].join('\\n')"
)
_BUTTONS = (
    "[...document.querySelectorAll('button')].filter(one => one.offsetParent)"
    ".map(one => one.innerText.trim())"
)


def chromium() -> str | None:
    """The path of Chromium, or None where it is not installed."""
    names = ("chromium", "chromium-browser", "google-chrome")
    return next((path for name in names if (path := shutil.which(name))), None)


class PageLoadedError(Exception):
    """The page was loaded again before its script had ended."""


class Browser:
    """A page in a browser."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._numbers = itertools.count(1)
        width, height = _SIZE
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self.ask("Emulation.setDeviceMetricsOverride", **size)

    def ask(self, method: str, **parameters: Any) -> Any:
        """Calls a method of the protocol; events are left out."""
        number = next(self._numbers)
        self._connection.send(json.dumps({"id": number, "method": method, "params": parameters}))
        while True:
            answer = json.loads(self._connection.recv(timeout=60))
            if answer.get("id") == number:
                if "navigated" in answer.get("error", {}).get("message", ""):
                    raise PageLoadedError
                assert "result" in answer, answer
                return answer["result"]

    def open(self, url: str) -> None:
        self.ask("Page.navigate", url=url)

    def run(self, script: str) -> Any:
        """Gives the value of a JavaScript expression in the page, or that of its promise."""
        found = self.ask(
            "Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True
        )
        assert "exceptionDetails" not in found, found
        return found["result"].get("value")

    @property
    def text(self) -> str:
        """The text that the page shows, and the values of its inputs."""
        return str(self.run(_TEXT))

    def until(self, *texts: str) -> None:
        """Waits until the page shows all of these texts."""
        self.until_true(f"{json.dumps(texts)}.every(one => ({_TEXT}).includes(one))", str(texts))

    def until_true(self, condition: str, what: str) -> None:
        """Waits until an expression is true; the page looks itself, ten times a second.

        If the page is loaded again meanwhile, the new one looks.
        """
        script = f"""new Promise(resolve => {{
            const end = Date.now() + {_TIMEOUT_MS};
            const look = () => {condition} ? resolve(true)
                : Date.now() > end ? resolve(false) : setTimeout(look, 100);
            look();
        }})"""
        while True:
            try:
                assert self.run(script), f"waited for {what}, not only {self.text!r}"
            except PageLoadedError:
                continue
            return

    @property
    def buttons(self) -> set[str]:
        """The labels of the buttons that the page shows."""
        return set(self.run(_BUTTONS)) - {""}

    def until_buttons(self, *labels: str) -> None:
        """Waits until the page shows these buttons and no others."""
        shown = f"{_BUTTONS}.filter(one => one).sort().join()"
        self.until_true(f"{shown} === {json.dumps(','.join(sorted(labels)))}", str(labels))

    def press(self, label: str) -> None:
        """Presses the button, or the option of an open drop-down, with that label."""
        script = (
            "[...document.querySelectorAll('button, [role=option]')]"
            f".filter(one => one.innerText.trim() === {json.dumps(label)})[0].click()"
        )
        self.run(script)

    def choose(self, before: str, label: str) -> None:
        """Opens the drop-down that shows the one label, and chooses the other."""
        self.run(
            "[...document.querySelectorAll('input')]"
            f".filter(one => one.value === {json.dumps(before)})[0].click()"
        )
        options = "[...document.querySelectorAll('[role=option]')].map(one => one.innerText)"
        self.until_true(f"{options}.includes({json.dumps(label)})", f"the option {label}")
        self.press(label)

    def hide(self, selector: str) -> None:
        """Hides the elements of a selector, and those that come later."""
        rule = json.dumps(f"{selector} {{ display: none !important }}")
        self.run(
            "document.head.append("
            f"Object.assign(document.createElement('style'), {{textContent: {rule}}})) ?? 0"
        )

    def screenshot(self) -> bytes:
        """What the page looks like, as PNG."""
        return base64.b64decode(self.ask("Page.captureScreenshot", format="png")["data"])


@contextmanager
def browser(folder: Path) -> Iterator[Browser]:
    """Runs a browser with an empty page. Nothing of it is left at the end."""
    path = chromium()
    assert path is not None, "Chromium is not installed"
    profile = folder / "chromium"
    process = subprocess.Popen(
        [path, *_FLAGS, f"--user-data-dir={profile}", "about:blank"],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        # Its processes are a group, so that all of them are ended.
        start_new_session=True,
    )
    try:
        with connect(_page_of(profile), max_size=None, proxy=None) as connection:
            yield Browser(connection)
    finally:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        # Its processes may still write to it for a moment.
        shutil.rmtree(profile, ignore_errors=True)


def _page_of(profile: Path) -> str:
    """The address of the page's socket."""
    told = profile / "DevToolsActivePort"
    wait_until(lambda: told.exists() and len(told.read_text().split()) == 2, "Chromium")
    port = told.read_text().split()[0]
    pages: list[Any] = []

    def found() -> bool:
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/json") as answer:
            pages[:] = [one for one in json.load(answer) if one["type"] == "page"]
        return bool(pages)

    wait_until(found, "a page")
    return str(pages[0]["webSocketDebuggerUrl"])
