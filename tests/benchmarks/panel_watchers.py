"""Load of the panel by many screens while rigs record: see docs/evidence/panel.md.

    python tests/benchmarks/panel_watchers.py [values | two] [seconds]

Not a test: it takes a minute of real time, or two. A panel is served with two rigs, each with a
process of its own. A Chromium and 49 WebSocket clients watch one of them: with `values` it reads
200 channels at 10 Hz and waits at a question, while the other one records 4 channels at 100 kS/s;
with `two` both record, and 25 clients watch each. The load of the panel is the processor time of
its process over the time by the clock; the device reports how many samples it made.
"""

from __future__ import annotations

import asyncio
import os
import shutil
import sys
import tempfile
import time
from multiprocessing import get_context
from pathlib import Path

import h5py
from playwright.sync_api import sync_playwright
from websockets.asyncio.client import connect

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from benchmarks import fast_tester, many_channels
from benchmarks.panel import tell
from e2e.helpers_panel import Screen, process_is_gone, ready, served, started_by
from e2e.panel.helpers_screen import browser_path
from helpers_workflow import edited
from rigrunner.run.locate import shipped_folder

CLIENTS = 49
RATE = 100_000
FAST = """plugin: fast_tester
    settings:
      frequency_rate: 100 Hz/s
      load_rate: 5000 N/s
      block_samples: 10000
      sensors: {rate: 100 kHz}"""
RECORD = """\
rigrunner: procedure/2
id: RECORD
revision: "A"
title: One long recording
measurand: {symbol: Td, name: torque, unit: N·m}
uses: {tester: swing_tester}
main:
  - set: {tester.frequency: 10 Hz}
  - record:
      channels: [tester.angle, tester.torque, tester.velocity, tester.load]
      duration: SECONDS s
"""
MANY = """\
rigrunner: station/1
id: many
title: An instrument with 200 channels
devices: {meter: {type: many_channels, plugin: many_channels}}
plugins: plugins
"""
WAIT = """\
rigrunner: procedure/2
id: WAIT
revision: "A"
title: A question while channels are read
measurand: {symbol: F, name: force, unit: N}
uses: {meter: many_channels}
main:
  - confirm: {text: Go on?}
  - measure: {name: force, channels: [meter.c000], duration: 2 s}
"""
COUNT = """async () => {
    const { listen } = await import("/js/store.js");
    window.counted = 0;
    listen((changed) => { if (changed.has("channels")) window.counted += 1; });
}"""


def lab(folder, seconds):
    """Make a lab with three rigs and two procedures; return its runs."""
    (folder / "plugins").mkdir()
    for plugin in (fast_tester, many_channels):
        shutil.copy(plugin.__file__, folder / "plugins")
    for name in ("fast", "other"):
        edited(
            shipped_folder() / "stations" / "simulated.yaml",
            folder / f"{name}.yaml",
            plugin=("plugin: swing_tester_sim\n    settings: {seed: 1}", FAST),
            folder=("id: simulated\n", f"id: {name}\nplugins: plugins\n"),
        )
    (folder / "many.yaml").write_text(MANY, encoding="utf-8")
    (folder / "record.yaml").write_text(RECORD.replace("SECONDS", str(seconds)), encoding="utf-8")
    (folder / "wait.yaml").write_text(WAIT, encoding="utf-8")
    return folder / "runs"


def watch(address, rigs, totals):
    """Run the clients, which read all messages; count the updates of channels and the bytes."""

    async def follow(number):
        query = f"client=watcher-{number:04d}&rig={rigs[number % len(rigs)]}"
        async with connect(f"{address}/api/v1/events?{query}", max_size=None) as screen:
            async for message in screen:
                with totals.get_lock():
                    totals[0] += len(message)
                    totals[1 + number] += isinstance(message, str) and '"channels":' in message

    async def follow_all():
        await asyncio.gather(*(follow(number) for number in range(CLIENTS)), return_exceptions=True)

    asyncio.run(follow_all())


def cpu_s(pid):
    """Return the processor time of a process, of user and system, in seconds."""
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def start(screen, procedure, station):
    """Start a run, and wait for its question or its recording."""
    pair = ready(screen, procedure, station)
    screen.post("run/start", 202, **pair, inputs={})
    screen.until(lambda state: state["prompt"] or (state["progress"] or {}).get("recording"))


def finish(screen):
    """Wait for the end; return the samples made, those stored per channel, and the delay."""
    finished = screen.until(lambda state: state["phase"] == "finished", 600)["finished"]
    assert finished["outcome"] == "completed", finished
    with h5py.File(Path(finished["folder"]) / "run.h5") as file:
        (group,) = file["entry/recordings"].values()
        produced = int(group["conditions/tester_produced"][()])
        names = ("angle", "torque", "velocity", "load")
        counts = [group[f"tester_{name}"].shape[0] for name in names]
        return produced, counts, float(group["conditions/tester_late"][()])


def measure_load(mode, seconds):
    """Serve the panel, watch it, and print its load."""
    recording = ["fast.yaml", "other.yaml"] if mode == "two" else ["fast.yaml"]
    watched = recording if mode == "two" else ["many.yaml"]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        runs = lab(folder, seconds)
        with served(folder, runs) as server, sync_playwright() as playwright:
            screens = {rig: Screen(server, f"client-{rig[:4]}-1", rig) for rig in
                       dict.fromkeys([*watched, *recording])}  # fmt: skip
            spawn = get_context("spawn")
            totals = spawn.Array("Q", 1 + CLIENTS)
            address = server.address.replace("http", "ws", 1)
            clients = spawn.Process(target=watch, args=(address, watched, totals))
            clients.start()
            flags = ["--no-sandbox", "--disable-gpu"]
            browser = playwright.chromium.launch(executable_path=browser_path(), args=flags)
            page = browser.new_page(viewport={"width": 1280, "height": 720})
            if mode == "values":
                start(screens["many.yaml"], "wait.yaml", "many.yaml")
            page.goto(f"{server.address}/?rig={watched[0]}#/run")
            page.wait_for_selector("header .chip:not(.disconnected)")
            page.evaluate(COUNT)
            for rig in recording:
                start(screens[rig], "record.yaml", rig)
            watchers = (CLIENTS + 1) // len(watched)
            for rig in watched:
                screens[rig].until(lambda state: state["watchers"] >= watchers)
            children = started_by(server.process.pid)
            began, used = time.monotonic(), cpu_s(server.process.pid)
            others = {pid: cpu_s(pid) for pid in children}
            before, counted = list(totals), page.evaluate("counted")
            page.wait_for_timeout(1000 * (seconds - 8))
            took_s = time.monotonic() - began
            share = (cpu_s(server.process.pid) - used) / took_s
            after, counted = list(totals), page.evaluate("counted") - counted
            for pid, command in children.items():
                part = "rig" if "jobs.main" in command else "analyst"
                tell(f"  process of the {part}: {100 * (cpu_s(pid) - others[pid]) / took_s:.0f} %")
            updates = sorted(b - a for a, b in zip(before[1:], after[1:], strict=True))
            size = (after[0] - before[0]) / 1e6
            tell(f"{mode}: {took_s:.0f} s, the panel {100 * share:.1f} % of a core; updates of"
                 f" channels {updates[0]} to {updates[-1]} per client, {counted} in Chromium;"
                 f" {size:.0f} MB to the clients")  # fmt: skip
            browser.close()
            for rig in recording:
                produced, counts, late_s = finish(screens[rig])
                lost = [produced - count for count in counts]
                tell(f"{rig}: {produced:,} samples made, lost {lost}; fetched at most"
                     f" {1e3 * late_s:.0f} ms late")  # fmt: skip
            clients.terminate()
            for screen in screens.values():
                screen.close()
        process_is_gone(server.process.pid)


if __name__ == "__main__":
    arguments = sys.argv[1:] or ["values"]
    measure_load(arguments[0], int((arguments[1:] or ["40"])[0]))
