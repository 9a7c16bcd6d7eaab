"""Checks on listeners to the events of a run."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from rigrunner.api import events
from rigrunner.api.data import Block
from rigrunner_testing.check import AnyCheck, check, demand
from rigrunner_testing.device.watching import census, leaks_since
from rigrunner_testing.own_time import TRIES, measured

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.api.events import Event, EventSink
    from rigrunner_testing.subjects import Subject

AT_ONCE_S = 0.1
RATE_HZ, SAMPLES = 10_000.0, 1000
BLOCKS = 50
"""Of 0.1 s each: a recording of five seconds."""


@check(fix="accept every Event, also one that is not used")
def takes_every_event(subject: Subject) -> None:
    """It accepts each kind of event, also those of a failed run, in the order of a run."""
    sink = _sink(subject)
    for event in run():
        sink(event)


@check(
    fix="hand long work to a thread of your own; keep what you need, not the samples",
    needs=("takes_every_event",),
)
def comes_back_at_once(subject: Subject) -> None:
    """It returns from each event within 0.1 s, since it is called during the run."""
    shortest: dict[tuple[int, str], float] = {}
    for _ in range(TRIES):
        sink = _sink(subject)
        for event in run():
            took_s = measured(partial(sink, event)).took_s
            key = (event.seq, type(event).__name__)
            shortest[key] = min(shortest.get(key, took_s), took_s)
    slow = {name: took_s for (_, name), took_s in shortest.items() if took_s > AT_ONCE_S}
    demand(not slow, ", ".join(f"{name} took it {took_s:.2f} s" for name, took_s in slow.items()))


@check(
    fix="copy what you change: other listeners and the run file get the same block",
    needs=("takes_every_event",),
)
def leaves_samples_alone(subject: Subject) -> None:
    """It does not change samples: the run file is written from them."""
    sink = _sink(subject)
    for event in run():
        samples = event.block.channels if isinstance(event, events.Samples) else {}
        before = {name: values.copy() for name, values in samples.items()}
        sink(event)
        is_same = all(np.array_equal(samples[name], values) for name, values in before.items())
        demand(is_same, "it changes the samples that it is given")


@check(
    fix="end threads and close files when RunEnded comes, or in `close`",
    needs=("takes_every_event",),
)
def lets_go_when_the_run_ends(subject: Subject) -> None:
    """After the run, and its `close` if it has one, it holds no thread, no file and no socket."""
    _listen(subject)  # so that lazy imports do not count
    before = census()
    _listen(subject)
    leaks = leaks_since(before)
    demand(not leaks, f"after the run it still holds: {leaks}")


def _listen(subject: Subject) -> None:
    sink = _sink(subject)
    for event in run():
        sink(event)
    if isinstance(sink, events.ClosingSink):
        sink.close()


def _sink(subject: Subject) -> EventSink:
    sink: EventSink = subject.make()
    return sink


def run() -> Iterator[Any]:
    """Yield the events of a short run that an interlock ends, as a station's listeners get them."""
    for seq, (kind, fields) in enumerate(_events()):
        yield kind(seq=seq, monotonic_s=0.1 * seq, utc="2026-01-01T12:00:00.000Z", **fields)


def _events() -> Iterator[tuple[type[Event], dict[str, Any]]]:
    step = {"step": "main[0]", "index": 0, "action": "record"}
    plan = {"run_id": "run-1", "folder": "run-1", "station": "rig-1", "title": "A test"}
    yield events.RunPlanned, {**plan, "procedure": "P", "due": {"transducer": "2026-01-10"}}
    yield events.RunStarted, {"run_id": "run-1", "steps": 1, "estimated_s": 5.0}
    yield events.Prompt, {"step": "setup[0]", "text": "Guards closed?", "choices": ("yes", "no")}
    yield events.Answer, {"step": "setup[0]", "text": "yes", "by": "A. Nother"}
    scan = {"step": "setup[1]", "index": 0, "action": "scan"}
    yield events.StepStarted, {**scan, "text": "scan", "units": {"tester.load": "N"}}
    row = {"setpoints": {"tester.load": 10.0}, "values": {"tester.torque": 0.1}}
    yield events.Scanned, {"step": "setup[1]", "point": 0, "measurement": "measured", **row}
    yield events.StepEnded, {**scan, "ok": True}
    yield events.StepStarted, {**step, "text": "record", "recording": "001"}
    for number in range(BLOCKS):
        torque = np.sin(np.arange(SAMPLES) / 50)
        channels = {"tester.torque": torque, "tester.angle": 2 * torque}
        block = Block(RATE_HZ, number * SAMPLES, 0.1 * number, channels)
        yield events.Samples, {"recording": "001", "block": block}
    yield events.Note, {"step": "main[0]", "text": "a remark"}
    trip = {"interlock": "guard", "does": "abort", "latency_s": 0.1}
    yield events.InterlockTripped, {"source": "guard", "text": "the guard is open", **trip}
    yield events.InterlockCleared, {"step": "", "text": "closed", "interlock": "guard"}
    yield events.Intervention, {"action": "abort", "by": "interlock"}
    values = {"values": {"tester.torque": 0.7}, "units": {"tester.torque": "N·m"}}
    yield events.StepEnded, {**step, "ok": False, "recording": "001", **values}
    yield events.MadeSafe, {"what": "tester", "read_back": {"tester.load": 0.0}}
    yield events.Alarm, {"source": "tester", "text": "the load did not come down"}
    yield events.RunEnded, {"outcome": events.Outcome.ABORTED, "reason": "guard open"}
    yield events.RunFinished, {"outcome": events.Outcome.ABORTED, "reason": "guard open"}


CHECKS: tuple[AnyCheck, ...] = (
    takes_every_event,
    comes_back_at_once,
    leaves_samples_alone,
    lets_go_when_the_run_ends,
)
