"""The operator panel as its users see it: the program, a real Chromium, mouse and keyboard."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import time
import urllib.request
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from random import randrange
from urllib.parse import urlsplit

from playwright.sync_api import expect

from helpers_cli import call
from helpers_docs import ROOT
from helpers_lacking import lacking

WITHIN_S = 200.0
"""The longest wait for a panel or a browser: ten times what a busy machine needs."""
NO_LOAD = "Quick no-load sweep"
LOADED = "Quick starting torque"
ASKS = "Guarded sweep with a question"
ENDLESS = "Sweep that outlasts a test"
"""One point of a second, then points of minutes, so that a test has time to act."""
STATION = "Bench of these tests"
BENCH = "station.yaml"
"""The file of that station."""
OVERDUE = "Bench with an old certificate"
SIMULATED = "calibration: simulated"
OLD = "certificate: C-1\n    laboratory: L\n    calibrated: 2020-01-01\n    due: 2021-01-01"
NAME = "Ann Jones"


def wait_until(condition, what: str = "it") -> None:
    """Wait until a condition holds that cannot be seen on the page."""
    until_s = time.monotonic() + WITHIN_S
    while not condition():
        assert time.monotonic() < until_s, f"{what} never came"
        time.sleep(0.1)


SETTLED = """async () => {
  for (let frame = 0; frame < 3; frame++) await new Promise(requestAnimationFrame);
  const passing = document.getAnimations().filter(
    animation => Number.isFinite(animation.effect.getComputedTiming().endTime));
  await Promise.allSettled(passing.map(animation => animation.finished));
}"""


def settle(page) -> None:
    """Wait until the page has been laid out and drawn, and no transition is under way."""
    page.evaluate(SETTLED)


@dataclass
class Panel:
    """A running panel: its address, its lab and the process."""

    url: str
    folder: Path
    process: subprocess.Popen[str]

    @property
    def runs(self) -> Path:
        """The folder of its runs."""
        return self.folder / "runs"

    def get(self, path: str, station: str = BENCH) -> dict:
        """Return the answer of the API, for the rig of the station."""
        address = f"{self.url}api/v1/{path}?rig={station}"
        with urllib.request.urlopen(address, timeout=WITHIN_S) as answer:  # noqa: S310
            return json.load(answer)

    def phase(self, station: str = BENCH) -> str:
        """Return the phase of a rig."""
        return self.get("state", station)["phase"]

    def wait_for(self, *phases: str, station: str = BENCH) -> None:
        """Wait until a rig is in one of these phases."""
        wait_until(lambda: self.phase(station) in phases, f"a rig in {phases}")


@contextmanager
def running_panel(folder: Path, port: int = 0, options: tuple[str, ...] = ()):
    """Run `rigrunner panel` on a lab until the block ends."""
    command = [
        sys.executable, "-m", "rigrunner", "panel", "--no-browser", "--port", str(port),
        "--runs", str(folder / "runs"), "--procedures", str(folder),
        "--letterhead", str(folder / "letterhead"), *options,
    ]  # fmt: skip
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=folder
    ) as process:
        line = process.stdout.readline()
        url = re.search(r"http://\S+/", line)
        assert url, line + process.stdout.read()
        try:
            yield Panel(url[0], folder, process)
        finally:
            process.send_signal(signal.SIGTERM)
            process.communicate(timeout=WITHIN_S)


def quick_lab(folder: Path) -> None:
    """Make a lab with two procedures of seconds, a run of each, and an overdue bench."""
    assert call("init", folder).code == 0
    station = folder / "station.yaml"
    text = station.read_text(encoding="utf-8")
    titled = re.sub(r"^title: .*$", f"title: {STATION}", text, flags=re.MULTILINE)
    station.write_text(titled, encoding="utf-8")
    overdue = titled.replace(f"title: {STATION}", f"title: {OVERDUE}").replace(SIMULATED, OLD)
    overdue = overdue.replace("id: bench-1", "id: bench-old")
    (folder / "overdue.yaml").write_text(overdue, encoding="utf-8")
    shipped = folder / "procedures"
    no_load = (shipped / "no_load_inertia_sweep.yaml").read_text(encoding="utf-8")
    loaded = (shipped / "starting_torque_1000n.yaml").read_text(encoding="utf-8")
    (shipped / "quick_no_load.yaml").write_text(
        _quick(no_load, "SSPB-NLI", "QUICK-NL", NO_LOAD), encoding="utf-8"
    )
    quick = _quick(loaded, "SSPB-STT-1000", "QUICK-ST", LOADED)
    quick = quick.replace("procedure: SSPB-NLI", "procedure: QUICK-NL")
    quick = quick.replace("- settle: {cycles: 100}", "- settle: {cycles: 1}")
    (shipped / "quick_asks.yaml").write_text(_asks(quick), encoding="utf-8")
    quick = quick.replace("  - confirm:\n", "  - confirm:\n      picture: clamped.png\n", 1)
    shutil.copy(ROOT / "docs/images/report.png", shipped / "clamped.png")
    (shipped / "quick_endless.yaml").write_text(_endless(quick), encoding="utf-8")
    (shipped / "quick_torque.yaml").write_text(quick, encoding="utf-8")
    for procedure in ("quick_no_load.yaml", "quick_torque.yaml"):
        result = call(
            "run", shipped / procedure, "--station", station, "--runs", folder / "runs",
            "--unattended",
        )  # fmt: skip
        assert result.code == 0, result.err


def _quick(text: str, old_id: str, new_id: str, title: str) -> str:
    text = text.replace(f"id: {old_id}", f"id: {new_id}")
    text = re.sub(r"^title: .*$", f"title: {title}", text, flags=re.MULTILINE)
    text = re.sub(r"frequencies: \[.*\]", "frequencies: [10 Hz, 20 Hz, 30 Hz, 35 Hz]", text)
    return text.replace("cycles: 30", "cycles: 15")


def _endless(text: str) -> str:
    """Return a procedure whose first point takes a second, and the next ones minutes each."""
    text = text.replace("QUICK-ST", "QUICK-ENDLESS").replace(LOADED, ENDLESS)
    text = re.sub(r"frequencies: \[.*\]", "frequencies: [10 Hz]", text)
    sweep = text[text.index("  - sweep:\n") : text.index("teardown:")]
    long = sweep.replace("$frequencies", "[20 Hz, 30 Hz]").replace("cycles: 15", "cycles: 9000")
    assert long.count("9000}") == 1
    return text.replace(sweep, f"{sweep.rstrip()}\n{long}")


def _asks(text: str) -> str:
    """Return a procedure that asks for a number, and whose load trips an interlock."""
    text = text.replace("QUICK-ST", "QUICK-ASKS").replace(LOADED, ASKS)
    question = "text: Temperature of the room, into: room, unit: °C, min: 15 °C, max: 30 °C"
    asks = f"main:\n  - ask: {{{question}}}\n"
    heavy = (
        "interlocks:\n  - {name: heavy, channel: tester.load, above: 500 N, does: pause,"
        " overridable: yes}\n\n"
    )
    return text.replace("setup:\n", f"{heavy}setup:\n", 1).replace("main:\n", asks, 1)


def free_port() -> int:
    """Return a free port outside of the range of ephemeral ports."""
    for _ in range(100):
        port = randrange(10000, 30000)  # noqa: S311  (no secret)
        with suppress(OSError), socket.create_server(("127.0.0.1", port)):
            return port
    raise AssertionError("no port is free")


def browser_path() -> str:
    """Return Chromium, or skip: CI requires it."""
    path = shutil.which("chromium") or shutil.which("chromium-browser")
    if path is None:
        lacking("BROWSER", "there is no Chromium")
    return path


def require_driver() -> None:
    """Skip where the driver of Playwright does not start."""
    words = [sys.executable, "-m", "playwright", "--version"]
    process = subprocess.run(words, capture_output=True, text=True, check=False)
    if process.returncode != 0:
        lacking("BROWSER", f"Playwright does not start: {process.stderr.strip()}")


def axe_script() -> Path:
    """Return axe-core, or skip: CI requires it."""
    path = os.environ.get("RIGRUNNER_AXE", "")
    if not path:
        lacking("BROWSER", "RIGRUNNER_AXE does not name axe.min.js of axe-core")
    return Path(path)


def press_keys(page, text: str, interval_s: float) -> None:
    """Press keys and Enter with these intervals in their timestamps, even on a busy machine."""
    session, now_s = page.context.new_cdp_session(page), time.time()
    for number, key in enumerate([*text, "Enter"]):
        at = {"key": key, "timestamp": now_s + number * interval_s}
        down = {"text": key} if key != "Enter" else {"text": "\r", "windowsVirtualKeyCode": 13}
        session.send("Input.dispatchKeyEvent", {"type": "keyDown", **at, **down})
        session.send("Input.dispatchKeyEvent", {"type": "keyUp", **at})


class Screen:
    """One browser window at the panel, used as a person does."""

    def __init__(self, page, panel: Panel) -> None:
        self.page = page
        self.panel = panel
        self.strangers: list[str] = []
        self.errors: list[str] = []
        host = urlsplit(panel.url).netloc

        def look(request) -> None:
            parts = urlsplit(request.url)
            if parts.scheme in ("http", "https", "ws", "wss") and parts.netloc != host:
                self.strangers.append(request.url)

        page.on("request", look)
        page.on("websocket", lambda socket: self._look_at_socket(socket, host))
        page.on("pageerror", lambda error: self.errors.append(str(error)))

    def _look_at_socket(self, socket, host: str) -> None:
        if urlsplit(socket.url).netloc != host:
            self.strangers.append(socket.url)

    def open(self, place: str = "", station: str = BENCH) -> None:
        """Go to a page of a rig."""
        self.page.goto(f"{self.panel.url}?rig={station}{place}")
        self.page.wait_for_selector("header .chip:not(.disconnected)")

    def choose(self, procedure: str = LOADED, station: str = STATION) -> None:
        """Choose a procedure and a station, and continue."""
        self.page.wait_for_selector(".item")
        self.page.locator(".item", has_text=procedure).click()
        self.page.locator(".item", has_text=station).first.click()
        self.page.get_by_role("button", name="Next", exact=True).click()
        self.page.wait_for_selector(".preflight")

    def fill_in(self, specimen: str = "B-17", operator: str = NAME) -> None:
        """Answer what the procedure asks."""
        self.page.get_by_label("Bearing serial number").fill(specimen)
        if self.page.get_by_label("Bearing type").count():
            self.page.get_by_label("Bearing type").fill("GE20")
            self.page.get_by_label("Lot").fill("L-7")
        self.page.get_by_label("Your name").fill(operator)

    def say_name(self, name: str = NAME) -> None:
        """Enter the name of the person in control where it is asked for."""
        self.page.locator("#dialog-text").fill(name)
        self.page.keyboard.press("Enter")

    def hurry(self) -> None:
        """Let the simulated rig run faster than real time."""
        self.page.get_by_label("Real time").uncheck()

    def check_rig(self, *, ready: bool = True) -> None:
        """Do the first preflight; a name that was typed above is not asked for again."""
        check = self.page.locator(".preflight > .button")
        check.click()
        name = self.page.get_by_label("Your name")
        if not name.count() or not name.input_value():
            self.say_name()
        expect(check).to_have_text("Check again")
        if ready:
            self.page.get_by_text("Ready to start.").wait_for()

    def start(self) -> None:
        """Start and say yes to the first question."""
        self.page.get_by_role("button", name="Start", exact=True).click()
        self.page.locator(".prompt").get_by_role("button", name="Yes").click()

    def begin(self, procedure: str = LOADED, *, real_time: bool = True, **inputs: str) -> None:
        """Go all the way from choosing to the running page."""
        self.open()
        self.choose(procedure)
        self.fill_in(**inputs)
        if not real_time:
            self.hurry()
        self.check_rig()
        self.start()

    def focus_on(self, name: str, role: str = "", most: int = 80) -> None:
        """Press Tab until the element of that name has the focus."""
        for _ in range(most):
            self.page.keyboard.press("Tab")
            label, tag = self.page.evaluate(
                """() => {
                    const e = document.activeElement;
                    const label = e.labels && e.labels.length ? e.labels[0].textContent : '';
                    const text = e.getAttribute('aria-label') || label || e.textContent || '';
                    return [text.trim(), e.tagName];
                }"""
            )
            if re.match(name, label) and role in ("", tag):
                return
        raise AssertionError(f"Tab does not come to '{name}'")

    def wait_for_compensation(self) -> None:
        """Wait until a compensated torque is shown with its uncertainty."""
        torque = self.page.locator(".readout.compensated .readout-value")
        expect(torque).to_contain_text("±")

    def wait_for_result(self) -> None:
        """Wait until the run is over and its result is shown."""
        self.page.wait_for_url("**#/runs/*")
        self.page.wait_for_selector(".result-head")
