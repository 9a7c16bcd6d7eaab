"""Plugins of a station that listen to its runs."""

from __future__ import annotations

import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest

from helpers_tester import procedure_file, run, station_file
from helpers_waiting import wait_until
from rigrunner.api.data import Block
from rigrunner.api.errors import InvalidFileError
from rigrunner.api.events import Samples
from rigrunner.clock import SimulatedClock
from rigrunner.registry import load_registry
from rigrunner.run import listening
from rigrunner.run.listening import Detached, listeners_of
from rigrunner.run.prepare import plan_run
from rigrunner.runfile import read

pytestmark = pytest.mark.usefixtures("tester")
PLUGIN = '''
from pathlib import Path

from rigrunner.api.events import EventSink
from rigrunner.api.hooks import EventSinkRecord, hookimpl
from rigrunner.api.settings import Settings

api_version = 1


class LabMessagesSettings(Settings):
    """Where to write."""

    file: str


def make(settings):
    def tell(event):
        with Path(settings.file).open("a") as file:
            file.write(type(event).__name__ + "\\n")
        if settings.file.endswith("broken"):
            raise OSError("the network is gone")

    return tell


@hookimpl
def rigrunner_event_sinks():
    return [
        EventSinkRecord(
            name="lab_messages", help="Tells.", settings=LabMessagesSettings, factory=make
        )
    ]
'''


@pytest.fixture
def lab(tmp_path):
    (tmp_path / "plugins").mkdir()
    (tmp_path / "plugins" / "messages.py").write_text(PLUGIN, encoding="utf-8")

    def station(*listeners):
        lines = "".join(f"\n  - {listener}" for listener in listeners)
        return station_file(
            tmp_path,
            ("id: bench\n", f"id: bench\nplugins: plugins\nlisteners:{lines}\n"),
        )

    return tmp_path, station


def test_listener_gets_events_from_start_to_end(lab):
    folder, station = lab
    file = folder / "events"
    listener = f"{{plugin: lab_messages, settings: {{file: {file}}}}}"
    finished = run(procedure_file(folder, "idle"), folder / "runs", station=station(listener))
    assert finished.error is None
    kinds = file.read_text().split()
    assert (kinds[:2], kinds[-2:]) == (["RunPlanned", "RunStarted"], ["RunEnded", "RunFinished"])
    assert kinds.count("StepStarted") == kinds.count("StepEnded") > 0
    assert "Samples" in kinds


def test_failing_listener_is_dropped_and_run_continues(lab):
    folder, station = lab
    file = folder / "broken"
    listener = f"{{plugin: lab_messages, settings: {{file: {file}}}}}"
    finished = run(procedure_file(folder, "idle"), folder / "runs", station=station(listener))
    assert finished.error is None
    assert file.read_text().split() == ["RunPlanned"]
    assert no_listener_is_left()
    alarms = [event.text for event in read(finished.folder).events if hasattr(event, "source")]
    assert any(
        "lab_messages failed and was dropped: OSError: the network is gone" in text
        for text in alarms
    )


@pytest.mark.parametrize(
    ("listener", "message"),
    [
        ("{plugin: lab_mesages}", r"station.yaml:\d+:14: .*there is no event sink 'lab_mesages'"),
        ("{plugin: lab_messages}", r"the key 'file' is missing"),
        ("{plugin: lab_messages, settings: {fiel: a}}", "unknown key 'fiel'"),
        ("lab_messages", "listeners"),
    ],
)
def test_invalid_listener_is_refused_with_its_place(lab, listener, message):
    folder, station = lab
    procedure = procedure_file(folder, "idle")
    with pytest.raises(InvalidFileError, match=message):
        plan_run(procedure, station(listener), load_registry(), SimulatedClock())


def no_listener_is_left():
    return not [thread for thread in threading.enumerate() if thread.name.startswith("listener ")]


def test_hanging_listener_delays_nothing():
    """Two events are queued, one is being handled; the run waits half a second for room, once."""
    hang, events = threading.Event(), []

    def sink(event):
        events.append(event)
        hang.wait(60)

    detached = Detached("slow", sink, most_waiting=2)
    began = time.monotonic()
    detached("one")
    wait_until(lambda: events)
    detached("two")
    detached("three")
    assert detached._patience_s == listening.PATIENCE_S  # not used up
    with pytest.raises(TimeoutError, match="it does not keep up"):
        detached("four")
    detached.close()
    assert time.monotonic() - began < 10.0
    hang.set()
    wait_until(no_listener_is_left)
    assert events == ["one"]


def test_slow_listener_is_dropped():
    """Each event finds room before half a second is over, and the run would wait 2000 times."""
    detached = Detached("slow", lambda _event: time.sleep(0.02), most_waiting=2)

    def run():
        for number in range(2000):
            detached(number)

    began = time.monotonic()
    with pytest.raises(TimeoutError, match="it does not keep up"):
        run()
    assert time.monotonic() - began < 20.0
    detached.close()
    wait_until(no_listener_is_left)


def test_thousands_of_events_are_queued_in_order():
    events, release = [], threading.Event()

    def sink(event):
        release.wait(60)
        events.append(event)

    detached = Detached("later", sink)
    for number in range(20_000):
        detached(number)
    release.set()
    detached.close()
    assert events == list(range(20_000))


def test_listener_is_closed_once_in_its_thread_even_after_failure():
    events = []

    class Sink:
        def __init__(self, fails):
            self.fails = fails

        def __call__(self, event):
            events.append(event)
            if self.fails:
                raise OSError("gone")

        def close(self):
            events.append(threading.current_thread().name)
            raise OSError("gone, too")

    for fails in (False, True):
        detached = Detached("closing", Sink(fails))
        detached("one")
        detached.close()
        wait_until(no_listener_is_left)
    assert events == ["one", "listener closing"] * 2


def test_queued_events_are_delivered_on_close():
    events = []

    def sink(event):
        time.sleep(0.01)
        events.append(event)

    detached = Detached("late", sink)
    for number in range(20):
        detached(number)
    detached.close()
    assert events == list(range(20))
    assert no_listener_is_left()


def test_queue_of_samples_is_limited_by_size(monkeypatch):
    events, release = [], threading.Event()

    def sink(event):
        events.append(event.seq)
        release.wait(60)

    stamp = {"monotonic_s": 0.0, "utc": "", "recording": "a"}
    block = Block(1e6, 0, 0.0, {"tester.torque": np.zeros(128_000)})
    detached = Detached("slow", sink, most_waiting=1600)  # a block counts as 401
    detached(Samples(seq=0, block=block, **stamp))
    wait_until(lambda: events)
    for seq in range(1, 5):
        detached(Samples(seq=seq, block=block, **stamp))
    with pytest.raises(TimeoutError, match="it does not keep up"):
        detached(Samples(seq=5, block=block, **stamp))
    release.set()
    detached.close()
    monkeypatch.setattr(listening, "PATIENCE_S", 60.0)  # so that there is room in time
    seqs = []
    detached = Detached("quick", lambda event: seqs.append(event.seq), most_waiting=1600)
    for seq in range(50):
        detached(Samples(seq=seq, block=block, **stamp))
    detached.close()
    assert seqs == list(range(50))
    wait_until(no_listener_is_left)


def test_listener_raising_system_exit_has_failed():
    def ends(_event):
        raise SystemExit(0)

    detached = Detached("ends", ends)
    block = Block(1000.0, 0, 0.0, {"a.b": np.zeros(1)})
    event = Samples(seq=0, monotonic_s=0.0, utc="", recording="001", block=block)
    detached(event)
    detached.close()
    with pytest.raises(RuntimeError, match=r"it raised SystemExit\(0\)"):
        detached(event)


def test_slow_listeners_are_closed_concurrently():
    barrier = threading.Barrier(4)

    class Sink:
        def __call__(self, _event):
            pass

        def close(self):
            barrier.wait(60.0)

    records = [SimpleNamespace(plugin=f"slow {n}", settings={}) for n in range(4)]
    planned = SimpleNamespace(
        registry=SimpleNamespace(make=lambda *_: Sink()),
        station=SimpleNamespace(model=SimpleNamespace(listeners=records)),
        clock=SimulatedClock(),
    )
    with listeners_of(planned) as listeners:
        pass
    assert not barrier.broken
    assert not any(listener._thread.is_alive() for listener in listeners.sinks)
