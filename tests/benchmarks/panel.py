"""Delays of the panel for STOP and samples, and its memory: see docs/evidence/panel.md.

    python tests/benchmarks/panel.py stop [times] | frames | memory [hours] | hours [hours]

Not a test: it takes minutes, of real time. `stop` and `frames` serve a panel and run the shipped
procedure on the simulated station in real time; `memory` feeds the server's part of a panel with
the blocks of some hours; `hours` does a run of some hours in simulated time, which needs 0.3 GB of
disk per hour.
"""

from __future__ import annotations

import random
import sys
import tempfile
import threading
import time
from datetime import datetime
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from e2e.helpers_panel import INPUTS, Screen, ready, rig_process, served
from helpers_workflow import quick_procedure, run, station_file
from rigrunner.api.data import Block
from rigrunner.api.events import RunStarted, Samples, StepEnded, StepStarted
from rigrunner.clock import SimulatedClock
from rigrunner_panel.live.story import Story
from rigrunner_panel.process.messages import Show
from rigrunner_panel.view.board import Board
from rigrunner_panel.view.sections import JobView, PlanView, StepView

LOADED = "starting_torque_1000n.yaml"


def tell(text):
    """Print and flush a line."""
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


def lab(folder):
    """Make a lab folder with short set-ups and a no-load run."""
    no_load = quick_procedure(folder, "no_load_inertia_sweep")
    quick_procedure(folder, "starting_torque_1000n", ("cycles: 100}", "cycles: 5}"))
    run(no_load, folder / "runs", station=station_file(folder), clock=SimulatedClock())
    return folder


def started(screen):
    """Start the loaded run and answer its prompt."""
    pair = ready(screen, LOADED)
    screen.post("run/start", 202, **pair, inputs=INPUTS)
    screen.answer()


def stop(times):
    """Stop runs after a random time; print the time of each part in milliseconds."""
    rows = []
    with tempfile.TemporaryDirectory() as tmp, served(lab(Path(tmp)), Path(tmp) / "runs") as panel:
        screen = Screen(panel, "client-bench-1")
        for _ in range(times):
            started(screen)
            time.sleep(random.uniform(0.0, 8.0))  # noqa: S311  (no secret)
            step = screen.events[-1]["text"].split(":")[0].split(".")[-1]
            posted_s = time.time()
            screen.post("stop")
            answered_s = time.time()
            screen.phase("finished")
            events = [entry["event"] for entry in screen.events[::-1]]
            at = {event.get("action", event["event"]): seconds(event["utc"]) for event in events}
            moments_s = (answered_s, at["abort"], at["MadeSafe"])
            rows.append([1e3 * (moment_s - posted_s) for moment_s in moments_s])
            tell(f"{step:10}" + "".join(f"{duration_ms:9.1f}" for duration_ms in rows[-1]))
        screen.close()
    columns = zip(*rows, strict=True)
    for what, values in zip(("answered", "acted", "first drive safe"), columns, strict=True):
        tell(f"{what:18} median {np.median(values):7.1f} ms, greatest {max(values):7.1f} ms")


def seconds(utc):
    """Return a time of day as seconds."""
    return datetime.fromisoformat(utc).timestamp()


def frames():
    """Print the rate of swing frames, and the age of their last sample on arrival."""
    with tempfile.TemporaryDirectory() as tmp, served(lab(Path(tmp)), Path(tmp) / "runs") as panel:
        screen, arrivals = Screen(panel, "client-bench-1"), {}
        take = screen._take

        def timed(message):
            take(message)
            if isinstance(message, bytes) and screen.frames[-1][0]["kind"] == "curve":
                header, _ = screen.frames[-1]
                now = time.monotonic()
                age_s = now - header["monotonic_s"]
                arrivals.setdefault(header["recording"], []).append((now, age_s))

        screen._take = timed
        started(screen)
        screen.phase("finished")
        screen.close()
    for recording, times in arrivals.items():
        arrived, ages = np.array(times).T
        rate = (len(arrived) - 1) / np.ptp(arrived)
        tell(f"{recording:10} {rate:5.1f} swings/s shown; age at arrival median"
              f" {1e3 * np.median(ages):6.1f} ms, greatest {1e3 * ages.max():6.1f} ms")  # fmt: skip


class _NoLinks:
    def picture(self, path):
        return path

    def run_links(self, _run):
        return ()


def memory(hours):
    """Feed a story with blocks of 0.1 s at 10 kHz, three channels; print its memory hourly."""
    steps = tuple(
        StepView(index=i, path=f"main[{i}]", phase="main", action="record", text="", point=str(i),
                 estimated_s=60.0)
        for i in range(60 * hours)
    )  # fmt: skip
    board = Board()
    job = JobView(kind="run", procedure="p", station="s")
    story = Story(board, job, _NoLinks())
    story.take(Show({"plan": PlanView(estimated_s=3600.0 * hours, steps=steps)}))
    times = {"monotonic_s": 0.0, "utc": "2026-03-01T12:00:00.000Z"}
    start = RunStarted(seq=0, run_id="R", steps=len(steps), estimated_s=3600.0 * hours, **times)
    story.take(start)
    phase = 2 * np.pi * 20.0 * np.arange(1000) / 1e4
    channels = {
        f"t.{name}": np.sin(phase).astype(np.float32) for name in ("torque", "angle", "load")
    }
    began_s = time.monotonic()
    for i in range(len(steps)):
        step = {"step": f"main[{i}]", "index": i, "action": "record", "recording": f"{i:03d}"}
        story.take(StepStarted(seq=2 * i + 1, text="record", **step, **times))
        for block in range(600):
            end_s = 60.0 * i + 0.1 * (block + 1)
            fields = {"monotonic_s": end_s, "utc": times["utc"], "recording": f"{i:03d}"}
            story.take(Samples(seq=0, block=Block(1e4, 1000 * block, end_s, channels), **fields))
            while story.curves.next_curve() is not None:
                pass
            story.curves.next_trend()
            board.delta()
        story.take(StepEnded(seq=2 * i + 2, ok=True, **step, **times))
        if (i + 1) % 60 == 0:
            wall_s = time.monotonic() - began_s
            size = len(board.state("x"))
            tell(f"{(i + 1) // 60} h: {resident_mb():6.1f} MB, state {size} bytes, {wall_s:.0f} s")


LONGEST_S = 600.0
LONG = """\
rigrunner: procedure/2
id: LONG
revision: "A"
title: A recording each minute
measurand: {symbol: Td, name: torque, unit: N·m}
uses: {tester: swing_tester}
main:
  - set: {tester.frequency: 10 Hz}
  - repeat:
      times: TIMES
      steps:
        - record: {channels: [tester.angle, tester.torque, tester.velocity], duration: 60 s}
"""


def hours(number):
    """Do a run of some hours, 10 kHz and three channels; print the memory of both processes."""
    with tempfile.TemporaryDirectory() as name:
        text = LONG.replace("TIMES", str(60 * number))
        (Path(name) / "long.yaml").write_text(text, encoding="utf-8")
        with served(Path(name), Path(name) / "runs") as server:
            screen = Screen(server, "client-bench-1")
            pair = ready(screen, "long.yaml", "simulated")
            screen.post("run/start", 202, **pair, inputs={}, realtime=False)
            screen.phase("running")
            pids = server.process.pid, rig_process(server)
            for hour in range(1, number + 1):
                screen.until(
                    lambda state, n=60 * hour: state["progress"]["states"].count("o") > n, 600
                )
                server_mb, run_mb = map(resident_mb, pids)
                tell(f"{hour} h: server {server_mb:.0f} MB, run {run_mb:.0f} MB")
                screen.frames.clear()
            tell(
                screen.until(lambda state: state["phase"] == "finished", 600)["finished"]["outcome"]
            )
            screen.close()


def resident_mb(pid="self"):
    """Return the resident memory of a process in MB."""
    text = Path(f"/proc/{pid}/status").read_text(encoding="utf-8")
    line = next(line for line in text.splitlines() if line.startswith("VmRSS"))
    return int(line.split()[1]) / 1024


if __name__ == "__main__":
    what, *numbers = sys.argv[1:] or ["stop"]
    threading.excepthook = lambda _: None
    {"stop": lambda: stop(int((numbers or ["10"])[0])), "frames": frames,
     "hours": lambda: hours(int((numbers or ["8"])[0])),
     "memory": lambda: memory(int((numbers or ["8"])[0]))}[what]()  # fmt: skip
