"""Blocks of several parts on the time base of one of them."""

from __future__ import annotations

from concurrent.futures import FIRST_COMPLETED, wait
from contextlib import ExitStack
from dataclasses import dataclass
from threading import Event
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import Block, DeviceLostError, DeviceTimeoutError
from rigrunner.api.cleanup import do_all, noted_on
from rigrunner.signal.interpolation import BEFORE, BEHIND, between
from rigrunner_plugins.devices.composite.clocks.feed import Feed
from rigrunner_plugins.devices.composite.clocks.tracking import Tracker

if TYPE_CHECKING:
    from collections.abc import Generator, Mapping, Sequence

    from rigrunner.api import Array, Clock, StopToken
    from rigrunner_plugins.devices.composite.clocks.relation import Relation
    from rigrunner_plugins.devices.composite.part import Part
    from rigrunner_plugins.devices.composite.routes import ChannelRoute
    from rigrunner_plugins.devices.composite.settings import ClockSettings

BLOCK_S = 0.1
"""A stop is looked at between blocks."""
MARGIN_S = 5.0
"""How much longer the parts stream than is needed: they do not begin at once."""


@dataclass(frozen=True, eq=False)
class StreamPlan:
    """What is to be recorded, of which parts, and by which rules."""

    routes: Sequence[ChannelRoute]
    parts: Mapping[str, Part]
    settings: ClockSettings
    reference: str
    answer_s: float


class AlignedStream:
    """One recording of channels that several clocks sample."""

    def __init__(self, plan: StreamPlan, duration_s: float, stop: StopToken, clock: Clock) -> None:
        self._plan = plan
        self._duration_s = duration_s
        self._stop = stop
        # Set once all samples are there, or the run was seen to stop. The run's own token is looked
        # at in one place alone, so that a replay looks at it as often.
        self._parts_stop = Event()
        self._clock = clock
        self._feeds: dict[str, Feed] = {}
        self._trackers: dict[str, Tracker] = {}

    def blocks(self) -> Generator[Block]:
        """Yield gapless blocks at the reference's rate; begin once the clocks are compared."""
        with ExitStack() as stack:
            try:
                self._start(stack)
                yield from self._aligned()
            except BaseException as error:
                with noted_on(error, "ending the parts' streams"):
                    self._end()
                raise
            self._end()

    def _end(self) -> None:
        self._parts_stop.set()
        do_all(*(feed.end for feed in self._feeds.values()))

    def conditions(self) -> dict[str, tuple[float, str]]:
        """Return how each channel that is not the reference's was aligned, with the units."""
        conditions: dict[str, tuple[float, str]] = {}
        for route in self._plan.routes:
            if route.part in self._trackers:
                tracker = self._trackers[route.part]
                relation, name = tracker.relation(), route.info.name
                conditions[f"{name}_clock_offset"] = (relation.offset_s, "s")
                conditions[f"{name}_clock_rate"] = (relation.rate, "1")
                conditions[f"{name}_alignment_u"] = (tracker.residual_u_s(), "s")
        return conditions

    def _start(self, stack: ExitStack) -> None:
        settings = self._plan.settings
        longest_s = self._duration_s + settings.lead + MARGIN_S
        names = dict.fromkeys([self._plan.reference, *(route.part for route in self._plan.routes)])
        for name in names:
            channels = [route.name for route in self._plan.routes if route.part == name]
            channels += [settings.common[name]] if name in settings.common else []
            part = self._plan.parts[name]
            if not channels:  # the reference, of which only the time base is wanted
                channels = [next(info.name for info in part.device.channels if info.streams)]
            stack.enter_context(part.streaming())
            chosen = list(dict.fromkeys(channels))
            self._feeds[name] = Feed(part, chosen, longest_s, self._parts_stop, self._clock)
        self._reference = self._feeds[self._plan.reference]
        common = settings.common
        for name, feed in self._feeds.items():
            if feed is not self._reference:
                has_common = name in common and self._plan.reference in common
                pair = (common[self._plan.reference], common[name]) if has_common else None
                self._trackers[name] = Tracker(self._reference, feed, pair, settings.latency)

    def _aligned(self) -> Generator[Block]:
        total = round(self._duration_s * self._reference.rate_hz)
        block_size = max(1, int(BLOCK_S * self._reference.rate_hz))
        begin: int | None = None
        yielded = 0
        while yielded < total:
            if self._stop.is_set():
                return
            self._receive()
            if begin is None and min(feed.received_s for feed in self._feeds.values()) == 0:
                continue
            relations = {name: tracker.relation() for name, tracker in self._trackers.items()}
            begin = self._begin(relations) if begin is None else begin
            if begin is None:
                continue
            end = min(self._ready(relations), begin + total)
            while size := min(block_size, total - yielded):
                if begin + yielded + size > end:
                    break
                yield self._block(begin + yielded, size, yielded, relations)
                yielded += size

    def _receive(self) -> None:
        """Wait for the next block of any part."""
        feeds = list(self._feeds.values())
        slowest = min(feeds, key=lambda feed: feed.received_s)
        for feed in feeds:
            # Inline, asking is waiting: the others would wait with it, so the one that is behind
            # goes first.
            if feed is slowest or not feed.part.is_inline:
                feed.ask()
        limit_s = self._plan.answer_s
        pending = [feed.pending for feed in feeds if feed.pending is not None]
        wait(pending, max(limit_s - max(feed.waiting_s for feed in feeds), 0.0), FIRST_COMPLETED)
        for feed in feeds:
            if feed.waiting_s >= limit_s:
                raise DeviceTimeoutError(f"{feed.part.name}: no block came within {limit_s:g} s")
            feed.take()
        ended = [feed.part.name for feed in feeds if feed.is_over]
        if ended:
            raise DeviceLostError(f"the stream of {', '.join(ended)} ended before its time")

    def _begin(self, relations: Mapping[str, Relation]) -> int | None:
        """Return the first sample of the recording, once all parts have it and the lead is over."""
        rate = self._reference.rate_hz
        began_s = 0.0
        for name, relation in relations.items():
            need_s = (BEFORE + 1) / self._feeds[name].rate_hz
            began_s = max(began_s, need_s - relation.offset_s)
        first = int(np.ceil((began_s + self._plan.settings.lead) * rate))
        return first if self._ready(relations) > first else None

    def _ready(self, relations: Mapping[str, Relation]) -> int:
        """Return up to which sample of the reference all parts have theirs."""
        rate = self._reference.rate_hz
        ready = self._reference.samples
        for name, relation in relations.items():
            feed = self._feeds[name]
            last_s = (feed.samples - BEHIND - 1) / feed.rate_hz
            delta_s = float(relation.delta_s(np.array([last_s - relation.offset_s]))[0])
            ready = min(ready, int(np.floor((last_s - delta_s) * rate)))
        return ready

    def _block(self, first: int, size: int, start: int, relations: Mapping[str, Relation]) -> Block:
        reference = self._reference
        tau_s = (first + np.arange(size)) / reference.rate_hz
        places: dict[str, Array] = {}
        for name, relation in relations.items():
            delta_s = relation.delta_s(tau_s)
            self._trackers[name].note_used(tau_s, delta_s)
            places[name] = (tau_s + delta_s) * self._feeds[name].rate_hz
        channels = {}
        for route in self._plan.routes:
            feed = self._feeds[route.part]
            if route.part in places:
                at = places[route.part]
                begin, end = int(np.floor(at[0])) - BEFORE, int(np.floor(at[-1])) + BEHIND + 1
                values = between(feed.channel(route.name, begin, end), at - begin)
            else:
                values = feed.channel(route.name, first, first + size)
            channels[route.info.name] = values
        return Block(reference.rate_hz, start, reference.arrived_s(first), channels)
