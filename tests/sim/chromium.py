"""Chromium without a window, for tests that look at pages as a reader does."""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import subprocess
import sys

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")
# a program that takes two pipes for its own 3 and 4, where Chromium looks for them, and becomes another
PIPES = """import fcntl, os, sys
for place, pipe in zip((3, 4), [fcntl.fcntl(int(pipe), fcntl.F_DUPFD, 10) for pipe in sys.argv[1:3]]):
    os.dup2(pipe, place)
os.execv(sys.argv[3], sys.argv[3:])"""
CHROMIUM = next((path for name in NAMES if (path := shutil.which(name))), None)


class Browser:
    """Chromium without a window, spoken to over its debugging pipe; `said`: its console, `fetched`: its requests."""

    def __init__(self, folder):
        read_in, self._write = os.pipe()
        self._read, write_out = os.pipe()
        options = "--headless --no-sandbox --disable-gpu --disable-dev-shm-usage --no-first-run --remote-debugging-pipe"
        self._process = subprocess.Popen(
            [sys.executable, "-c", PIPES, str(read_in), str(write_out), CHROMIUM, *options.split(),
             f"--user-data-dir={folder}"],
            pass_fds=(read_in, write_out), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        os.close(read_in)
        os.close(write_out)
        self._calls, self._rest, self._session, self.said, self._loaded = 0, b"", None, [], False
        self.fetched = []

    def open(self, path):
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")
        self._loaded = False
        self.call("Page.navigate", url=path.as_uri())
        while not self._loaded:
            self._next()

    def call(self, method, **params):
        self._calls += 1
        session = {"sessionId": self._session} if self._session else {}
        message = {"id": self._calls, "method": method, "params": params} | session
        os.write(self._write, json.dumps(message).encode() + b"\0")
        while (answer := self._next()).get("id") != self._calls:
            pass
        assert "error" not in answer, answer
        return answer["result"]

    def _next(self):
        while b"\0" not in self._rest:
            received = os.read(self._read, 1 << 20)
            assert received, "the browser ended"
            self._rest += received
        message, _, self._rest = self._rest.partition(b"\0")
        message = json.loads(message)
        self._loaded |= message.get("method") == "Page.loadEventFired"
        if message.get("method") in ("Runtime.exceptionThrown", "Runtime.consoleAPICalled", "Log.entryAdded"):
            self.said.append(message["params"])
        if message.get("method") == "Network.requestWillBeSent":
            self.fetched.append(message["params"]["request"]["url"])
        return message

    def value(self, expression):
        result = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in result, result
        return result["result"].get("value")

    def point(self, kind, x, y, **more):
        """A move, press or release of the mouse at a place of the window, or a turn of its wheel."""
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)

    def press(self, key, shift=False):
        text = {"text": key} if len(key) == 1 else {}
        kind = "keyDown" if text else "rawKeyDown"
        codes = {"ArrowLeft": 37, "ArrowRight": 39, "Home": 36, "End": 35, " ": 32}
        common = {"key": key, "windowsVirtualKeyCode": codes[key], "modifiers": 8 * shift}
        self.call("Input.dispatchKeyEvent", type=kind, **common, **text)
        self.call("Input.dispatchKeyEvent", type="keyUp", **common)

    def close(self):
        with contextlib.suppress(AssertionError, OSError):
            self.call("Browser.close")
        try:
            self._process.wait(20)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        os.close(self._write)
        os.close(self._read)
