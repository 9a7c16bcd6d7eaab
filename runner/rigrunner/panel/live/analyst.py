"""The process that analyses what was recorded so far: neither run nor screen waits for it."""

from __future__ import annotations

import os
import signal
import sys
import time
from contextlib import suppress
from typing import TYPE_CHECKING

from rigrunner.api.errors import RigrunnerError
from rigrunner.panel.live.asked import Analysed
from rigrunner.panel.live.so_far import result_so_far
from rigrunner.panel.process.channel import Channel, ChannelClosedError
from rigrunner.panel.view.of_result import correction, live_view
from rigrunner.panel.view.sections import LiveView
from rigrunner.registry import load_registry
from rigrunner.runfile import read
from rigrunner.station import load_station
from rigrunner.workflow.lab_plugins import with_lab_plugins

if TYPE_CHECKING:
    from pathlib import Path

    from rigrunner.panel.live.asked import Analyse
    from rigrunner.registry import Registry
    from rigrunner.runfile import StoredRun


MOST_BYTES = 500_000_000
"""Of recordings: more would be read again and again, and take much memory for a screen."""
TOO_MUCH = "so much is recorded that it is analysed at the end alone"


class _Analyst:
    """Keeps what does not change while a run goes on."""

    def __init__(self) -> None:
        self._registries: dict[Path, Registry] = {}
        self._no_loads: dict[Path, StoredRun] = {}

    def answer(self, asked: Analyse) -> Analysed:
        """Return the result so far; what keeps it from being made stands in its problem."""
        began_s = time.monotonic()
        if _bytes(asked.folder) > MOST_BYTES:
            return Analysed(_problem(TOO_MUCH, began_s))
        try:
            registry, no_load = self._registry(asked.station), self._no_load(asked.no_load)
            result = result_so_far(asked.folder, registry, no_load, asked.recording, asked.watched)
        except RigrunnerError as error:
            return Analysed(_problem(str(error), began_s))
        except Exception as error:  # noqa: BLE001  (of a plugin: the run itself will say so)
            return Analysed(_problem(f"{type(error).__name__}: {error}", began_s))
        if result is None:
            return Analysed(None)
        found = correction(result)
        view = live_view(result, final=False, taken_s=time.monotonic() - began_s)
        return Analysed(view) if found is None else Analysed(view, *found)

    def _registry(self, station: Path) -> Registry:
        if station not in self._registries:
            loaded = load_station(station)
            self._registries = {station: with_lab_plugins(load_registry(), loaded, station.parent)}
        return self._registries[station]

    def _no_load(self, path: Path | None) -> StoredRun | None:
        if path is None:
            return None
        if path not in self._no_loads:
            self._no_loads = {path: read(path)}
        return self._no_loads[path]


def _bytes(folder: Path) -> int:
    """Return how much was recorded; what vanishes meanwhile does not count."""
    sizes = 0
    for each in folder.glob("*/*"):
        with suppress(OSError):
            sizes += each.stat().st_size
    return sizes


def _problem(text: str, began_s: float) -> LiveView:
    return LiveView(
        recordings=0,
        final=False,
        method="",
        problem=text,
        taken_s=time.monotonic() - began_s,
    )


def main() -> None:
    """Answer what comes on stdin until it ends."""
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
