"""Checks on simulators, and on devices that declare that they never block."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from rigrunner.api.devices import CountsStreams, KnowsTruth, Readable, Settable, Streaming
from rigrunner.api.settings import MadeOfOthers
from rigrunner_testing.check import NotApplicable, applies, check, demand
from rigrunner_testing.device.doing import move, names, streamed_blocks, streamer
from rigrunner_testing.own_time import TRIES, measured

if TYPE_CHECKING:
    from collections.abc import Callable

    from rigrunner.api.data import Array
    from rigrunner.api.devices import Device
    from rigrunner_testing.device.subject import DeviceSubject

STREAMED_S = 0.3
WAITS_S = 0.2
"""A call that spends more time than this without computing waits for something."""


@check(
    moves=True,
    fix="draw from a generator that the settings' `seed` alone determines",
    needs=("readings_are_true", "drives_go_where_they_are_set", "blocks_are_whole"),
)
def same_seed_same_samples(subject: DeviceSubject) -> None:
    """A simulator with the same settings gives the same samples."""
    applies(subject.simulated, "it is not simulated")
    first, second = _samples(subject), _samples(subject)
    for name, values in first.items():
        is_same = np.array_equal(values, second[name], equal_nan=True)
        demand(is_same, f"{name} is not the same in two devices with the same settings")


@check(
    moves=True,
    fix="seed the generator with the settings' `seed`",
    needs=("same_seed_same_samples",),
)
def other_seed_other_samples(subject: DeviceSubject) -> None:
    """A simulator with another seed gives other samples."""
    model = subject.record.settings_model
    applies(subject.simulated, "it is not simulated")
    applies("seed" in model.model_fields, "its settings have no `seed`")
    applies(not issubclass(model, MadeOfOthers), "the samples are those of what it wraps")
    seed = subject.settings.get("seed", model.model_fields["seed"].get_default() or 0)
    first, second = _samples(subject, seed=int(seed)), _samples(subject, seed=int(seed) + 1)
    differs = any(not np.array_equal(first[name], second[name]) for name in first)
    demand(differs, f"with the seeds {seed} and {seed + 1} it gives the same samples")


@check(
    moves=True,
    fix="let `continue_after` count each stream as if it had been given",
    needs=("blocks_are_whole",),
)
def continues_after_streams(subject: DeviceSubject) -> None:
    """Given the streams of a run so far, it gives the next one, not the first."""
    with subject.connected() as device:
        streamer(device)
        applies(isinstance(device, CountsStreams), "it does not count streams")
        set_points = move(subject, device)
        first, second = _streamed(device), _streamed(device)
    with subject.connected() as device:
        assert isinstance(device, CountsStreams)  # noqa: S101  (just seen)
        move(subject, device)
        device.continue_after([set_points])
        resumed = _streamed(device)
    differing = [name for name in first if not np.array_equal(first[name], second[name])]
    applies(differing, "its second stream is the same as its first")
    differs = any(not np.array_equal(first[name], resumed[name]) for name in differing)
    demand(differs, "resumed after one stream, it gives the samples of the first once more")


@check(fix="do not implement `truth` in a device that is not simulated")
def only_a_simulator_knows_the_truth(subject: DeviceSubject) -> None:
    """Only a simulator gives true values, and they are finite numbers."""
    with subject.connected() as device:
        if not isinstance(device, KnowsTruth):
            raise NotApplicable("it has no true values")
        truth = device.truth()
        demand(
            subject.simulated or not truth,
            f"it is not simulated, but has true values of {', '.join(truth)}",
        )
        infinite = [name for name, value in truth.items() if not np.isfinite(value)]
        demand(not infinite, f"its true value of {', '.join(infinite)} is not a finite number")


@check(
    moves=True,
    fix="state `non_blocking = True` only if no call waits; wait by `context.clock`",
    needs=("readings_are_true", "drives_go_where_they_are_set", "blocks_are_whole"),
)
def non_blocking_is_true(subject: DeviceSubject) -> None:
    """A device that declares that it never blocks returns at once from every call."""
    applies(subject.make().non_blocking, "it may wait: it is called in a thread of its own")
    shortest = min((_waiting(subject) for _ in range(TRIES)), key=lambda entry: entry[0])
    waited_s, what = shortest
    demand(waited_s <= WAITS_S, f"{what} waited for {waited_s:.2f} s, but it states `non_blocking`")


def _waiting(subject: DeviceSubject) -> tuple[float, str]:
    """Return the longest time for which a call did not compute, and that call."""
    with subject.connected() as device:
        calls: dict[str, Callable[[], object]] = {"making safe": device.make_safe}
        if isinstance(device, Readable):
            reading: Readable = device
            calls["reading"] = lambda: reading.read(names(device.channels))
        if isinstance(device, Settable) and device.drives:
            calls["setting"] = lambda: move(subject, device)
        if isinstance(device, Streaming):
            calls["streaming"] = lambda: streamed_blocks(device, 0.1)
        return max((measured(work).waited_s, what) for what, work in calls.items())


def _samples(subject: DeviceSubject, **changes: Any) -> dict[str, Array]:
    """Return a reading and a stream of a device that was just connected and set."""
    samples: dict[str, Array] = {}
    with subject.connected(**changes) as device:
        move(subject, device)
        if isinstance(device, Readable):
            values = device.read(names(device.channels))
            samples |= {f"reading of {name}": np.array([value]) for name, value in values.items()}
        if isinstance(device, Streaming):
            samples |= _streamed(device)
    applies(samples, "it can be neither read nor streamed")
    return samples


def _streamed(device: Device) -> dict[str, Array]:
    blocks = streamed_blocks(device, STREAMED_S)
    return {
        f"stream of {name}": np.concatenate([block.channels[name] for block in blocks])
        for name in (blocks[0].channels if blocks else ())
    }


CHECKS = (
    same_seed_same_samples,
    other_seed_other_samples,
    continues_after_streams,
    only_a_simulator_knows_the_truth,
    non_blocking_is_true,
)
