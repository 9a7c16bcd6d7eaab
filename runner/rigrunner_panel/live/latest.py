"""Analyses the recording in progress by its latest whole cycles, each cycle once.

A recording at a high rate is soon too long to be analysed again with every swing. The interim
result covers the latest cycles only; the value of the whole recording follows when it is finished.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from rigrunner.run.stored import run_data
from rigrunner.runfile import read, read_without_samples, tail_of
from rigrunner_panel.live.interim import live_analysis
from rigrunner_panel.view.of_result import prepared

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from rigrunner.api.analysis import OutlierRule
    from rigrunner.api.data import Block, Recording, RunData
    from rigrunner.api.results import Result
    from rigrunner.api.settings import Settings
    from rigrunner.registry import Registry
    from rigrunner.runfile import StoredRun, Tail
    from rigrunner_panel.live.interim import LiveAnalysis

BEGINNING = 10_000
"""Number of samples of each finished recording that are included with each window."""
MOST_BEHIND = 400_000_000
"""Most bytes of samples that wait for a slow analysis; older ones are dropped."""


class LatestCycles:
    """Follows the recordings of one run; only the latest is analysed."""

    def __init__(self, folder: Path, registry: Registry, partners: Mapping[str, StoredRun]) -> None:
        self._folder = folder
        self._registry = registry
        self._prepared = _Prepared()
        over = self._prepared.over
        self._partners = {name: over(run_data(each)) for name, each in partners.items()}
        self._tail: Tail | None = None
        self._recording: _Recording | None = None

    def latest(self) -> tuple[Result | None, int]:
        """Return the result of the latest window, and the number of cycles seen in its recording.

        None before the first window. Raises DataError if it cannot be analysed.
        """
        tail = tail_of(self._folder)
        if tail is None:
            return None, 0
        if self._tail is None or self._tail.path != tail.path:
            self._tail, self._recording = tail, None
        for block in self._tail.blocks(MOST_BEHIND):
            if self._recording is None:
                self._recording = self._begun(self._tail, block)
            self._recording.take(block)
        found = self._recording
        return (found.result, found.cycles) if found else (None, 0)

    def _begun(self, tail: Tail, first: Block) -> _Recording:
        stored = read_without_samples(self._folder)
        analysis = live_analysis(stored, self._registry)
        run = replace(run_data(stored), partners=self._partners)
        if analysis is None or not analysis.analyses:
            return _Recording(None, run, None)
        (ref,) = analysis.analyses
        torque = self._registry.make(ref.kind, ref.name, ref.settings)
        if torque.uses_earlier:
            before = torque.earlier(run_data(read(self._folder)))
            self._prepared = _Prepared()  # there are more of them now
            run = self._prepared.over(replace(run, recordings=before))
        self._prepared.prepare = torque.prepare
        lookup = _WithPrepared(self._registry, self._prepared)
        analysis = replace(analysis, lookup=lookup, others=())
        return _Recording(torque.windows(tail.begun(first, stored.events), run), run, analysis)


class _Recording:
    """The findings of one recording so far."""

    def __init__(
        self,
        windows: Any,
        run: RunData,
        analysis: LiveAnalysis | None,
    ) -> None:
        self._windows = windows
        self._run = run
        self._analysis = analysis
        self.result: Result | None = None
        self.cycles = 0

    def take(self, block: Block) -> None:
        """Add the next block; raise DataError."""
        if self._analysis is None:
            return
        for window in self._windows.take(block):
            run = replace(self._run, recordings=(*self._run.recordings, window))
            self.result = self._analysis.result(run)
            self.cycles += prepared(self.result).loaded[-1].cycles


class _Prepared:
    """Prepares finished recordings once, and each window of the current one anew."""

    def __init__(self) -> None:
        self._whole: dict[Recording, Recording] = {}
        self._known: dict[Recording, Any] = {}
        self.prepare: Any = None
        """How the analysis does it."""

    def over(self, run: RunData) -> RunData:
        """Return a run with only the beginnings of its recordings.

        Otherwise, checks of every sample would read all recordings from disk for each window.
        """
        beginnings = tuple(_beginning(each) for each in run.recordings)
        self._whole |= dict(zip(beginnings, run.recordings, strict=True))
        return replace(run, recordings=beginnings)

    def __call__(
        self, recording: Recording, run: RunData, settings: Settings, rule: OutlierRule
    ) -> Any:
        """Return the prepared recording, the whole one if it is finished; raise DataError."""
        if recording not in self._whole:
            return self.prepare(recording, run, settings, rule)
        if recording not in self._known:
            self._known[recording] = self.prepare(self._whole[recording], run, settings, rule)
        return self._known[recording]


class _WithPrepared:
    """The registry, with the preparation of the torque analysis replaced."""

    def __init__(self, registry: Registry, prepare: _Prepared) -> None:
        self._registry = registry
        self._prepare = prepare

    def __getattr__(self, name: str) -> Any:
        return getattr(self._registry, name)

    def make(
        self, kind: str, name: str, settings: Mapping[str, Any], context: Any = None, **fits: Any
    ) -> Any:
        """Return what the registry makes; raise PluginError."""
        made = self._registry.make(kind, name, settings, context, **fits)
        return replace(made, prepare=self._prepare) if hasattr(made, "prepare") else made


def _beginning(recording: Recording) -> Recording:
    channels = {name: np.asarray(each[:BEGINNING]) for name, each in recording.channels.items()}
    return replace(recording, channels=channels)
