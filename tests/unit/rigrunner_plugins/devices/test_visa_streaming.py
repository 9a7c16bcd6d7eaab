"""Recordings behind VISA: gapless blocks on one clock, and an acquisition that always ends."""

from __future__ import annotations

import struct
from itertools import pairwise

import numpy as np
import pytest
import yaml

from helpers_docs import ROOT, code_blocks
from rigrunner.api.devices import Streaming
from rigrunner.api.errors import (
    DeviceError,
    DeviceLostError,
    DeviceRejectedError,
    DeviceTimeoutError,
    PluginError,
)
from rigrunner.clock import SimulatedClock
from rigrunner.rig import Rig
from unit.rigrunner_plugins.devices.helpers_instruments import instrument, merged
from unit.rigrunner_plugins.devices.helpers_peers import HANG_UP, SILENCE, Lines, SocketPeer, peer

RATE_HZ = 10_000
STREAM = {
    "rate": "10 kHz",
    "channels": ["angle", "torque"],
    "start": "INIT",
    "stop": "ABOR",
    "fetch": "TRAC:DATA? {samples}",
    "format": "float32",
    "byte_order": "little",
    "samples": 1000,
    "overrun": {"query": "TRAC:OVER?", "good": "0"},
}
SETTINGS = {
    "termination": "LF",
    "timeout": "700 ms",
    "channels": {
        "angle": {"query": "MEAS:ANGL?", "unit": "deg"},
        "torque": {"query": "MEAS:TORQ?", "unit": "N·m", "scale": 2.0},
    },
}
QUARTER = 0.25


class Stop:
    def __init__(self, after=10**9):
        self.looks = after

    def is_set(self):
        self.looks -= 1
        return self.looks < 0


class Digitizer:
    """Angle is the number of the sample in 1/100 deg, torque its negative, at the sample rate.

    Time passes only while it samples, or is slow.
    """

    def __init__(self):
        self.clock = SimulatedClock()
        self.code, self.rate = "<f4", RATE_HZ
        self.next = 0
        self.started = None
        self.over = "0"
        self.slow_s = 0.0
        self.spoil = lambda block: block

    def block(self, count):
        numbers = np.arange(self.next, self.next + count)
        self.next += count
        due_s = self.started + self.next / self.rate
        self.clock.sleep(max(0.0, due_s - self.clock.monotonic_s()))
        return np.stack([numbers / 100, -numbers], axis=1)

    def __call__(self, line):
        if line == "INIT":
            self.next, self.started = 0, self.clock.monotonic_s()
        elif line.startswith("TRAC:DATA?"):
            values = self.block(int(line.split()[1]) if " " in line else 700)
            return self.spoil(self.sent(values))
        elif line == "SYST:ERR?":
            self.clock.sleep(self.slow_s)
            return b'0,"No error"\n'
        elif line == "TRAC:OVER?":
            return f"{self.over}\n".encode()
        return SILENCE

    def sent(self, values):
        if self.code == "ascii":
            return (",".join(f"{value:.6E}" for value in values.ravel()) + "\n").encode()
        data = values.astype(self.code).tobytes()
        length = str(len(data)).encode()
        return b"#%d%s%s\n" % (len(length), length, data)


@pytest.fixture
def digitizer():
    return Digitizer()


@pytest.fixture
def talk(digitizer):
    return Lines(digitizer)


@pytest.fixture
def bench(talk):
    with peer(SocketPeer, talk) as server:
        yield server


@pytest.fixture
def make(bench, digitizer):
    devices = []

    def connected(**stream):
        stream = merged(STREAM, **stream)
        settings = merged(SETTINGS, resource=bench.resource, stream=stream)
        device = instrument("visa", settings, digitizer.clock)
        devices.append(device)
        device.connect(2.0)
        return device

    yield connected
    for device in devices:
        device.close()


def joined(blocks, channel):
    return np.concatenate([block.channels[channel] for block in blocks])


def test_angle_and_torque_are_sampled_together_and_gapless(make, talk):
    device = make()
    assert isinstance(device, Streaming)
    start_s = device.clock.monotonic_s()
    blocks = list(device.stream(["torque", "angle"], QUARTER, Stop()))
    took_s = device.clock.monotonic_s() - start_s
    assert [block.first_sample for block in blocks] == [0, 1000, 2000]
    assert [block.samples for block in blocks] == [1000, 1000, 500]
    assert {block.rate_hz for block in blocks} == {RATE_HZ}
    numbers = np.arange(2500)
    assert joined(blocks, "angle") == pytest.approx(np.deg2rad(numbers / 100), rel=1e-6)
    assert joined(blocks, "torque") == pytest.approx(-2.0 * numbers)
    assert all(a.monotonic_s <= b.monotonic_s for a, b in pairwise(blocks))
    assert took_s == pytest.approx(QUARTER)
    assert talk.heard[0] == "INIT"
    assert talk.last("ABOR") == "ABOR"
    assert talk.heard[-3:-1] == ["TRAC:DATA? 500", "TRAC:OVER?"]


@pytest.mark.parametrize(
    ("settings", "code"),
    [
        ({"format": "float64", "byte_order": "big"}, ">f8"),
        ({"format": "int16", "byte_order": "big"}, ">i2"),
        ({"format": "int32", "byte_order": "little"}, "<i4"),
        ({"format": "ascii", "byte_order": None}, "ascii"),
    ],
)
def test_samples_in_other_formats_are_decoded(make, digitizer, settings, code):
    digitizer.code = code
    (block,) = make(**settings).stream(["torque"], 0.1, Stop())
    assert block.channels["torque"] == pytest.approx(-2.0 * np.arange(1000))


def test_blocks_may_be_shorter_than_requested(make):
    device = make(fetch="TRAC:DATA?")
    blocks = list(device.stream(["torque"], 0.1, Stop()))
    assert [block.samples for block in blocks] == [700, 300]


def test_second_recording_starts_at_sample_0(make):
    device = make()
    for _ in range(2):
        (block,) = device.stream(["torque"], 0.05, Stop())
        assert block.first_sample == 0
        assert block.channels["torque"][0] == 0.0


class TestEndOfAcquisition:
    def test_acquisition_ends_when_the_run_is_stopped(self, make, talk):
        assert len(list(make().stream(["angle"], 5.0, Stop(after=2)))) == 2
        assert talk.last("ABOR") == "ABOR"

    def test_acquisition_ends_when_the_stream_is_closed(self, make, talk):
        device = make()
        blocks = device.stream(["angle"], 5.0, Stop())
        next(blocks)
        blocks.close()
        assert talk.last("ABOR") == "ABOR"

    def test_acquisition_ends_after_an_error(self, make, digitizer, talk):
        digitizer.over = "1"
        with pytest.raises(DeviceRejectedError, match=r"samples were lost.*'TRAC:OVER\?' with '1'"):
            list(make().stream(["angle"], 1.0, Stop()))
        assert talk.last("ABOR") == "ABOR"

    def test_acquisition_ends_after_silence(self, make, digitizer, talk):
        digitizer.spoil = lambda _block: SILENCE
        with pytest.raises(DeviceTimeoutError, match=r"no block in answer to 'TRAC:DATA\? 1000'"):
            list(make().stream(["angle"], 1.0, Stop()))
        assert talk.last("ABOR") == "ABOR"

    def test_acquisition_ends_after_a_lost_connection(self, make, digitizer, talk):
        blocks = []

        def breaks(block):
            return block if len(blocks) < 2 else HANG_UP

        digitizer.spoil = breaks
        with pytest.raises(DeviceLostError, match="closed the connection"):
            blocks.extend(make().stream(["angle"], 1.0, blocks_seen(blocks)))
        assert talk.last("ABOR") == "ABOR"

    def test_failure_to_end_the_acquisition_is_added_to_the_error(self, make, digitizer, bench):
        def gone(_block):
            bench.close()
            return HANG_UP

        digitizer.spoil = gone
        with pytest.raises(DeviceError) as raised:
            list(make().stream(["angle"], 1.0, Stop()))
        assert "stopping the acquisition failed too" in " ".join(raised.value.__notes__)


def blocks_seen(blocks):
    """A stop token that is never set, and counts how often it was checked."""

    class Counts:
        def is_set(self):
            blocks.append(None)
            return False

    return Counts()


NAN_AND_ONE = struct.pack("<2f", np.nan, 1)
OVERLOAD = struct.pack("<2f", 1, 9.9e37)


@pytest.mark.parametrize(
    ("block", "message"),
    [
        (b"1.0,2.0\n", "begins with b'1.', a block begins with # and a digit"),
        (b"#0abcdefgh\n", "of indefinite length, whose end is not marked"),
        (b"#2x1\n", "says b'x1' where its length should be"),
        (b"#18abcdefgh\r\n", r"comes b'\\r', the station says LF"),
        (b"#15abcde\n", "has 5 bytes, which is not a multiple of the 4 of float32"),
        (b"#14abcd\n", "gives 1 numbers, which is not a multiple of 2 channels: angle"),
        (b"#10\n", "gives no more samples after 0"),
        (b"#18" + OVERLOAD + b"\n", "torque is 9.9e.37 in sample 0"),
        (b"#18" + NAN_AND_ONE + b"\n", "angle is nan in sample 0"),
    ],
)
def test_invalid_blocks_are_reported(make, digitizer, block, message):
    digitizer.spoil = lambda _block: block
    with pytest.raises(DeviceError, match=message):
        list(make().stream(["angle"], 0.1, Stop()))


GPIB = """
spec: "1.0"
devices:
  scope:
    eom: {GPIB INSTR: {q: "\\n", r: "\\n"}}
    error: ERROR
    dialogues:
      - {q: INIT}
      - {q: ABOR}
      - {q: "TRAC:DATA? 2", r: "ANSWER"}
resources:
  GPIB0::5::INSTR: {device: scope}
"""


@pytest.mark.parametrize("answer", ["#18ABCDABCD", "#0ABCDABCD"])
def test_end_of_message_on_a_bus_ends_the_block(tmp_path, answer):
    tmp_path.joinpath("scope.yaml").write_text(GPIB.replace("ANSWER", answer))
    stream = merged(STREAM, format="int16", byte_order="big", samples=2, paced="no", overrun=None)
    settings = merged(SETTINGS, resource="GPIB0::5::INSTR", backend="scope.yaml@sim", stream=stream)
    device = instrument("visa", merged(settings, simulated="yes"), folder=tmp_path)
    device.connect(1.0)
    (block,) = device.stream(["angle", "torque"], 2 / RATE_HZ, Stop())
    # 'AB' is 0x4142 = 16706 deg, 'CD' is 0x4344 = 17220, doubled by the scale
    assert block.channels["angle"] == pytest.approx(np.deg2rad([16706, 16706]))
    assert block.channels["torque"] == pytest.approx([34440, 34440])
    device.close()


def test_more_samples_than_requested_are_refused(make, digitizer):
    digitizer.spoil = lambda _block: digitizer.sent(digitizer.block(1001))
    with pytest.raises(DeviceRejectedError, match="gives 1001 samples instead of 1000"):
        list(make().stream(["angle"], 1.0, Stop()))


class TestSampleRate:
    def test_samples_faster_than_the_declared_rate_are_refused(self, make, digitizer):
        digitizer.rate = 2 * RATE_HZ
        with pytest.raises(
            DeviceRejectedError, match=r"they take .* sample rate of the instrument"
        ):
            list(make().stream(["angle"], 1.0, Stop()))

    def test_slow_start_command_does_not_count_as_too_fast(self, bench, digitizer):
        digitizer.slow_s = 0.2
        settings = merged(SETTINGS, resource=bench.resource, stream=STREAM, error_queue={})
        device = instrument("visa", settings, digitizer.clock)
        device.connect(2.0)
        assert len(list(device.stream(["angle"], QUARTER, Stop()))) == 3
        device.close()

    def test_full_buffer_may_be_read_at_once_if_not_paced(self, make, digitizer):
        digitizer.rate = 1e9
        assert len(list(make(paced="no").stream(["angle"], 1.0, Stop()))) == 10


def test_stream_works_in_a_rig(make):
    device = make()
    rig = Rig({"bench": device}, device.clock)
    rig.connect()
    blocks = list(rig.stream("bench", ["angle", "torque"], QUARTER, Stop()))
    assert sum(block.samples for block in blocks) == 2500
    rig.close()


def test_channel_that_is_not_streamed_is_refused(make):
    with pytest.raises(DeviceRejectedError, match=r"'speed'.*angle, torque"):
        make().stream(["speed"], 1.0, Stop())


def test_stream_of_the_manual_records(bench, digitizer):
    page = ROOT / "docs/how-to/bind-a-scpi-instrument.md"
    (stream,) = [block.code for block in code_blocks(page) if block.file == "stream.yaml"]
    digitizer.code = ">f4"
    settings = merged(SETTINGS, resource=bench.resource, **yaml.safe_load(stream))
    device = instrument("visa", settings, digitizer.clock)
    device.connect(2.0)
    (block,) = device.stream(["angle", "torque"], 0.1, Stop())
    assert block.channels["torque"] == pytest.approx(-2.0 * np.arange(1000))
    device.close()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"byte_order": None}, "float32 needs byte_order: little or big"),
        ({"samples": 10_000}, "10000 samples take 1 s, expected at most 0.5 s"),
        ({"channels": ["angle", "speed"]}, "stream names 'speed', which is not among channels"),
        ({"channels": ["angle", "angle"]}, "a channel is listed twice"),
        ({"stop": None}, "stop: Field required"),
    ],
)
def test_invalid_settings_are_refused(changes, message):
    stream = merged(STREAM, **changes)
    with pytest.raises(PluginError, match=message):
        instrument("visa", merged(SETTINGS, resource="GPIB0::5::INSTR", stream=stream))
