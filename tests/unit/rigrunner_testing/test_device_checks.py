"""Each check of devices passes one that keeps to everything, and fails one that is broken."""

from __future__ import annotations

import asyncio
import threading
from dataclasses import replace

import numpy as np
import pytest

from rigrunner_testing import Nonconformity, State, checks, conform, examine_one, subject
from unit.rigrunner_testing.helpers_zoo import BROKEN, Press, press

CHECKS = {each.name: each for each in checks("device")}


def test_there_is_a_broken_device_for_every_check():
    assert set(BROKEN) == set(CHECKS)


@pytest.mark.parametrize("name", CHECKS)
def test_what_keeps_to_everything_passes(name):
    assert conform(subject("device", "press", registry=press()), CHECKS[name]) == ""


@pytest.mark.parametrize("name", CHECKS)
def test_what_is_broken_fails(name):
    changes = BROKEN[name]
    known = subject("device", changes.get("name", "press"), registry=press(**changes))
    found = examine_one(known, CHECKS[name])
    assert found.state is State.FAIL
    assert found.text
    assert not known.made_devices


def test_what_makes_its_samples_up_must_say_so():
    class SaysItIsReal(Press):
        def open(self, timeout_s):
            return replace(super().open(timeout_s), simulated=False)

    known = subject("device", "press", registry=press(factory=SaysItIsReal))
    found = examine_one(known, CHECKS["connects_and_says_who_it_is"])
    assert "generates its samples" in found.text
    known = subject("device", "press", registry=press(simulated=False))
    found = examine_one(known, CHECKS["connects_and_says_who_it_is"])
    assert "its record does not" in found.text


def test_a_crash_is_a_failed_check_with_its_place():
    class Crashes(Press):
        def get(self, _channel):
            raise ZeroDivisionError("division by zero")

    known = subject("device", "press", registry=press(factory=Crashes))
    found = examine_one(known, CHECKS["readings_are_true"])
    assert found.state is State.FAIL
    assert "ZeroDivisionError: division by zero at " in found.text
    assert "test_device_checks.py:" in found.text


@pytest.mark.parametrize("error", [SystemExit(0), asyncio.CancelledError()])
def test_what_would_end_the_program_is_a_failed_check(error):
    """Alone in its thread it would end that, and the check would seem to be met."""

    class Ends(Press):
        def get(self, _channel):
            raise error

    known = subject("device", "press", registry=press(factory=Ends))
    found = examine_one(known, CHECKS["readings_are_true"])
    assert found.state is State.FAIL
    assert type(error).__name__ in found.text


class _Masked(Press):
    def block(self, channels, first, noise):
        whole = super().block(channels, first, noise)
        masked = {name: np.ma.array(each, mask=each > 0) for name, each in whole.channels.items()}
        return replace(whole, channels=masked)


class _InOneBuffer(Press):
    """Fills the same array again for each block, as a library may."""

    buffer = np.zeros(10_000)

    def block(self, channels, first, noise):
        whole = super().block(channels, first, noise)
        lent = {}
        for name, values in whole.channels.items():
            self.buffer[: len(values)] = values
            lent[name] = self.buffer[: len(values)]
        return replace(whole, channels=lent)


@pytest.mark.parametrize(
    ("factory", "said"),
    [(_Masked, "is not an array of float64"), (_InOneBuffer, "changed after it was given")],
)
def test_a_block_is_whole_and_stays_so(factory, said):
    known = subject("device", "press", registry=press(factory=factory))
    found = examine_one(known, CHECKS["blocks_are_whole"])
    assert found.state is State.FAIL
    assert said in found.text


def test_what_hangs_is_given_up():
    hangs = threading.Event()

    class Hangs(Press):
        def get(self, channel):
            hangs.wait()
            return super().get(channel)

    known = subject("device", "press", registry=press(factory=Hangs))
    found = examine_one(known, CHECKS["readings_are_true"], longest_s=0.2)
    hangs.set()
    assert found.text == "it did not come back within 0.2 s"


def test_what_to_do_is_told():
    known = subject("device", "press", registry=press(help=""))
    with pytest.raises(Nonconformity, match=r"(?s)found: the record's help is empty.*fix: write"):
        conform(known, CHECKS["help_line"])


def test_read_only_nothing_is_set():
    told = []

    class Tells(Press):
        def put(self, drive, value):
            told.append((drive, value))

        def make_safe(self):
            told.append("safe")
            return super().make_safe()

    known = replace(subject("device", "press", registry=press(factory=Tells)), read_only=True)
    for check in (each for each in checks("device") if not each.moves):
        examine_one(known, check)
    assert told == []
