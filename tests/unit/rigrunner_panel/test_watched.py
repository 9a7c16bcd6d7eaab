"""The channels that are read for the screen while nothing is recorded."""

from __future__ import annotations

from dataclasses import dataclass, field

import pytest

from rigrunner.api.errors import DeviceLostError
from rigrunner.api.member import Member
from rigrunner.run.locate import find_procedure, find_station
from rigrunner.run.planning import planned_run
from rigrunner_panel.process import watched
from rigrunner_panel.process.watched import WatchedChannels
from rigrunner_panel.view.channels import channels_of


@pytest.fixture(scope="module")
def planned():
    station = find_station("simulated")
    return planned_run(find_procedure("starting_torque_1000n"), station, realtime=True)


@dataclass
class Rig:
    """Answers each channel with 1.5, after a time, or not at all."""

    clock: Clock
    takes_s: float = 0.0
    is_lost: bool = False
    reads: list = field(default_factory=list)

    def read(self, role, names):
        self.reads.append(self.clock.now_s)
        self.clock.now_s += self.takes_s
        if self.is_lost:
            raise DeviceLostError("gone")
        return {Member(role, name): 1.5 for name in names}


@dataclass
class Clock:
    now_s: float = 100.0

    def monotonic(self):
        return self.now_s

    def time(self):
        return 1e9 + self.now_s


@pytest.fixture
def clock(monkeypatch):
    clock = Clock()
    monkeypatch.setattr(watched, "time", clock)
    return clock


def watched_for(planned, rig, clock, seconds):
    sent = []
    channels = WatchedChannels(sent.append, planned.devices)
    until_s = clock.now_s + seconds
    while clock.now_s < until_s:
        channels.look(rig)
        clock.now_s += 0.01
    return sent


def test_every_channel_is_read_ten_times_a_second_at_most(planned, clock):
    sent = watched_for(planned, Rig(clock), clock, 2.0)
    assert 15 <= len(sent) <= 21
    assert sent[0].values.keys() == {channel.name for channel in channels_of(planned)}


def test_slow_device_is_read_a_fifth_of_the_time_at_most(planned, clock):
    rig = Rig(clock, takes_s=0.5)
    sent = watched_for(planned, rig, clock, 20.0)
    assert len(rig.reads) <= 9
    assert [message.interval_s for message in sent] == pytest.approx(
        [2.5] * len(sent)
    )  # the age that a value may reach


def test_lost_device_is_read_rarely_and_raises_nothing(planned, clock):
    rig = Rig(clock, is_lost=True)
    assert watched_for(planned, rig, clock, 11.0) == []
    assert len(rig.reads) == 3


def test_without_a_rig_nothing_is_read(planned):
    WatchedChannels(pytest.fail, planned.devices).look()


def test_channel_has_display_unit_and_limits(planned):
    channels = {channel.name: channel for channel in channels_of(planned)}
    temperature = channels["tester.temperature"]
    assert temperature.unit == "°C"
    now = temperature.read(293.15, "2026-11-23T12:00:00Z")
    assert (now.value, now.utc) == (20.0, "2026-11-23T12:00:00Z")
    locks = {interlock.member: interlock for interlock in planned.plan.interlocks}
    lock = locks["tester.temperature"]
    assert temperature.upper == pytest.approx(lock.maximum - 273.15)
    assert temperature.lower == pytest.approx(lock.minimum - 273.15) or temperature.lower is None
