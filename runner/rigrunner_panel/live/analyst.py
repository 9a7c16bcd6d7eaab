"""The process that analyses recordings during a run, so that neither run nor screen waits."""

from __future__ import annotations

import os
import signal
import sys
import time
from typing import TYPE_CHECKING

from rigrunner.api.errors import RigrunnerError
from rigrunner.registry import load_registry
from rigrunner.run.interrupted import used_partners
from rigrunner.run.lab_plugins import with_lab_plugins
from rigrunner.runfile import read, read_info
from rigrunner.station import load_station
from rigrunner_panel.live.interim import interim_result
from rigrunner_panel.live.latest import LatestCycles
from rigrunner_panel.process.channel import Channel, ChannelClosedError
from rigrunner_panel.process.messages import Analysed
from rigrunner_panel.view.of_result import correction, live_view, with_followed
from rigrunner_panel.view.sections import LiveView, PointView

if TYPE_CHECKING:
    from pathlib import Path

    from rigrunner.registry import Registry
    from rigrunner.runfile import StoredRun
    from rigrunner_panel.process.messages import Analyse


MOST_BYTES = 250_000_000
"""Most bytes of samples to analyse; above it, repeated reading would be slow and use much memory.
"""
MOST_AGAIN = 40_000_000
"""Most bytes of samples in a recording in progress; a longer one is followed, not read again."""
PACKED = 5
"""Typical compression ratio of a finished recording."""
TOO_MUCH = "so much is recorded that all of it is analysed at the end alone"


class _Analyst:
    """Caches data that do not change during a run, and the findings of its recordings."""

    def __init__(self) -> None:
        self._registries: dict[Path, Registry] = {}
        self._partners: dict[Path, StoredRun] = {}
        self._followed: tuple[Path, LatestCycles] | None = None
        self._found: LiveView | None = None
        self._latest: dict[str, PointView] = {}

    def answer(self, asked: Analyse) -> Analysed:
        """Return the result so far; an error is stated in its `problem`."""
        began_s = time.monotonic()
        try:
            too_much = _bytes(asked.folder) > MOST_BYTES
            if not asked.watched and (too_much or (asked.recording and _is_long(asked.folder))):
                latest = self._of_latest(asked, began_s)  # also what is left of one that is over
                if asked.recording:
                    return latest
            if too_much:
                problem = _problem(TOO_MUCH, began_s)
                return Analysed(with_followed(problem, self._found, self._latest))
            return self._of_all(asked, began_s)
        except RigrunnerError as error:
            return Analysed(_problem(str(error), began_s))
        except Exception as error:  # noqa: BLE001  (of a plugin: the run itself will say so)
            return Analysed(_problem(f"{type(error).__name__}: {error}", began_s))

    def _of_all(self, asked: Analyse, began_s: float) -> Analysed:
        registry, partners = self._registry(asked.station), self._partners_of(asked.folder)
        found = interim_result(asked.folder, registry, partners, asked.recording, asked.watched)
        if found is None:
            return Analysed(None)
        result, acceptance = found
        corrected = correction(result)
        taken_s = time.monotonic() - began_s
        view = live_view(result, final=False, taken_s=taken_s, acceptance=acceptance)
        if asked.watched is None:
            self._found, self._latest = view, {}
        return Analysed(view) if corrected is None else Analysed(view, *corrected)

    def _of_latest(self, asked: Analyse, began_s: float) -> Analysed:
        """Return the last result, with the recording in progress analysed by its latest cycles."""
        if self._followed is None or self._followed[0] != asked.folder:
            registry, partners = self._registry(asked.station), self._partners_of(asked.folder)
            self._followed = asked.folder, LatestCycles(asked.folder, registry, partners)
        result, cycles = self._followed[1].latest()
        if result is None:
            return Analysed(None)
        latest = live_view(result, final=False, taken_s=time.monotonic() - began_s)
        now = latest.points[-1].model_copy(update={"cycles": cycles})
        self._latest[now.recording] = now
        view = with_followed(latest, self._found, self._latest)
        found = correction(result)
        return Analysed(view) if found is None else Analysed(view, *found)

    def _registry(self, station: Path) -> Registry:
        if station not in self._registries:
            loaded = load_station(station)
            self._registries = {station: with_lab_plugins(load_registry(), loaded, station.parent)}
        return self._registries[station]

    def _partners_of(self, folder: Path) -> dict[str, StoredRun]:
        used = used_partners(read_info(folder).header)
        self._partners = {p: self._partners.get(p) or read(p) for p in used.values()}
        return {name: self._partners[path] for name, path in used.items()}


def _bytes(folder: Path) -> int:
    """Return the approximate size of the recorded samples in bytes; missing files count 0."""
    raw = sum(map(_size, folder.glob("journal/*.samples")))
    return raw + PACKED * sum(map(_size, folder.glob("recordings/*.h5")))


def _is_long(folder: Path) -> bool:
    """Return whether the latest recording is too long to read again for each swing."""
    latest = max(folder.glob("journal/*.samples"), default=None)
    return latest is not None and _size(latest) > MOST_AGAIN


def _size(path: Path) -> int:
    try:
        return path.stat().st_size
    except OSError:
        return 0


def _problem(text: str, began_s: float) -> LiveView:
    return LiveView(
        recordings=0,
        final=False,
        method="",
        problem=text,
        taken_s=time.monotonic() - began_s,
    )


def main() -> None:
    """Answer requests from stdin until it closes."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(os, "nice"):
        os.nice(10)  # run and screen go first
    outgoing = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    channel, analyst = Channel(sys.stdin.buffer, outgoing), _Analyst()
    try:
        while True:
            channel.send(analyst.answer(channel.receive()))
    except ChannelClosedError:
        return


if __name__ == "__main__":
    main()
