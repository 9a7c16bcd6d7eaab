from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from helpers_devices import FakeTester, Listener, plan_of, record, run
from rigrunner.api.data import Block
from rigrunner.api.errors import DataError, DeviceLostError, DeviceRejectedError
from rigrunner.api.events import Alarm, Outcome, Samples, StepEnded
from rigrunner.engine import streams
from rigrunner.steps.zero import Zero


def outcome_of(spoil, action=None):
    listener = Listener()
    plan = plan_of((), [action or record("001")], ())
    return run(FakeTester(spoil=spoil), plan, critical=[listener]), listener


def with_value(value: float):
    def spoil(blocks: list[Block]) -> list[Block]:
        torque = blocks[1].channels["torque"].copy()
        torque[17] = value
        channels = {**blocks[1].channels, "torque": torque}
        return [blocks[0], replace(blocks[1], channels=channels), *blocks[2:]]

    return spoil


def with_samples(change):
    """Return a function that changes the torque of the second block."""

    def spoil(blocks: list[Block]) -> list[Block]:
        torque = change(blocks[1].channels["torque"])
        return [blocks[0], replace(blocks[1], channels={**blocks[1].channels, "torque": torque})]

    return spoil


def with_noise(values):
    """Return a function that replaces the torque of all blocks."""

    def spoil(blocks: list[Block]) -> list[Block]:
        return [
            replace(
                block, channels={**block.channels, "torque": values[first : first + block.samples]}
            )
            for block in blocks
            for first in [block.first_sample]
        ]

    return spoil


def later(block: Block, seconds: float) -> Block:
    return replace(block, monotonic_s=block.monotonic_s + seconds)


@pytest.mark.parametrize(
    ("spoil", "error", "message"),
    [
        (lambda blocks: blocks[:-1], DeviceLostError,
         "tester: the stream ended after 200 samples, 250 were expected (0.25 s at 1000 Hz)"),
        (lambda _: [], DeviceLostError, "tester: the stream ended after 0 samples"),
        (lambda blocks: [blocks[0], blocks[2]], DeviceLostError,
         "tester: the stream has a gap: sample 200 came, 100 was due"),
        (lambda blocks: [blocks[0], blocks[0]], DeviceLostError,
         "tester: the stream came twice, or in a wrong order: sample 0 came, 100 was due"),
        (lambda blocks: [blocks[0], later(blocks[1], -0.2)], DeviceLostError,
         "tester: time goes back by 0.1 s at sample 100"),
        (lambda blocks: [blocks[0], later(blocks[1], math.nan)], DeviceLostError,
         "tester: time goes back by nan s at sample 100"),
        (lambda blocks: [blocks[0], later(blocks[1], 0.2), later(blocks[2], 0.2)], DeviceLostError,
         "tester: a gap in time of 0.2 s before sample 100, though none is missing by their count"),
        (lambda blocks: [replace(blocks[0], rate_hz=999.0)], DeviceRejectedError,
         "tester: the stream has 999 samples per second, not 1000"),
        (lambda blocks: [replace(blocks[0], channels={"angle": np.zeros(100)})], DeviceLostError,
         "tester.torque: the block at sample 0 lacks samples of this channel"),
        (lambda blocks: [replace(blocks[0], channels={
            "angle": np.zeros(100), "torque": np.zeros(99)})], DeviceLostError,
         "tester.torque: the block at sample 0 lacks samples of this channel"),
        (with_value(np.nan), DeviceLostError, "tester.torque: sample 117 is nan"),
        (with_value(-np.inf), DeviceLostError, "tester.torque: sample 117 is -inf"),
        (with_samples(lambda torque: torque + 1j), DeviceRejectedError,
         "tester.torque: the samples from 100 on are complex128, expected numbers, float64"),
        (with_samples(lambda torque: np.ma.array(torque, mask=torque > 0)), DeviceRejectedError,
         "tester.torque: the samples from 100 on are masked"),
        (with_samples(lambda torque: torque.astype("timedelta64[s]")), DeviceRejectedError,
         "tester.torque: the samples from 100 on are timedelta64[s]"),
        (with_samples(lambda torque: torque.astype(str)), DeviceRejectedError,
         "tester.torque: the samples from 100 on are <U32"),
        (with_samples(lambda torque: torque.astype(object)), DeviceRejectedError,
         "tester.torque: the samples from 100 on are object"),
        (lambda blocks: [blocks[0], blocks[1].channels], DeviceRejectedError,
         "tester: the stream gave a dict at sample 100, which is not a Block"),
        (lambda blocks: [replace(blocks[0], monotonic_s="now")], DeviceRejectedError,
         "tester: the stream gave a Block at sample 0, which is not a Block with times"),
    ],
)  # fmt: skip
def test_invalid_stream_fails_recording_with_reason(spoil, error, message):
    summary, listener = outcome_of(spoil)
    assert summary.outcome is Outcome.ERROR
    assert type(summary.error) is error
    assert message in summary.reason
    (ended,) = listener.of(StepEnded)
    assert (ended.ok, ended.recording) == (False, "001")


@pytest.mark.parametrize("shifts", [(0.0, 0.1, 0.0), (0.5, 0.4, 0.3), (0.0, -0.09, 0.05)])
def test_late_blocks_are_accepted_if_a_later_one_is_in_time(shifts):
    summary, _ = outcome_of(
        lambda blocks: [later(block, s) for block, s in zip(blocks, shifts, strict=True)]
    )
    assert summary.outcome is Outcome.COMPLETED


def test_time_gap_counts_from_least_late_block():
    summary, _ = outcome_of(
        lambda blocks: [later(block, s) for block, s in zip(blocks, (0.5, 0.45, 0.65), strict=True)]
    )
    assert "a gap in time of 0.2 s before sample 200" in summary.reason


@pytest.mark.parametrize(
    ("per_second", "gap_s", "outcome"),
    [
        (0.8e-3, 0.0, Outcome.COMPLETED),  # as two clocks may disagree: 0.24 s after 300 s
        (1.7e-3, 0.0, Outcome.ERROR),
        (0.0, 1.0, Outcome.ERROR),
    ],
)
def test_clocks_may_differ_by_one_thousandth(per_second, gap_s, outcome):
    seconds = 300

    def spoil(_) -> list[Block]:
        """Return a block for each second; the gap is in the middle."""
        samples = {"angle": np.zeros(1000), "torque": np.zeros(1000)}
        return [
            Block(1000.0, 1000 * n, n * (1 + per_second) + gap_s * (n >= seconds / 2), samples)
            for n in range(seconds)
        ]

    summary, _ = outcome_of(spoil, record("001", seconds=seconds))
    assert summary.outcome is outcome
    assert ("a gap in time of" in summary.reason) is (outcome is Outcome.ERROR)


def test_invalid_block_is_not_emitted():
    _, listener = outcome_of(with_value(np.nan))
    assert [event.block.first_sample for event in listener.of(Samples)] == [0]


def test_duration_may_be_rounded_down_to_whole_samples():
    summary, _ = outcome_of(lambda blocks: blocks, record("001", seconds=0.25049))
    assert summary.outcome is Outcome.COMPLETED


@pytest.mark.parametrize(("missing", "outcome"), [(1, Outcome.COMPLETED), (2, Outcome.ERROR)])
def test_stream_may_be_one_sample_short(missing, outcome):
    def spoil(blocks: list[Block]) -> list[Block]:
        last = {name: values[:-missing] for name, values in blocks[-1].channels.items()}
        return [*blocks[:-1], replace(blocks[-1], channels=last)]

    summary, _ = outcome_of(spoil)
    assert summary.outcome is outcome


def test_zero_beyond_its_limit_stops_run_and_names_value():
    action = Zero("tester", "torque", "N·m", within=0.005, duration_s=0.1)
    summary, _ = outcome_of(lambda blocks: blocks, action)
    assert isinstance(summary.error, DataError)
    # the mean of 100 samples of -0.01 + 1e-6 n
    assert "tester.torque reads -0.009951 N·m at rest, more than the 0.005 N·m allowed" in (
        summary.reason
    )


def test_zero_has_scatter_of_its_mean():
    noise = np.random.default_rng(75).normal(0, 1e-3, 100)
    action = Zero("tester", "torque", "N·m", within=0.05, duration_s=0.1)
    summary, listener = outcome_of(with_noise(noise), action)
    assert summary.outcome is Outcome.COMPLETED
    (ended,) = [event for event in listener.of(StepEnded) if event.action == "zero"]
    assert ended.values == {"tester.torque": pytest.approx(noise.mean(), rel=1e-9)}
    # white noise: s/sqrt(n) with n - 1 (GUM 4.2.3), but for correlation by chance
    u, dof = ended.scatter["tester.torque"]
    assert u == pytest.approx(noise.std(ddof=1) / 10, rel=0.2)
    assert 50 <= dof <= 99


def test_zero_of_equal_samples_has_no_scatter():
    action = Zero("tester", "torque", "N·m", within=0.05, duration_s=0.1)
    summary, listener = outcome_of(with_noise(np.full(100, 0.01)), action)
    assert summary.outcome is Outcome.COMPLETED
    (ended,) = listener.of(StepEnded)
    assert ended.scatter == {"tester.torque": (0.0, 99.0)}  # then its resolution counts


def test_zero_needs_samples():
    action = Zero("tester", "torque", "N·m", within=0.05, duration_s=0.0)
    summary, _ = outcome_of(lambda blocks: blocks, action)
    assert isinstance(summary.error, DataError)
    assert "tester.torque: no sample came in 0 s" in summary.reason


@pytest.mark.parametrize("dtype", [np.float32, np.int16, ">f8", np.bool_])
def test_other_number_types_become_float64(dtype):
    summary, listener = outcome_of(
        lambda blocks: [
            *with_samples(lambda torque: (100 * torque).astype(dtype))(blocks),
            blocks[2],
        ]
    )
    assert summary.outcome is Outcome.COMPLETED
    dtypes = [event.block.channels["tester.torque"].dtype for event in listener.of(Samples)]
    assert dtypes == [np.dtype("<f8")] * 3


class _Endless:
    """Spoils a stream so that it never ends."""

    def __init__(self, samples):
        self._samples = samples

    def __call__(self, blocks):
        first = 0
        while True:
            torque = {name: np.zeros(self._samples) for name in blocks[0].channels}
            yield Block(1000.0, first, first / 1000.0, torque)
            first += self._samples


@pytest.mark.parametrize(("empty", "outcome"), [(3, Outcome.COMPLETED), (4, Outcome.ERROR)])
def test_number_of_consecutive_empty_blocks_is_limited(monkeypatch, empty, outcome):
    def spoil(blocks: list[Block]) -> list[Block]:
        nothing = {name: np.zeros(0) for name in blocks[0].channels}
        return [
            piece
            for block in blocks
            for piece in [*[replace(block, channels=nothing)] * empty, block]
        ]

    monkeypatch.setattr(streams, "MOST_EMPTY", 3)
    summary, _ = outcome_of(spoil)
    assert summary.outcome is outcome


@pytest.mark.parametrize(("samples", "seen"), [(100, 300), (1, 252), (0, 0)])
def test_endless_stream_is_ended(samples, seen):
    summary, _ = outcome_of(_Endless(samples))
    assert isinstance(summary.error, DeviceRejectedError)
    assert summary.reason.startswith(f"tester: the stream does not end: {seen} samples and another")


@pytest.mark.parametrize("rate_hz", [0.0, -5.0, math.nan, math.inf, None, "1000"])
def test_sample_rate_must_be_a_positive_number(rate_hz):
    tester = FakeTester()
    tester.sample_rate_hz = rate_hz
    summary = run(tester, plan_of((), [record("001")], ()))
    assert isinstance(summary.error, DeviceRejectedError)
    assert summary.reason.startswith("tester: the driver gave ")


class Unhalted(FakeTester):
    """A tester whose stream cannot be stopped properly."""

    def stream(self, channels, duration_s, stop):
        try:
            yield from super().stream(channels, duration_s, stop)
        except GeneratorExit:
            raise DeviceLostError("the stop was not answered") from None


@pytest.mark.parametrize("non_blocking", [True, False])
def test_first_stream_error_is_reported_before_failure_to_end_stream(non_blocking):
    def spoil(blocks):
        return [blocks[0], blocks[2]]

    listener = Listener()
    tester = Unhalted(spoil=spoil, non_blocking=non_blocking)
    summary = run(tester, plan_of((), [record("001")], ()), critical=[listener])
    first = "tester: the stream has a gap: sample 200 came, 100 was due"
    second = "ending the stream failed too: tester: the stop was not answered"
    assert isinstance(summary.error, DeviceLostError)
    assert summary.reason == f"{first}; {second}"
    assert listener.of(Alarm)[0].text == f"{first}; {second}"
