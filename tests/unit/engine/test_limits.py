"""Limits of readings that are not numbers, and the order of readings."""

from __future__ import annotations

import threading

from helpers_devices import FakeTester
from rigrunner.api.devices import ReadingInfo
from rigrunner.api.events import LimitMissed
from rigrunner.api.member import Member
from rigrunner.api.readings import ReadingLimit
from rigrunner.clock import SimulatedClock
from rigrunner.engine import UnattendedAnswers
from rigrunner.engine.interlocks import Guard
from rigrunner.engine.limits import missed_of
from rigrunner.engine.session import Session
from rigrunner.rig import Rig

DOOR = ReadingLimit("box.door", (True,))
FIRMWARE = ReadingLimit("box.firmware", ("FW2.1", "FW2.2"))


def test_only_unexpected_readings_miss_their_limit():
    readings = {"box.door": True, "box.firmware": "FW2.2"}
    assert list(missed_of([DOOR, FIRMWARE], readings)) == []
    ((kind, text),) = missed_of([DOOR, FIRMWARE], readings | {"box.door": False})
    assert kind is LimitMissed
    assert text == "box.door is no, expected yes"


class Observes(FakeTester):
    readings = (ReadingInfo("door", "boolean", "Door"), ReadingInfo("mode", "text", "Mode"))

    def observe(self, names):
        self._record_call(f"observe {','.join(names)}")
        return {"door": True, "mode": self.calls[0]}


def test_readings_of_several_devices_keep_requested_order():
    devices = {"box": Observes(), "rack": Observes()}
    rig = Rig(devices, SimulatedClock())
    session = Session(
        rig, lambda *_, **__: None, UnattendedAnswers(), threading.Event(), Guard((), rig, None)
    )
    members = [Member("rack", "door"), Member("box", "mode"), Member("rack", "mode")]
    assert list(session.observe(members).items()) == [
        ("rack.door", True), ("box.mode", "observe mode"), ("rack.mode", "observe door,mode"),
    ]  # fmt: skip
