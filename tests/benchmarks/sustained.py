"""A run at 1 MS/s under the panel, observed from outside: memory, CPU, and the screen."""

from __future__ import annotations

import json
import os
import shutil
import time
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING

import h5py

from benchmarks import fast_tester
from benchmarks.frame import Figure, Spread, at_most
from e2e.helpers_panel import INPUTS, Screen, ready, served, started_by
from helpers_workflow import ALL_FREQUENCIES, edited, run
from rigrunner.clock import WallClock
from rigrunner.run.locate import find_procedure, shipped_folder

if TYPE_CHECKING:
    from collections.abc import Iterator

CHANNELS = "[tester.angle, tester.torque, tester.velocity, tester.load]"
NO_LOAD_HZ, LOADED_HZ = "[8 Hz, 10 Hz, 20 Hz, 30 Hz, 35 Hz]", "[10 Hz, 20 Hz]"
HZ, NO_LOAD_S, LONG_S = (10.0, 20.0), 1.5, 10
"""LONG_S: a recording in which the analyst has prepared the no-load run."""
SETTINGS = """plugin: fast_tester
    settings:
      seed: 1
      frequency_rate: 100 Hz/s
      load_rate: 5000 N/s
      sensors: {rate: 1000 kHz, spike_probability: 0.0002 %}"""
EVERY_S, PATIENCE_S = 0.1, 1800.0
PARTS = {"panel": "-c ", "run": "panel.jobs.main", "analyst": "panel.live.analyst"}
RAW_BYTES = 4 * 8
MB, MS = 1e6, 1e3


@dataclass
class Observation:
    """One observation of the run: time, memory and CPU time per process, and the live value."""

    at_s: float
    recording: str
    memory_mb: dict[str, float]
    cpu_s: dict[str, float]
    value: float | None = None
    """Of the recording in progress, from its latest cycles."""


def figures(lab: Path, seconds: int) -> list[Figure]:
    """Do the run, with two recordings of some seconds each, and return its figures."""
    runs = make_lab(lab, seconds)
    with served(lab, runs) as server:
        screen = Screen(server, "client-bench-1")
        pair = ready(screen, "starting_torque_1000n.yaml")
        screen.post("run/start", 202, **pair, inputs=INPUTS)
        screen.answer()
        looks = list(watch(screen, server.process.pid))
        finished = screen.until(lambda state: state["phase"] == "finished", PATIENCE_S)["finished"]
        screen.close()
    assert finished["outcome"] == "completed", finished
    curves = [header for header, _ in screen.frames if header["kind"] == "curve"]
    return figures_of(Path(finished["folder"]), looks, curves, seconds)


def make_lab(lab: Path, seconds: float) -> Path:
    """Make a lab with the fast tester, its two procedures, and a no-load run; return its runs."""
    (lab / "plugins").mkdir(parents=True)
    shutil.copy(fast_tester.__file__, lab / "plugins" / "fast_tester.py")
    station = edited(
        shipped_folder() / "stations" / "simulated.yaml",
        lab / "station.yaml",
        plugin=("plugin: swing_tester_sim\n    settings: {seed: 1}", SETTINGS),
        folder=("id: simulated\n", "id: simulated\nplugins: plugins\n"),
    )
    record = "record: {channels: [tester.angle, tester.torque], cycles: 30}"
    for name, frequencies, length in (
        ("no_load_inertia_sweep", NO_LOAD_HZ, NO_LOAD_S),
        ("starting_torque_1000n", LOADED_HZ, seconds),
    ):
        changes = {
            "over": (ALL_FREQUENCIES, frequencies),
            "record": (record, f"record: {{channels: {CHANNELS}, duration: {length:g} s}}"),
        }
        if length == seconds:
            changes["running"] = ("settle: {cycles: 100}", "settle: {cycles: 5}")
        edited(find_procedure(name), lab / f"{name}.yaml", **changes)
    done = run(lab / "no_load_inertia_sweep.yaml", lab / "runs", station=station, clock=WallClock())
    if done.error is not None:
        raise done.error
    return lab / "runs"


def watch(screen: Screen, panel: int) -> Iterator[Observation]:
    """Observe the run until it ends and its final analysis begins."""
    while screen.state["phase"] in ("starting", "running", "asking"):
        state, memory, cpu = screen.state, {}, {}
        for name, pid in processes(panel).items():
            memory[name], cpu[name] = used(pid)
        results = (state["live"] or {}).get("results", ())
        recording = (state["progress"] or {}).get("recording", "")
        values = [result["value"] for result in results if result["is_ongoing"]]
        yield Observation(time.monotonic(), recording, memory, cpu, values[-1] if values else None)
        time.sleep(EVERY_S)


def processes(panel: int) -> dict[str, int]:
    started = started_by(panel).items()
    pids = {name: pid for pid, command in started for name, key in PARTS.items() if key in command}
    return {"panel": panel, **pids}


def used(pid: int) -> tuple[float, float]:
    """Return resident memory in MB and CPU time in seconds; zeros for a process that ended."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    except OSError:
        return 0.0, 0.0
    ticks, page = os.sysconf("SC_CLK_TCK"), os.sysconf("SC_PAGE_SIZE")
    return int(fields[21]) * page / MB, (int(fields[11]) + int(fields[12])) / ticks


def figures_of(
    folder: Path, looks: list[Observation], curves: list[dict], seconds: float
) -> list[Figure]:
    recordings, events, raw = stored(folder)
    recording = [look for look in looks if look.recording]
    lost = sum(produced - kept for produced, kept, _ in recordings.values())
    late = max(late_s for _, _, late_s in recordings.values())
    pause = pauses(events)
    size = (folder / "run.h5").stat().st_size
    rows = [
        Figure("samples lost", single(lost), "samples", target=at_most(0, "samples"),
               note=f"of {sum(count for count, _, _ in recordings.values()):,.0f} per channel"),
        Figure("behind, the greatest", single(late * MS), "ms", target=at_most(100, "ms"),
               note="the buffer of the device holds 1,000 ms"),
        Figure("pause after a recording", single(max(pause) * MS), "ms",
               note="the sync of its journal; folded beside the next step"),
        Figure("run.h5, against the samples", single(raw / size), "times smaller"),
    ]  # fmt: skip
    if seconds > LONG_S:
        for name, hz in zip(recordings, HZ, strict=True):
            rows += [live_value(recording, name, hz), live_swing(curves, name, hz)]
    return rows + [row for name in PARTS for row in of_process(name, recording)]


def stored(folder: Path) -> tuple[dict[str, tuple[float, int, float]], list[dict], float]:
    """Return by recording the samples made and kept and the lateness, the events, the bytes."""
    with h5py.File(folder / "run.h5") as file:
        groups = sorted(file["entry/recordings"].values(), key=lambda group: group.attrs["number"])
        samples = {
            str(group.attrs["name"]): (
                float(group["conditions/tester_produced"][()]),
                int(group["tester_torque"].shape[0]),
                float(group["conditions/tester_late"][()]),
            )
            for group in groups
        }
        events = [json.loads(text) for text in file["entry/events/json"][()]]
    return samples, events, sum(kept for _, kept, _ in samples.values()) * RAW_BYTES


def pauses(events: list[dict]) -> list[float]:
    """Return the time from the end of each recording to the next event, in seconds."""
    return [
        after["monotonic_s"] - event["monotonic_s"]
        for event, after in pairwise(events)
        if event["event"] == "StepEnded" and event["recording"]
    ]


def live_value(looks: list[Observation], name: str, frequency_hz: float) -> Figure:
    """Return the time from one value of the torque on the screen to the next."""
    looks = [look for look in looks if look.recording == name]
    changed_s, shown = [], None
    for look in looks:
        if look.value not in {None, shown}:
            shown = look.value
            changed_s.append(look.at_s)
    every_s = [after - before for before, after in pairwise(changed_s)]
    first = f"the first after {changed_s[0] - looks[0].at_s:.1f} s" if changed_s else "none"
    value = Spread.of(every_s) if every_s else None
    what = f"live torque at {frequency_hz:g} Hz, a new value every"
    return Figure(what, value, "s", note=f"{len(changed_s)} values, {first}")


def live_swing(curves: list[dict], name: str, frequency_hz: float) -> Figure:
    """Return the age of a swing when it is drawn."""
    late_s = [curve["late_s"] for curve in curves if curve["recording"] == name]
    value = Spread.of(late_s) if late_s else None
    what = f"live swing at {frequency_hz:g} Hz, its age"
    return Figure(what, value, "s", note=f"{len(late_s)} swings")


def of_process(name: str, looks: list[Observation]) -> list[Figure]:
    looks = [look for look in looks if name in look.memory_mb and look.recording]
    looks = [look for look in looks if look.recording == looks[-1].recording]
    if len(looks) < 3:
        return []
    third = len(looks) // 3
    memory = [look.memory_mb[name] for look in looks]
    growth = median(memory[-third:]) - median(memory[third : 2 * third])
    cpu = (looks[-1].cpu_s[name] - looks[0].cpu_s[name]) / (looks[-1].at_s - looks[0].at_s)
    return [
        Figure(f"memory of the {name}", single(max(memory)), "MB", note=f"growth {growth:+.0f} MB"),
        Figure(f"CPU of the {name}", single(100 * cpu), "% of a core"),
    ]


def single(value: float) -> Spread:
    return Spread.of([value])
