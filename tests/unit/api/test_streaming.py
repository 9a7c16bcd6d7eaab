"""Streaming drivers: gapless blocks, stopping, halting, and mapped errors."""

from __future__ import annotations

import threading

import numpy as np
import pytest

from rigrunner.api.devices import ChannelInfo, DeviceContext, Identity, Readable, Streaming
from rigrunner.api.errors import DeviceLostError, DeviceRejectedError
from rigrunner.api.hooks import DeviceRecord
from rigrunner.api.streaming import StreamingDriver
from rigrunner.clock import SimulatedClock
from rigrunner.registry import Plugin, Provider, Registry
from rigrunner_testing import State, Subject, checks, examine, subject

RATE_HZ = 1000.0


class OverrunError(Exception):
    """The maker's library lost samples."""


class Counter(StreamingDriver):
    """Gives 0, 1, 2, ... newtons, at 1 kHz."""

    channels = (ChannelInfo("force", "N", "Force"), ChannelInfo("twice", "N", "Twice"))
    errors = {OverrunError: DeviceLostError}  # noqa: RUF012  (as an author would write it)
    sample_rate_hz = RATE_HZ

    def __init__(self, settings, context):
        super().__init__(context)
        self.settings = settings
        self.log = []
        self.count = 0
        self.fails_at = None
        self.short = 0

    def open(self, timeout_s):  # noqa: ARG002  (it takes none)
        serial = self.exchange("serial number?", lambda: "1")
        return Identity("Test", "counter", serial, simulated=True)

    def get(self, channel):  # noqa: ARG002  (both the same)
        return self.exchange("count?", lambda: float(self.count))

    def start(self, channels):
        self.count = 0
        self.log.append(f"start {len(channels)}")

    def take(self, channels, samples):
        if self.fails_at is not None and self.count >= self.fails_at:
            raise OverrunError("buffer overrun")
        self.clock.sleep(samples / RATE_HZ)
        values = np.arange(self.count, self.count + samples - self.short)
        self.count += samples
        return {name: values * (2 if name == "twice" else 1) for name in channels}

    def halt(self):
        self.log.append("halt")


RECORD = DeviceRecord(
    name="counter", help="Counts.", factory=Counter, simulated=True, wired=True, stop_latency_s=0.2
)
REGISTRY = Registry([Plugin("device", RECORD, Provider("test", "1"))])


@pytest.fixture
def counter(tmp_path):
    device = Counter(None, DeviceContext("cell", SimulatedClock(), tmp_path))
    device.connect(1.0)
    return device


def test_blocks_are_gapless_and_have_all_channels(counter):
    """0.25 s at 1 kHz: blocks of 100, 100 and 50 samples."""
    assert isinstance(counter, Streaming)
    assert isinstance(counter, Readable)
    blocks = list(counter.stream(["twice", "force"], 0.25, threading.Event()))
    assert [(block.first_sample, block.samples) for block in blocks] == [
        (0, 100),
        (100, 100),
        (200, 50),
    ]
    assert np.array_equal(
        np.concatenate([block.channels["force"] for block in blocks]), np.arange(250.0)
    )
    assert blocks[2].channels["twice"][0] == 400.0
    assert blocks[0].channels["force"].dtype == np.float64
    assert [block.monotonic_s for block in blocks] == pytest.approx([0.1, 0.2, 0.25])
    assert counter.log == ["start 2", "halt"]


def test_stop_is_checked_between_two_blocks(counter):
    stop = threading.Event()
    stream = counter.stream(["force"], 10.0, stop)
    next(stream)
    stop.set()
    assert list(stream) == []
    assert counter.log == ["start 1", "halt"]


def test_closed_stream_is_halted(counter):
    stream = counter.stream(["force"], 10.0, threading.Event())
    next(stream)
    stream.close()
    assert counter.log == ["start 1", "halt"]


def test_error_during_a_stream_is_mapped_and_halts(counter):
    counter.fails_at = 200
    blocks = []
    with pytest.raises(DeviceLostError, match="take 100 of force: buffer overrun"):
        blocks.extend(counter.stream(["force"], 1.0, threading.Event()))
    assert counter.log == ["start 1", "halt"]


def test_short_block_is_refused(counter):
    counter.short = 1
    with pytest.raises(DeviceRejectedError, match=r"shapes \[\(99,\)\], expected \(100,\)"):
        list(counter.stream(["force"], 1.0, threading.Event()))


@pytest.mark.parametrize(
    ("change", "kind"),
    [
        (lambda values: values + 0j, "complex128"),
        (lambda values: np.ma.masked_array(values, values > 2), "masked"),
        (lambda values: values.astype(str), "<U"),
        (lambda values: values.astype("datetime64[s]"), "datetime64"),
        (lambda values: values.astype(object), "object"),
    ],
)
def test_samples_that_are_not_real_numbers_are_refused(counter, change, kind):
    """NumPy would drop an imaginary part or a mask with only a warning."""
    take = counter.take
    counter.take = lambda names, count: {
        name: change(values) for name, values in take(names, count).items()
    }
    with pytest.raises(DeviceRejectedError, match=f"force: the samples are {kind}.* real numbers"):
        list(counter.stream(["force"], 0.1, threading.Event()))
    assert counter.log[-1] == "halt"


def test_unknown_channel_or_closed_connection_is_refused_at_once(counter):
    with pytest.raises(DeviceRejectedError, match="no channel 'torque'"):
        counter.stream(["torque"], 1.0, threading.Event())
    counter.close()
    with pytest.raises(DeviceLostError, match="not connected"):
        counter.stream(["force"], 1.0, threading.Event())


def test_streaming_driver_passes_the_conformance_kit():
    counted: Subject = subject("device", "counter", registry=REGISTRY)
    failed = [check for check in examine(counted, checks("device")) if check.state is State.FAIL]
    assert failed == []


class Unplugged(Counter):
    """Loses its socket during a recording, so that halting fails too."""

    def halt(self):
        super().halt()
        raise DeviceLostError("given up after an earlier failure")


def test_error_of_a_stream_is_raised_with_a_note_on_the_failed_halt(tmp_path):
    device = Unplugged(None, DeviceContext("cell", SimulatedClock(), tmp_path))
    device.connect(1.0)
    device.fails_at = 100
    with pytest.raises(DeviceLostError, match="buffer overrun") as caught:
        list(device.stream(["force"], 0.25, threading.Event()))
    (note,) = caught.value.__notes__
    assert "halting the stream failed too: given up after an earlier failure" in note


def test_failed_halt_at_the_end_of_a_stream_is_an_error(tmp_path):
    device = Unplugged(None, DeviceContext("cell", SimulatedClock(), tmp_path))
    device.connect(1.0)
    with pytest.raises(DeviceLostError, match="given up"):
        list(device.stream(["force"], 0.25, threading.Event()))
