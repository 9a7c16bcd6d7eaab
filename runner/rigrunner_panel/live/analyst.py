"""The process that analyses recordings during a run, so that neither run nor screen waits."""

from __future__ import annotations

import os
import signal
import threading
import time
import traceback
from contextlib import suppress
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING

from rigrunner.api.errors import RigrunnerError
from rigrunner.api.events import Event, StepStarted
from rigrunner.bus import EventStamp
from rigrunner.clock import WallClock
from rigrunner.procedure import parse_procedure
from rigrunner.registry import load_registry
from rigrunner.run.following import Following, folds_of
from rigrunner.run.interrupted import used_partners
from rigrunner.run.lab_plugins import with_lab_plugins
from rigrunner.run.stored import run_data
from rigrunner.runfile import read, read_info, read_without_samples
from rigrunner.station import load_station
from rigrunner_panel.live.interim import interim_result
from rigrunner_panel.process.channel import Channel, ChannelClosedError
from rigrunner_panel.process.messages import (
    Analyse,
    Analysed,
    Drawn,
    Follow,
    LiveFindings,
    Watching,
)
from rigrunner_panel.view.result import live_view
from rigrunner_panel.view.sections import LiveView

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from rigrunner.api.data import Recording, RunData
    from rigrunner.api.figures import Curve
    from rigrunner.api.findings import Findings
    from rigrunner.procedure import Procedure
    from rigrunner.registry import Registry
    from rigrunner.runfile import StoredRun


MOST_BYTES = 250_000_000
"""Most bytes of samples to analyse; above it, repeated reading would be slow and use much memory.
"""
PACKED = 5
"""Typical compression ratio of a finished recording."""
TOO_MUCH = "the recordings are so large that they are analysed only at the end"


class Analyst:
    """Analyses one run, and shows the live views of its analyses; what it finds is sent.

    Finished recordings are analysed in a thread of their own, one request at a time: that takes a
    second or more, and live curves must not wait for it. `send` may be called by both threads.
    """

    def __init__(self, send: Callable[[object], None]) -> None:
        self._send = send
        self._folder: Path | None = None
        self._station: Path | None = None
        self._following: Following | None = None
        self._stamp = EventStamp(WallClock())
        self._load_lock = threading.RLock()
        """Held while something is loaded that both threads use."""

    def take(self, message: object) -> None:
        """Handle a message of the panel."""
        match message:
            case Follow(folder=folder, station=station):
                self._folder, self._station = folder, station
            case Analyse(watched=watched) if self._folder is not None:
                args = (self._folder, watched)
                threading.Thread(target=self._analyse, args=args, daemon=True).start()
            case Watching(setpoints=setpoints, units=units):
                step = {"step": "by_hand", "index": -1, "action": "record", "text": ""}
                self._follow(self._stamp(StepStarted, **step, setpoints=setpoints, units=units))
            case Event():
                self._follow(message)

    def _follow(self, event: Event) -> None:
        if self._folder is None:
            return
        if self._following is None:
            try:
                folds = folds_of(self._registry(), self._procedure)
            except RigrunnerError as error:
                self._send(Analysed(_problem(str(error), time.monotonic())))
                folds = []
            self._following = Following(folds, self._run, self._show, self._draw)
        try:
            self._following(event)
        except (RigrunnerError, OSError):  # the run was sealed meanwhile: its journal is gone
            self._folder = None

    def _show(self, found: Findings, *, is_whole: bool) -> None:  # noqa: ARG002  (a screen gets both)
        with suppress(ChannelClosedError):  # as below: findings may be made in a thread too
            self._send(LiveFindings(found))

    def _draw(self, recording: str, curve: Curve, ended_s: float) -> None:
        self._send(Drawn(recording, curve, ended_s))

    def _analyse(self, folder: Path, watched: Recording | None) -> None:
        with suppress(ChannelClosedError):  # the run is over
            self._send(self._analysis(folder, watched))

    def _analysis(self, folder: Path, watched: Recording | None) -> Analysed:
        """Return the result of the finished recordings; an error is stated in its `problem`."""
        began_s = time.monotonic()
        is_watched = watched is not None
        try:
            if not is_watched and _bytes(folder) > MOST_BYTES:
                return Analysed(_problem(TOO_MUCH, began_s))
            interim = interim_result(folder, self._registry(), self._partners(), watched)
        except RigrunnerError as error:
            return Analysed(_problem(str(error), began_s), is_watched)
        except Exception as error:  # noqa: BLE001  (of a plugin: the run itself will say so)
            return Analysed(_problem(f"{type(error).__name__}: {error}", began_s), is_watched)
        if interim is None:
            return Analysed(None)
        result, acceptance = interim
        taken_s = time.monotonic() - began_s
        view = live_view(result, final=False, taken_s=taken_s, acceptance=acceptance)
        return Analysed(view, is_watched)

    def _run(self) -> RunData:
        """Return what is known of the run before it has data."""
        stored = read_without_samples(self._run_folder)
        return replace(run_data(replace(stored, partners=self._partners())), recordings=())

    @property
    def _run_folder(self) -> Path:
        assert self._folder is not None  # noqa: S101  (nothing is analysed before)
        return self._folder

    def _registry(self) -> Registry:
        with self._load_lock:
            return self._loaded_registry

    def _partners(self) -> dict[str, StoredRun]:
        with self._load_lock:
            return self._loaded_partners

    @cached_property
    def _loaded_registry(self) -> Registry:
        assert self._station is not None  # noqa: S101  (likewise)
        loaded = load_station(self._station)
        return with_lab_plugins(load_registry(), loaded, self._station.parent)

    @cached_property
    def _procedure(self) -> Procedure:
        header = read_info(self._run_folder).header
        return parse_procedure(header.procedure_text, header.procedure_id, stored=True).model

    @cached_property
    def _loaded_partners(self) -> dict[str, StoredRun]:
        paths = used_partners(read_info(self._run_folder).header)
        return {name: read(path) for name, path in paths.items()}


def _bytes(folder: Path) -> int:
    """Return the approximate size of the recorded samples in bytes; missing files count 0."""
    raw = sum(map(_size, folder.glob("journal/*.samples")))
    return raw + PACKED * sum(map(_size, folder.glob("recordings/*.h5")))


def _size(path: Path) -> int:
    try:
        return path.stat().st_size
    except OSError:
        return 0


def _problem(text: str, began_s: float) -> LiveView:
    return LiveView(recordings=0, final=False, problem=text, taken_s=time.monotonic() - began_s)


def main() -> None:
    """Answer requests from stdin until it closes."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(os, "nice"):
        os.nice(10)  # run and screen go first
    channel = Channel.on_stdout()
    analyst = Analyst(channel.send)
    status = 0
    try:
        while True:
            analyst.take(channel.receive())
    except ChannelClosedError:
        pass
    except BaseException:  # noqa: BLE001  (shown, as at the end of any program)
        traceback.print_exc()
        status = 1
    # A thread that analyses may be in HDF5: the interpreter's end would wait for its lock.
    os._exit(status)


if __name__ == "__main__":
    main()
