"""The manual page shows where the drives really are."""

from __future__ import annotations

import threading
from dataclasses import replace
from types import SimpleNamespace

from helpers_devices import FakeTester, record
from rigrunner.api.events import Outcome
from rigrunner.bus import Bus
from rigrunner.clock import SimulatedClock
from rigrunner.engine import run_by_hand
from rigrunner.plan.actions import Plan
from rigrunner.registry import load_registry
from rigrunner.rig import Rig
from rigrunner.run.locate import find_procedure, find_station
from rigrunner.run.prepare import plan_run
from rigrunner_panel.jobs.manual import Hand
from rigrunner_panel.process.link import Link
from rigrunner_panel.process.messages import CloseManual, RecordPoint, SetDrive, Show
from rigrunner_panel.process.switch import Switch
from rigrunner_panel.process.watched import WatchedChannels
from unit.engine.helpers_pausing import Person


def run_session(device, *requests):
    """Return the summary of a session, and its page after each request."""
    clock, messages, pending = SimulatedClock(), [], [*requests, CloseManual("me")]
    planned = plan_run(
        find_procedure("starting_torque_1000n"), find_station("simulated"), load_registry(), clock
    )
    planned = replace(planned, plan=Plan(()), devices={"tester": device})
    commands = SimpleNamespace(by_hand=lambda: pending.pop(0), has_by_hand=lambda: bool(pending))
    link = Link(commands, SimpleNamespace(send=messages.append), Switch())
    hand = Hand(planned, record("by hand"), link, WatchedChannels(messages.append, planned.devices))
    rig = Rig({"tester": device}, clock)
    rig.connect()
    summary = run_by_hand(
        hand.steps, rig, Bus([hand]), clock, threading.Event(), "R1", interlocks=(),
        pauses=Person([]),
    )  # fmt: skip
    shows = (message for message in messages if isinstance(message, Show))
    return summary, [show.sections["manual"] for show in shows]


def set_points(views, drive="tester.frequency"):
    return [{row.name: row.set for row in view.drives}[drive] for view in views]


def test_page_shows_the_set_point_of_a_drive():
    summary, shown = run_session(FakeTester(), SetDrive("tester.frequency", 5.0, "me"))
    assert summary.outcome is Outcome.COMPLETED
    assert set_points(shown) == [3.0, 5.0]


def test_page_shows_position_of_drive_whose_set_failed():
    device = FakeTester(read_back_offset=2.0)
    summary, shown = run_session(device, SetDrive("tester.frequency", 20.0, "me"))
    assert summary.passed_over
    assert set_points(shown) == [5.0, 22.0]


def test_page_counts_recorded_points():
    requests = (SetDrive("tester.frequency", 5.0, "me"), RecordPoint(5, "me"), RecordPoint(5, "me"))
    summary, shown = run_session(FakeTester(), *requests)
    assert summary.outcome is Outcome.COMPLETED
    state = [(view.recording, view.points, view.last) for view in shown]
    first, second = "001_5Hz", "002_5Hz"
    assert state[2:] == [(first, 0, ""), ("", 1, first), (second, 1, first), ("", 2, second)]
