"""Chromium without a window, steered over a pipe by the DevTools protocol: what a page does, not what it says it does."""

from __future__ import annotations

import base64
import fcntl
import json
import os
import shutil
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, BinaryIO

PROGRAMS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")


def program() -> str | None:
    """Where Chromium is; None if it is nowhere."""
    return next((path for path in map(shutil.which, PROGRAMS) if path), None)


@dataclass
class Browser:
    """One page of a browser."""

    commands: BinaryIO
    answers: BinaryIO
    session: str = ""
    sent: int = 0
    events: list[dict[str, Any]] = field(default_factory=list)

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """A command of the protocol, and its result; events that come before it are kept."""
        self.sent += 1
        message = {"id": self.sent, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        self.commands.write(json.dumps(message).encode() + b"\0")
        self.commands.flush()
        while True:
            answer = self._next()
            if answer.get("id") == self.sent:
                assert "error" not in answer, (method, answer)
                return dict(answer["result"])

    def _next(self) -> dict[str, Any]:
        """The next message; if it is an event it is kept as well."""
        text = bytearray()
        while (byte := self.answers.read(1)) != b"\0":
            assert byte, "the browser is gone"
            text += byte
        message: dict[str, Any] = json.loads(text)
        if "method" in message:
            self.events.append(message)
        return message

    def open(self, page: Path | str) -> None:
        """Load a page, a file or an address, and wait until it is there."""
        self.events.clear()
        self.call("Page.navigate", url=page if isinstance(page, str) else page.resolve().as_uri())
        while not any(event["method"] == "Page.loadEventFired" for event in self.events):
            self._next()

    def value(self, script: str) -> Any:
        """The value of an expression in the page, after the frame that is being drawn."""
        waited = f"new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done({script}))))"
        answer = self.call("Runtime.evaluate", expression=waited, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in answer, answer
        return answer["result"].get("value")

    def press(self, key: str, code: int, text: str = "") -> None:
        """A key of the keyboard, down and up."""
        for kind in ("keyDown", "keyUp"):
            typed = {"text": text} if text and kind == "keyDown" else {}
            self.call("Input.dispatchKeyEvent", type=kind, key=key, code=key, windowsVirtualKeyCode=code, **typed)

    def choose(self, element: str, file: Path) -> None:
        """Choose a file in an element."""
        root = self.call("DOM.getDocument")["root"]["nodeId"]
        node = self.call("DOM.querySelector", nodeId=root, selector=element)["nodeId"]
        self.call("DOM.setFileInputFiles", nodeId=node, files=[str(file.resolve())])

    def complaints(self) -> list[str]:
        """Everything that the console or the network has to say about the page."""
        self.value("0")
        kinds = ("Runtime.exceptionThrown", "Runtime.consoleAPICalled", "Log.entryAdded")
        return [json.dumps(event["params"]) for event in self.events if event["method"] in kinds]

    def requests(self) -> list[str]:
        """The addresses that the page asked for."""
        asked = [x["params"]["request"]["url"] for x in self.events if x["method"] == "Network.requestWillBeSent"]
        return [url for url in asked if not url.startswith("data:")]

    def screenshot(self, path: Path, width: int = 1280, height: int = 900, *, dark: bool = False) -> None:
        """A picture of the whole page."""
        self.look(width, height, dark=dark)
        shot = self.call("Page.captureScreenshot", captureBeyondViewport=True)
        path.write_bytes(base64.b64decode(shot["data"]))

    def look(self, width: int, height: int = 900, *, dark: bool = False) -> None:
        """The size of the window, and whether the reader prefers the dark."""
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.call("Emulation.setEmulatedMedia", features=[scheme])
        tall = self.call("Page.getLayoutMetrics")["cssContentSize"]["height"]
        self.call(
            "Emulation.setDeviceMetricsOverride", width=width, height=int(tall), deviceScaleFactor=1, mobile=False
        )

    def printed(self) -> bytes:
        """The page as PDF."""
        return base64.b64decode(self.call("Page.printToPDF", preferCSSPageSize=True, printBackground=True)["data"])


@contextmanager
def running() -> Iterator[Browser]:
    """A browser with one empty page, ended when the block ends."""
    found = program()
    assert found
    to_browser, commands = os.pipe()
    answers, from_browser = os.pipe()
    with TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        process = _started(found, profile, to_browser, from_browser)
        try:
            with os.fdopen(commands, "wb") as sending, os.fdopen(answers, "rb") as receiving:
                yield _page(Browser(sending, receiving))
        finally:
            os.kill(process, signal.SIGTERM)
            os.waitpid(process, 0)


def _started(found: str, profile: str, to_browser: int, from_browser: int) -> int:
    """The number of a new process; it reads commands from descriptor 3 and answers on 4."""
    options = ["--headless=new", "--remote-debugging-pipe", "--no-sandbox", "--disable-gpu", "--no-first-run",
               "--disable-background-networking", "--disable-dev-shm-usage", f"--user-data-dir={profile}"]  # fmt: skip
    reading, writing = (
        fcntl.fcntl(x, fcntl.F_DUPFD, 10) for x in (to_browser, from_browser)
    )  # out of the way of 3 and 4
    actions = [(os.POSIX_SPAWN_OPEN, x, os.devnull, os.O_RDWR, 0) for x in (0, 1, 2)]
    actions += [(os.POSIX_SPAWN_DUP2, reading, 3), (os.POSIX_SPAWN_DUP2, writing, 4)]
    process = os.posix_spawn(found, [found, *options], os.environ, file_actions=actions)
    for descriptor in (to_browser, from_browser, reading, writing):
        os.close(descriptor)
    return process


def _page(browser: Browser) -> Browser:
    target = browser.call("Target.createTarget", url="about:blank")["targetId"]
    browser.session = browser.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
    for domain in ("Page", "Runtime", "Log", "Network"):
        browser.call(f"{domain}.enable")
    return browser
