"""Each check of devices passes a conforming device and fails a broken one."""

from __future__ import annotations

import asyncio
import threading
from dataclasses import replace

import numpy as np
import pytest

from rigrunner_testing import Nonconformity, State, checks, conform, examine_one, subject
from unit.rigrunner_testing.helpers_zoo import BROKEN, Press, press

CHECKS = {check.name: check for check in checks("device")}


def test_every_check_has_a_broken_device():
    assert set(BROKEN) == set(CHECKS)


@pytest.mark.parametrize("name", CHECKS)
def test_conforming_device_passes(name):
    assert conform(subject("device", "press", registry=press()), CHECKS[name]) == ""


@pytest.mark.parametrize("name", CHECKS)
def test_broken_device_fails(name):
    changes = BROKEN[name]
    device = subject("device", changes.get("name", "press"), registry=press(**changes))
    finding = examine_one(device, CHECKS[name])
    assert finding.state is State.FAIL
    assert finding.text
    assert not device.made_devices


def test_simulator_must_declare_itself():
    class ClaimsToBeReal(Press):
        def open(self, timeout_s):
            return replace(super().open(timeout_s), simulated=False)

    device = subject("device", "press", registry=press(factory=ClaimsToBeReal))
    finding = examine_one(device, CHECKS["connects_and_says_who_it_is"])
    assert "generates its samples" in finding.text
    device = subject("device", "press", registry=press(simulated=False))
    finding = examine_one(device, CHECKS["connects_and_says_who_it_is"])
    assert "its record does not" in finding.text


def test_crash_fails_the_check_with_its_line():
    class Crashes(Press):
        def get(self, _channel):
            raise ZeroDivisionError("division by zero")

    device = subject("device", "press", registry=press(factory=Crashes))
    finding = examine_one(device, CHECKS["readings_are_true"])
    assert finding.state is State.FAIL
    assert "ZeroDivisionError: division by zero at " in finding.text
    assert "test_device_checks.py:" in finding.text


@pytest.mark.parametrize("error", [SystemExit(0), asyncio.CancelledError()])
def test_exit_and_cancellation_fail_the_check(error):
    """In the thread of the check it would end that thread, and the check would seem to pass."""

    class Ends(Press):
        def get(self, _channel):
            raise error

    device = subject("device", "press", registry=press(factory=Ends))
    finding = examine_one(device, CHECKS["readings_are_true"])
    assert finding.state is State.FAIL
    assert type(error).__name__ in finding.text


class _Masked(Press):
    def block(self, channels, first, noise):
        block = super().block(channels, first, noise)
        channels = block.channels.items()
        masked = {name: np.ma.array(values, mask=values > 0) for name, values in channels}
        return replace(block, channels=masked)


class _InOneBuffer(Press):
    """Reuses one array for all blocks, as a library may."""

    buffer = np.zeros(10_000)

    def block(self, channels, first, noise):
        block = super().block(channels, first, noise)
        shared = {}
        for name, values in block.channels.items():
            self.buffer[: len(values)] = values
            shared[name] = self.buffer[: len(values)]
        return replace(block, channels=shared)


@pytest.mark.parametrize(
    ("factory", "message"),
    [(_Masked, "is not an array of float64"), (_InOneBuffer, "changed after it was given")],
)
def test_masked_and_reused_arrays_fail(factory, message):
    device = subject("device", "press", registry=press(factory=factory))
    finding = examine_one(device, CHECKS["blocks_are_whole"])
    assert finding.state is State.FAIL
    assert message in finding.text


def test_hanging_device_fails_after_a_timeout():
    released = threading.Event()

    class Hangs(Press):
        def get(self, channel):
            released.wait()
            return super().get(channel)

    device = subject("device", "press", registry=press(factory=Hangs))
    finding = examine_one(device, CHECKS["readings_are_true"], longest_s=0.2)
    released.set()
    assert finding.text == "it did not come back within 0.2 s"


def test_thread_that_ends_soon_after_closing_is_no_leak():
    class EndsItsThreadLater(Press):
        def open(self, timeout_s):
            threading.Timer(0.4, lambda: None).start()
            return super().open(timeout_s)

    device = subject("device", "press", registry=press(factory=EndsItsThreadLater))
    assert examine_one(device, CHECKS["gives_back_what_it_took"]).state is State.PASS


def test_failure_states_a_fix():
    device = subject("device", "press", registry=press(help=""))
    with pytest.raises(Nonconformity, match=r"(?s)found: the record's help is empty.*fix: write"):
        conform(device, CHECKS["help_line"])


def test_read_only_sets_no_drive():
    calls = []

    class RecordsCalls(Press):
        def put(self, drive, value):
            calls.append((drive, value))

        def make_safe(self):
            calls.append("safe")
            return super().make_safe()

    device = replace(
        subject("device", "press", registry=press(factory=RecordsCalls)), read_only=True
    )
    for check in (check for check in checks("device") if not check.moves):
        examine_one(device, check)
    assert calls == []
