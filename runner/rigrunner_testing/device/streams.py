"""Checks on streams: gapless, in time, stopped on request."""

from __future__ import annotations

import threading
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from rigrunner_testing.check import applies, check, demand
from rigrunner_testing.device.doing import close_stream, streamed_blocks, streamed_names, streamer

if TYPE_CHECKING:
    from rigrunner.api.data import Block
    from rigrunner.api.devices import Device, Streaming
    from rigrunner_testing.device.subject import DeviceSubject

STREAMED_S = 0.55
TIME_OFF_S, TIME_OFF_PART = 0.5, 0.25
"""Tolerance of the duration of a stream, seen from outside."""


@check(
    fix="count samples, not blocks: `first_sample` increases by the samples of each block",
    needs=("quantities_declared",),
)
def streams_are_gapless(subject: DeviceSubject) -> None:
    """A stream begins with sample 0, has no gaps, and as many samples as it lasts."""
    with subject.connected() as device:
        rate_hz = _rate(device)
        blocks = streamed_blocks(device, STREAMED_S)
        demand(blocks, f"a stream of {STREAMED_S} s gives nothing")
        demand(blocks[0].first_sample == 0, f"it begins with sample {blocks[0].first_sample}")
        for before, after in pairwise(blocks):
            expected = before.first_sample + before.samples
            demand(
                after.first_sample == expected,
                f"sample {expected} is followed by sample {after.first_sample}",
            )
        total, due = sum(block.samples for block in blocks), round(STREAMED_S * rate_hz)
        demand(abs(total - due) <= 1, f"{STREAMED_S} s give {total} samples, not {due}")


@check(
    fix="give each Block float64 arrays of one length, in SI units, for the channels asked",
    needs=("streams_are_gapless",),
)
def blocks_are_whole(subject: DeviceSubject) -> None:
    """Every block has the requested channels, of equal length, finite, at the stated rate."""
    with subject.connected() as device:
        rate_hz, channels = _rate(device), streamed_names(device)
        received, copies = [], []
        stream = streamer(device).stream(channels, STREAMED_S, threading.Event())
        for block in stream:
            _check_block(block, channels, rate_hz)
            received.append(block)
            copies.append({name: values.copy() for name, values in block.channels.items()})
        applies(received, "its stream gives nothing")
        for block, before in zip(received, copies, strict=True):
            for name, values in before.items():
                is_same = np.array_equal(values, block.channels[name])
                demand(is_same, f"{name} at sample {block.first_sample} changed after it was given")
        times = [block.monotonic_s for block in received]
        demand(times == sorted(times), "the time of its blocks goes back")


def _check_block(block: Block, channels: list[str], rate_hz: float) -> None:
    present = [*block.channels]
    demand(set(present) == set(channels), f"asked for {channels}, it gave {present}")
    demand(
        np.isclose(block.rate_hz, rate_hz),
        f"its blocks have {block.rate_hz:g} samples per second, stated are {rate_hz:g}",
    )
    for name, values in block.channels.items():
        what = f"{name} at sample {block.first_sample}"
        is_array = type(values) is np.ndarray and values.dtype == np.float64
        demand(is_array, f"{what} is not an array of float64")
        demand(values.shape == (block.samples,), f"{what} has the shape {values.shape}")
        demand(np.isfinite(values).all(), f"{what} holds values that are not finite")


@check(
    fix="wait for the samples' time by `context.clock`; state the true `sample_rate_hz`",
    needs=("blocks_are_whole",),
)
def streams_take_their_time(subject: DeviceSubject) -> None:
    """A stream takes as long as its samples last."""
    clock = subject.clock()
    with subject.connected(clock=clock) as device:
        _rate(device)
        began_s = clock.monotonic_s()
        streamed_blocks(device, STREAMED_S)
        took_s = clock.monotonic_s() - began_s
        allowed_s = TIME_OFF_PART * STREAMED_S + (0.0 if subject.simulated else TIME_OFF_S)
        demand(
            abs(took_s - STREAMED_S) <= allowed_s,
            f"a stream of {STREAMED_S} s took {took_s:.2f} s",
        )


@check(
    fix="look at `stop.is_set()` before each block, and state `stop_latency_s` of the record",
    needs=("blocks_are_whole",),
)
def stops_in_time(subject: DeviceSubject) -> None:
    """On request, a stream ends within the latency that the record states."""
    clock, stop, latency_s = subject.clock(), threading.Event(), subject.record.stop_latency_s
    with subject.connected(clock=clock) as device:
        rate_hz = _rate(device)
        lasts_s = 3 * latency_s + 2.0
        stream = iter(streamer(device).stream(streamed_names(device), lasts_s, stop))
        next(stream, None)
        stop.set()
        stopped_s, samples = clock.monotonic_s(), 0
        for block in stream:
            samples += block.samples
        took_s = max(clock.monotonic_s() - stopped_s, samples / rate_hz)
        demand(
            took_s <= latency_s,
            f"a stream of {lasts_s:g} s continued for {took_s:.2f} s, expected at most"
            f" {latency_s:g} s",
        )


@check(
    fix="free what a stream holds in `finally`, so that it may be left at any block",
    needs=("blocks_are_whole",),
)
def streams_may_be_left(subject: DeviceSubject) -> None:
    """A stream that is left before its end does not disturb the next one."""
    with subject.connected() as device:
        streaming = streamer(device)
        for _ in range(3):
            stream = iter(streaming.stream(streamed_names(device), 2.0, threading.Event()))
            demand(next(stream, None) is not None, "a stream after one that was left gives nothing")
            close_stream(stream)
        blocks = streamed_blocks(device, STREAMED_S)
        total = sum(block.samples for block in blocks)
        demand(blocks and blocks[0].first_sample == 0, "the stream after that does not begin again")
        demand(
            abs(total - STREAMED_S * streaming.sample_rate_hz) <= 1,
            f"the stream after that has {total} samples",
        )


def _rate(device: Device) -> float:
    """Return the sample rate; raise NotApplicable, or Nonconformity if it is invalid."""
    streaming: Streaming = streamer(device)
    rate_hz = streaming.sample_rate_hz
    demand(0 < rate_hz < np.inf, f"the sample rate is {rate_hz} Hz")
    return rate_hz


CHECKS = (
    streams_are_gapless,
    blocks_are_whole,
    streams_take_their_time,
    stops_in_time,
    streams_may_be_left,
)
