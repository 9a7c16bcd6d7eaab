"""A conforming device, and for each check of the kit a device that fails it."""

from __future__ import annotations

import socket
import threading
import time
from typing import Annotated, Literal

import numpy as np
from pydantic import BeforeValidator, ConfigDict

from rigrunner.api.data import Block
from rigrunner.api.devices import ChannelInfo, DriveInfo, Identity, ReadingInfo
from rigrunner.api.driver import Driver
from rigrunner.api.errors import (
    DeviceLostError,
    DeviceNotFoundError,
    DeviceRejectedError,
)
from rigrunner.api.hooks import DeviceRecord
from rigrunner.api.settings import Force, Settings
from rigrunner.registry import Plugin, Provider, Registry

RATE_HZ, BLOCK = 1000.0, 50


class PressSettings(Settings):
    """The settings of the press in a station."""

    capacity: Force = 1000.0
    """The maximum load."""
    seed: int = 0
    """The seed of its noise."""
    simulate: Literal["ready", "unplugged"] = "ready"
    """Whether the press answers."""


class Press(Driver):
    """A simulated press with every exchange over the wire; it passes all checks."""

    non_blocking = True
    errors = {ValueError: DeviceRejectedError}  # noqa: RUF012  (Driver's way)
    sample_rate_hz = RATE_HZ
    readings = (ReadingInfo("guard", "boolean", "Guard"), ReadingInfo("model", "text", "Model"))

    def __init__(self, settings, context):
        channels = [ChannelInfo("load", "N", "Load"), ChannelInfo("oil", "K", "Oil temperature")]
        drives = [
            DriveInfo("load", "N", "Load", 0.0, settings.capacity, tolerance=5.0),
            DriveInfo("frequency", "Hz", "Strokes", 0.0, 30.0, sets_cycle_frequency=True),
        ]
        super().__init__(context, channels, drives)
        self.settings = settings
        self.set_points = {"load": 0.0, "frequency": 0.0}
        self.paused_at = None
        self.streams = 0

    def open(self, timeout_s):
        if self.settings.simulate == "unplugged":
            raise DeviceNotFoundError(f"no press answered in {timeout_s:g} s")
        self.exchange("identify", lambda: "press")
        return Identity("Zoo", "press", "7", simulated=True)

    def get(self, channel):
        return float(self.exchange(f"query {channel}", lambda: str(self.value(channel))))

    def get_reading(self, reading):
        answer = self.exchange(f"query {reading}", lambda: {"guard": "1", "model": "P7"}[reading])
        return answer == "1" if reading == "guard" else answer

    def value(self, channel):
        return 300.0 if channel == "oil" else self.set_points[channel] + 0.1

    def actual(self, drive):
        return float(self.exchange(f"query {drive}", lambda: str(self.set_points[drive])))

    def put(self, drive, value):
        self.exchange(f"set {drive} {value:g}", lambda: self.set_points.update({drive: value}))

    def stream(self, channels, duration_s, stop):
        self.check_channels(channels)
        number, self.streams = self.streams, self.streams + 1
        return self.blocks(channels, round(duration_s * RATE_HZ), stop, number)

    def blocks(self, channels, total, stop, number):
        rng = self.generator(number)
        for first in range(0, total, BLOCK):
            if stop.is_set():
                return
            count = min(BLOCK, total - first)
            self.clock.sleep(count / RATE_HZ)
            yield self.block(channels, first, rng.normal(size=count))

    def generator(self, number):
        return np.random.default_rng((self.settings.seed, number))

    def block(self, channels, first, noise):
        return Block(RATE_HZ, first, self.clock.monotonic_s(), dict.fromkeys(channels, noise))

    def pause(self):
        self.paused_at = self.set_points["frequency"]
        self.set("frequency", 0.0)

    def resume(self):
        frequency, self.paused_at = self.paused_at, None
        if frequency is not None:
            self.set("frequency", frequency)

    def make_safe(self):
        self.paused_at = None
        return super().make_safe()

    def continue_after(self, streams):
        self.streams += len(streams)

    def truth(self):
        return {"load_n": self.set_points["load"]}


class Undescribed(Settings):
    capacity: Force = 1000.0
    seed: int = 0
    simulate: Literal["ready", "unplugged"] = "ready"


class TakesAnyKey(PressSettings):
    model_config = ConfigDict(extra="ignore")


class CrashesOnAList(PressSettings):
    seed: Annotated[int, BeforeValidator(lambda value: value.bit_length() and value)] = 0
    """The seed of its noise."""


class TakesABareNumber(PressSettings):
    capacity: Annotated[
        Force, BeforeValidator(lambda value: f"{value} N" if isinstance(value, float) else value)
    ] = 1000.0
    """The maximum load."""


class TakesNoContext(Press):
    def __init__(self, settings):
        super().__init__(settings, None)


class OpensAPortWhenMade(Press):
    def __init__(self, settings, context):
        super().__init__(settings, context)
        with socket.socket() as port:
            port.bind(("127.0.0.1", 0))


class WithoutMaker(Press):
    def open(self, timeout_s):
        super().open(timeout_s)
        return Identity("", "press", "7", simulated=True)


class NeverGivesUp(Press):
    def open(self, timeout_s):
        if self.settings.simulate == "unplugged":
            time.sleep(2.1 * (not self.streams))
            self.streams = 1  # once is enough
        return super().open(timeout_s)


class ReadsUnconnected(Press):
    def _need_connection(self):
        pass


class ClosesOnce(Press):
    port = True

    def shut(self):
        del self.port  # fails the second time

    def open(self, timeout_s):
        self.port = True
        return super().open(timeout_s)


class LeavesAThread(Press):
    def open(self, timeout_s):
        threading.Thread(target=threading.Event().wait, args=(20,), daemon=True).start()
        return super().open(timeout_s)


class InKilonewtons(Press):
    def __init__(self, settings, context):
        super().__init__(settings, context)
        self.channels = (ChannelInfo("load", "kN", "Load"), *self.channels[1:])


class ReadsNan(Press):
    def get(self, channel):
        super().get(channel)
        return float("nan")


class FallsShort(Press):
    def put(self, drive, value):
        super().put(drive, 0.9 * value)

    def set(self, drive, value):
        self.begin(drive, value)


class BlocksWhenBegun(Press):
    def put(self, drive, value):
        self.clock.sleep(5.0)
        super().put(drive, value)


class ClampsAtTheMaximum(Press):
    def begin(self, drive, value):
        if value > self._drives[drive].maximum:
            self.put(drive, self._drives[drive].maximum)
        super().begin(drive, value)


class RefusesWithoutTheName(Press):
    def check_channels(self, channels):
        self._need_connection()
        if set(channels) - set(self._channels):
            raise DeviceRejectedError("no such channel")


class CrashesUnconnected(Press):
    def make_safe(self):
        if self._timeout_s is None:
            raise AttributeError("'NoneType' object has no attribute 'write'")
        return super().make_safe()


class ReportsSafeUnset(Press):
    def make_safe(self):
        self._need_connection()
        return {"load": 0.0, "frequency": 0.0}


class SkipsNumbersLater(Press):
    def block(self, channels, first, noise):
        return super().block(channels, first + 10 * self.streams, noise)


class StuckAfterRefusal(Press):
    stuck = False

    def begin(self, drive, value):
        self.stuck |= value > self._drives[drive].maximum
        super().begin(drive, value)

    def put(self, drive, value):
        if not self.stuck:
            super().put(drive, value)


class StopsAtTheFirstBadDrive(Press):
    def make_safe(self):
        for info in self.drives:
            self.set(info.name, info.safe_value)
        return {info.name: self.read_back(info.name) for info in self.drives}


class CrashesOnceClosed(Press):
    def make_safe(self):
        if not self._is_open:
            raise AttributeError("'NoneType' object has no attribute 'write'")
        return super().make_safe()


class ResumesByItself(Press):
    def make_safe(self):
        paused_at = self.paused_at
        read_back = super().make_safe()
        self.paused_at = paused_at
        return read_back


class HasAGap(Press):
    def block(self, channels, first, noise):
        return super().block(channels, first + (first > 200), noise)


class InSinglePrecision(Press):
    def block(self, channels, first, noise):
        return super().block(channels, first, noise.astype(np.float32))


class StreamsAtOnce(Press):
    def blocks(self, channels, total, _stop, number):
        noise = self.generator(number).normal(size=total)
        yield self.block(channels, 0, noise)


class IgnoresTheStop(Press):
    def blocks(self, channels, total, _stop, number):
        return super().blocks(channels, total, threading.Event(), number)


class StopsStreamingOnceLeft(Press):
    left = 0

    def blocks(self, channels, total, stop, number):
        if self.left > 3:
            return
        self.left += 1
        yield from super().blocks(channels, total, stop, number)


class IgnoresItsSeed(Press):
    def generator(self, _number):
        return np.random.default_rng()


class HasOneSeed(Press):
    def generator(self, number):
        return np.random.default_rng(number)


class ForgetsItsStreams(Press):
    def continue_after(self, streams):
        pass


class TruthIsNan(Press):
    def truth(self):
        return {"load_n": float("nan")}


class Waits(Press):
    def get(self, channel):
        time.sleep(0.25)
        return super().get(channel)


class BypassesTheWire(Press):
    def exchange(self, _request, perform):
        return perform()


class LetsParsingErrorsOut(Press):
    errors = {}  # noqa: RUF012  (Driver's way)


class StaysLost(Press):
    """Gives up after a failure, as many drivers do."""

    reconnects_after = ()
    lost = False

    def exchange(self, request, perform):
        if self.lost:
            raise DeviceLostError("given up after an earlier failure")
        try:
            return super().exchange(request, perform)
        except DeviceLostError:
            self.lost = True
            raise


class ReadsOneForTrue(Press):
    def get_reading(self, reading):
        return 1 if reading == "guard" else super().get_reading(reading)


class CannotBeMadeSafe(Press):
    def make_safe(self):
        raise DeviceLostError("the press does not answer")


BROKEN = {
    "name_fits_yaml": {"name": "Press 1"},
    "help_line": {"help": ""},
    "settings_explained": {"settings": Undescribed},
    "unknown_setting_refused": {"settings": TakesAnyKey},
    "wrong_type_refused": {"settings": CrashesOnAList},
    "wrong_unit_refused": {"settings": TakesABareNumber},
    "can_be_made": {"factory": TakesNoContext},
    "construction_touches_nothing": {"factory": OpensAPortWhenMade},
    "connects_and_says_who_it_is": {"factory": WithoutMaker},
    "gives_up_in_time": {"factory": NeverGivesUp},
    "needs_a_connection": {"factory": ReadsUnconnected},
    "closes_in_every_state": {"factory": ClosesOnce},
    "gives_back_what_it_took": {"factory": LeavesAThread},
    "quantities_declared": {"factory": InKilonewtons},
    "readings_are_true": {"factory": ReadsNan},
    "readings_are_told": {"factory": ReadsOneForTrue},
    "drives_go_where_they_are_set": {"factory": FallsShort},
    "drives_are_waited_for_by_asking": {"factory": BlocksWhenBegun},
    "limits_hold": {"factory": ClampsAtTheMaximum},
    "unknown_names_refused": {"factory": RefusesWithoutTheName},
    "safe_before_connecting": {"factory": CrashesUnconnected},
    "safe_is_confirmed": {"factory": ReportsSafeUnset},
    "safe_while_streaming": {"factory": SkipsNumbersLater},
    "safe_after_a_failed_call": {"factory": StuckAfterRefusal},
    "safe_though_one_drive_fails": {"factory": StopsAtTheFirstBadDrive},
    "safe_after_closing": {"factory": CrashesOnceClosed},
    "pauses_and_resumes": {"factory": ResumesByItself},
    "streams_are_gapless": {"factory": HasAGap},
    "blocks_are_whole": {"factory": InSinglePrecision},
    "streams_take_their_time": {"factory": StreamsAtOnce},
    "stops_in_time": {"factory": IgnoresTheStop},
    "streams_may_be_left": {"factory": StopsStreamingOnceLeft},
    "same_seed_same_samples": {"factory": IgnoresItsSeed},
    "other_seed_other_samples": {"factory": HasOneSeed},
    "continues_after_streams": {"factory": ForgetsItsStreams},
    "only_a_simulator_knows_the_truth": {"factory": TruthIsNan},
    "non_blocking_is_true": {"factory": Waits},
    "exchanges_go_over_the_wire": {"factory": BypassesTheWire},
    "only_device_errors_leave_it": {"factory": LetsParsingErrorsOut},
    "recovers_after_a_failure": {"factory": StaysLost},
    "left_safe": {"factory": CannotBeMadeSafe},
}
"""By check: the changes of the record of the press that fail it."""


def registry_of(kind, record):
    """Return a registry with a single plugin."""
    return Registry([Plugin(kind, record, Provider("zoo", "1"))])


def press(**changes):
    """Return a registry with the press, with changes of its record."""
    fields = {
        "name": "press",
        "help": "A press.",
        "settings": PressSettings,
        "factory": Press,
        "simulated": True,
        "wired": True,
        "absent": {"simulate": "unplugged"},
    }
    return registry_of("device", DeviceRecord(**{**fields, **changes}))
