"""Runs on disk, made by hand."""

from __future__ import annotations

from contextlib import contextmanager
from datetime import UTC, datetime
from typing import TYPE_CHECKING

import numpy as np
import pytest

from rigrunner.api.data import Block, Recording
from rigrunner.api.details import PlotColumn, RunPlot
from rigrunner.api.events import Outcome, RunEnded, RunStarted, Samples, StepEnded, StepStarted
from rigrunner.bus import Bus, Emitter
from rigrunner.clock import SimulatedClock
from rigrunner.runfile import RunHeader, RunWriter
from rigrunner.runfile.compressed import LongText

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from pathlib import Path

    from rigrunner.api.events import EventSink

START = datetime(2026, 3, 1, 12, 0, tzinfo=UTC)
TRUTH = {"starting_torque_nm": 0.7262, "inertia_kg_m2": 0.002324}


def header_of(run_id: str = "run", **changed: object) -> RunHeader:
    known: dict[str, object] = {
        "run_id": run_id,
        "started_utc": "2026-03-01T12:00:00.000Z",
        "procedure_id": "SSPB-STT-1000",
        "procedure_revision": "A",
        "procedure_title": "Starting torque under 1000 N",
        "station_id": "simulated",
        "procedure_text": "# N·m, 'ünïcode' and\ttabs\r\n",
        "station_text": "rigrunner: station/1\n",
        "plan_text": LongText.of("set tester.load 1000 N\n"),
        "inputs": {"specimen": "<script>", "operator": "Zoë"},
        "provenance": {"rigrunner": "0.1.0", "plugin swing_tester_sim": "0.1.0"},
    }
    return RunHeader(**known | changed)


def recording(name: str = "001_10Hz", samples: int = 2500, seed: int = 1) -> Recording:
    rng = np.random.default_rng(seed)
    return Recording(
        name=name,
        rate_hz=10_000.0,
        started_utc="",
        setpoints={"tester.load": 1000.0, "tester.frequency": 10.0},
        channels={
            "tester.angle": rng.normal(0, 0.04, samples),
            "tester.torque": rng.normal(0, 2.0, samples),
        },
        units={
            "tester.angle": "rad",
            "tester.torque": "N·m",
            "tester.load": "N",
            "tester.frequency": "Hz",
            "tester.temperature": "K",
        },
        conditions={"tester.temperature": 295.25},
    )


TWO = (recording(), recording("002_20Hz", samples=40_001, seed=2))
PLOT = RunPlot(
    name="torque",
    title="torque over frequency",
    columns={
        name: PlotColumn(np.arange(2.0) + row, unit, f"{name} / {unit}")
        for row, (name, unit) in enumerate(
            {
                "frequency": "Hz",
                "raw": "N·m",
                "compensated": "N·m",
                "compensated_errors": "N·m",
            }.items()
        )
    },
    axis="frequency",
    signal="compensated",
    beside=("raw",),
)
DOCUMENT = {"headline": {"value": 0.7262, "unit": "N·m"}, "notes": ["a", None, 1e-300]}


def emitter_of(*sinks: EventSink) -> Emitter:
    return Emitter(Bus(sinks), SimulatedClock(START))


def start_recording(emit: Emitter, recording: Recording, index: int = 0) -> None:
    drives = dict(recording.units.items())
    emit(
        StepStarted,
        step=f"main[{index}]",
        index=index,
        action="record",
        text=f"record {recording.name}",
        recording=recording.name,
        setpoints=recording.setpoints,
        units=drives,
    )


def send_samples(emit: Emitter, recording: Recording, block: int, until: int | None = None) -> None:
    total = recording.samples if until is None else until
    for first in range(0, total, block):
        end = min(first + block, total)
        channels = {name: values[first:end] for name, values in recording.channels.items()}
        emit(
            Samples,
            recording=recording.name,
            block=Block(recording.rate_hz, first, first / recording.rate_hz, channels),
        )


def end_recording(
    emit: Emitter,
    recording: Recording,
    index: int = 0,
    *,
    ok: bool = True,
    truth: Mapping[str, float] = TRUTH,
) -> None:
    emit(
        StepEnded,
        step=f"main[{index}]",
        index=index,
        action="record",
        ok=ok,
        recording=recording.name,
        values=recording.conditions if ok else {},
        units=recording.units if ok else {},
        truth=truth if ok else {},
    )


def emit_zero(emit: Emitter, value: float = 0.0123, **more: object) -> None:
    emit(
        StepEnded,
        step="setup[1]",
        index=0,
        action="zero",
        ok=True,
        values={"tester.torque": value},
        units={"tester.torque": "N·m"},
        **more,
    )


def write_run(
    folder: Path,
    recordings: Sequence[Recording],
    *,
    header: RunHeader | None = None,
    block: int = 1000,
) -> RunWriter:
    """Write a completed run, closed but not sealed."""
    writer = RunWriter(folder, header or header_of(folder.name))
    emit = emitter_of(writer)
    emit(RunStarted, run_id=folder.name, steps=len(recordings), estimated_s=1.0)
    emit_zero(emit)
    for index, recording in enumerate(recordings):
        start_recording(emit, recording, index)
        send_samples(emit, recording, block)
        end_recording(emit, recording, index)
    emit(RunEnded, outcome=Outcome.COMPLETED, read_back={"tester.load": 0.0})
    writer.close()
    return writer


def assert_same_recording(stored: Recording, original: Recording) -> None:
    """Compare all but the start time, which the step's event gives; samples bit by bit."""
    assert (stored.name, stored.rate_hz) == (original.name, original.rate_hz)
    assert stored.setpoints == original.setpoints
    assert stored.conditions == original.conditions
    assert stored.units == original.units
    assert list(stored.channels) == list(original.channels)
    for name, values in original.channels.items():
        assert stored.channels[name].dtype == "<f8"
        assert stored.channels[name].tobytes() == values.astype("<f8").tobytes(), name


@contextmanager
def disk_full_beyond(size: int) -> Iterator[None]:
    """No file may grow beyond the size: writing then raises OSError, as on a full disk."""
    resource = pytest.importorskip("resource", reason="limits on file sizes need a Unix")
    former = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, former[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, former)
