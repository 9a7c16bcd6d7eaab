"""Gives the blocks of a run to what its analyses show live, and what they find to a screen."""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import replace
from math import isfinite
from time import monotonic
from typing import TYPE_CHECKING, Protocol

import numpy as np

from rigrunner.api.data import Recording
from rigrunner.api.events import Samples, StepEnded, StepStarted
from rigrunner.api.findings import Findings
from rigrunner.run.listening import Detached

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rigrunner.api.data import Array, Block
    from rigrunner.api.events import Event, EventSink
    from rigrunner.api.findings import LiveAnalysis
    from rigrunner.api.instruments import Instrument
    from rigrunner.run.prepare import Planned

EVERY_S = 0.25
"""How often a screen is told, of a recording that goes on."""


class Shows(Protocol):
    """A screen."""

    def __call__(self, found: Findings, *, is_whole: bool) -> None:
        """Take what is known by now; `is_whole`: a recording is finished."""
        ...


@contextmanager
def following(planned: Planned, show: Shows) -> Iterator[list[EventSink]]:
    """Give the listener that a run needs for its live analyses; none where there are none.

    It has a thread of its own: a slow one holds no run up. Raises PluginError.
    """
    folds = {
        each.name: live
        for each in planned.procedure.model.named_analyses
        if (live := planned.registry.live(each.name, each.settings)) is not None
    }
    if not folds:
        yield []
        return
    instruments: dict[str, Instrument] = {
        each.channel: each for each in planned.station.model.instruments
    }
    listener = Detached("live analyses", Following(list(folds.items()), instruments, show))
    try:
        yield [listener]
    finally:
        listener.close()


class Following:
    """An event sink. An analysis whose live part raises is left out from then on, with a note."""

    def __init__(
        self,
        folds: list[tuple[str, LiveAnalysis]],
        instruments: Mapping[str, Instrument],
        show: Shows,
    ) -> None:
        self._folds = folds
        self._instruments = instruments
        self._show = show
        self._started: StepStarted | None = None
        self._zeros: dict[str, float] = {}
        self._recording = ""
        self._notes: list[str] = []
        self._due_s = 0.0

    def __call__(self, event: Event) -> None:
        """Take an event of the run."""
        match event:
            case StepStarted() if event.recording:
                self._started, self._recording = event, ""
            case StepEnded(action="zero", ok=True):
                self._zeros |= event.values
            case Samples() if self._started is not None:
                self._take(event, self._started)
                if monotonic() >= self._due_s:
                    self._due_s = monotonic() + EVERY_S
                    self._tell(is_whole=False)
            case StepEnded() if event.recording and event.recording == self._recording:
                self._tell(is_whole=True)

    def _take(self, event: Samples, started: StepStarted) -> None:
        block = replace(event.block, channels=dict(self._readings(event.block)))
        begins = self._recording != event.recording
        self._recording = event.recording
        recording = Recording(
            name=event.recording,
            rate_hz=block.rate_hz,
            started_utc=started.utc,
            setpoints=started.setpoints,
            channels=dict.fromkeys(block.channels, np.empty(0)),
            units=started.units,
            coordinates=started.coordinates,
        )
        for name, fold in list(self._folds):
            try:
                if begins:
                    fold.begin(recording)
                fold.take(block)
            except Exception as error:  # noqa: BLE001  (a stranger's may raise anything)
                self._leave_out(name, fold, error)

    def _readings(self, block: Block) -> Iterator[tuple[str, Array]]:
        """Yield the channels of a block as an analysis has them: less zero, and corrected."""
        for name, values in block.channels.items():
            known, zero = self._instruments.get(name), self._zeros.get(name, 0.0)
            samples = np.asarray(values, float)
            yield name, samples - zero if known is None else known.corrected(samples, zero)

    def _tell(self, *, is_whole: bool) -> None:
        found: list[Findings] = []
        for name, fold in list(self._folds):
            try:
                found.append(fold.findings())
            except Exception as error:  # noqa: BLE001  (a stranger's may raise anything)
                self._leave_out(name, fold, error)
        together = Findings(
            results=tuple(
                one for each in found for one in each.results if isfinite(one.estimate.value)
            ),
            figures=tuple(one for each in found for one in each.figures),
            notes=(*(one for each in found for one in each.notes), *self._notes),
        )
        self._show(together, is_whole=is_whole)

    def _leave_out(self, name: str, fold: LiveAnalysis, error: Exception) -> None:
        self._folds = [each for each in self._folds if each[1] is not fold]
        self._notes.append(f"{name} is shown no more: {type(error).__name__}: {error}")
