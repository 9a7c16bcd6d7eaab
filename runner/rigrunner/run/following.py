"""Passes the blocks of a run to the live views of its analyses, and their findings to a screen."""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import replace
from functools import cached_property
from math import isfinite
from threading import Thread
from time import monotonic
from typing import TYPE_CHECKING, Protocol, TypeVar

import numpy as np

from rigrunner.analysis.scrutiny import Scrutiny
from rigrunner.api.analysis_context import AnalysisContext
from rigrunner.api.data import Recording, RunData
from rigrunner.api.events import Samples, StepEnded, StepStarted
from rigrunner.api.findings import Findings, SnapshotAnalysis
from rigrunner.run.listening import Detached

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from rigrunner.api.events import Event, EventSink
    from rigrunner.api.figures import Curve
    from rigrunner.api.findings import LiveAnalysis
    from rigrunner.procedure import Procedure
    from rigrunner.registry import Registry
    from rigrunner.run.prepare import Planned

_T = TypeVar("_T")
EVERY_S = 0.25
"""Interval of updates of a screen during a recording."""
MOST_BUSY = 0.25
"""Most of the time to spend on findings during a recording."""


class Shows(Protocol):
    """A screen."""

    def __call__(self, findings: Findings, /, *, is_whole: bool) -> None:
        """Take the findings so far; `is_whole`: a recording has ended."""
        ...


class Draws(Protocol):
    """The part of a screen that shows curves."""

    def __call__(self, recording: str, curve: Curve, ended_s: float) -> None:
        """Take a curve of a recording that ended at `ended_s`, by the clock of the events."""
        ...


def folds_of(registry: Registry, procedure: Procedure) -> list[tuple[str, LiveAnalysis]]:
    """Return the live views of the analyses that have one, by name; raise PluginError."""
    measurand = procedure.measurand
    context = AnalysisContext(
        plugins=Scrutiny(registry),
        measurand="" if measurand is None else measurand.name,
        symbol="" if measurand is None else measurand.symbol,
        interim=True,
    )
    return [
        (analysis.name, live)
        for analysis in procedure.analysis
        if (live := registry.live(analysis.name, analysis.settings, context)) is not None
    ]


@contextmanager
def following(planned: Planned, show: Shows) -> Iterator[list[EventSink]]:
    """Yield the listener for the live analyses of a run; none if there are none.

    It has its own thread, so that it cannot delay the run, and no partner runs. Raises PluginError.
    """
    folds = folds_of(planned.registry, planned.procedure.model)
    if not folds:
        yield []
        return
    listener = Detached("live analyses", Following(folds, lambda: _run(planned), show))
    try:
        yield [listener]
    finally:
        listener.close()


def _run(planned: Planned) -> RunData:
    """Return what is known of the run before it has data."""
    procedure, station = planned.procedure.model, planned.station
    return RunData(
        run_id="",
        procedure_id=procedure.id,
        procedure_revision=procedure.revision,
        procedure_title=procedure.title,
        station_id=station.model.id,
        started_utc="",
        ended_utc="",
        outcome="",
        inputs={},
        instruments=station.register,
        zeros={},
        recordings=(),
        rig_keys=station.model.rig,
    )


class Following:
    """An event sink. An analysis whose live view raises is dropped, with a note."""

    def __init__(
        self,
        folds: list[tuple[str, LiveAnalysis]],
        run: Callable[[], RunData],
        show: Shows,
        draw: Draws | None = None,
    ) -> None:
        self._folds = folds
        self._read_run = run
        self._show = show
        self._draw = draw
        self._started: StepStarted | None = None
        self._zeros: dict[str, float] = {}
        self._recording: str | None = None
        self._notes: list[str] = []
        self._due_s = self._took_s = 0.0
        self._thread: Thread | None = None

    def __call__(self, event: Event) -> None:
        """Take an event of the run."""
        match event:
            case StepStarted():
                # A recording whose samples are not kept has no name, but has curves.
                is_recorded = event.recording or event.action == "record"
                self._started, self._recording = event if is_recorded else None, None
            case StepEnded(action="zero", ok=True):
                self._zeros |= event.values
            case Samples() if self._started is not None:
                self._take(event, self._started)
                if monotonic() >= self._due_s:
                    self._show_findings(is_whole=False)
            case StepEnded() if event.recording and event.recording == self._recording:
                # A screen with curves has finished recordings analysed separately: slow findings
                # are left to that analysis.
                if self._draw is None or self._took_s <= EVERY_S or monotonic() >= self._due_s:
                    self._show_findings(is_whole=True)

    @cached_property
    def _run(self) -> RunData:
        return self._read_run()

    def _take(self, event: Samples, started: StepStarted) -> None:
        # As analyses take them: minus zero, and corrected.
        run = replace(self._run, zeros=dict(self._zeros))  # a later zero is for later recordings
        channels = {
            name: run.readings(name, np.asarray(values, float), self._zeros.get(name, 0.0))
            for name, values in event.block.channels.items()
        }
        block = replace(event.block, channels=channels)
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
                    fold.begin(recording, run)
                curves = fold.take(block)
            except Exception as error:  # noqa: BLE001  (a plugin may raise anything)
                self._drop(name, fold, error)
                continue
            if self._draw is not None:
                end_s = (block.first_sample + block.samples) / block.rate_hz
                for curve in curves:  # the event is as late as the last sample of its block
                    self._draw(event.recording, curve, event.monotonic_s - (end_s - curve.end_s))

    def _show_findings(self, *, is_whole: bool) -> None:
        """Show the findings so far; curves are drawn while those of a snapshot are made."""
        if self._thread is not None and self._thread.is_alive():
            return
        began_s = monotonic()
        # Of each live view its findings, or the function that makes them.
        outputs = [
            (name, fold, self._try(name, fold, self._findings_or_snapshot(fold)))
            for name, fold in self._folds
        ]

        def end() -> None:
            findings = [
                self._try(name, fold, output) if callable(output) else output
                for name, fold, output in outputs
            ]
            self._show(self._merged(list(filter(None, findings))), is_whole=is_whole)
            self._took_s = monotonic() - began_s
            self._due_s = began_s + max(EVERY_S, self._took_s / MOST_BUSY)

        if any(callable(output) for _, _, output in outputs):
            self._thread = Thread(target=end, name="live findings", daemon=True)
            self._thread.start()
        else:
            end()

    def _findings_or_snapshot(
        self, fold: LiveAnalysis
    ) -> Callable[[], Findings | Callable[[], Findings]]:
        if self._draw is not None and isinstance(fold, SnapshotAnalysis):
            return fold.snapshot
        return fold.findings

    def _try(self, name: str, fold: LiveAnalysis, make: Callable[[], _T]) -> _T | None:
        try:
            return make()
        except Exception as error:  # noqa: BLE001  (a plugin may raise anything)
            self._drop(name, fold, error)
            return None

    def _merged(self, findings: Sequence[Findings]) -> Findings:
        return Findings(
            results=tuple(
                result for f in findings for result in f.results if isfinite(result.estimate.value)
            ),
            figures=tuple(figure for f in findings for figure in f.figures),
            notes=(*(note for f in findings for note in f.notes), *self._notes),
        )

    def _drop(self, name: str, fold: LiveAnalysis, error: Exception) -> None:
        self._folds = [(other, f) for other, f in self._folds if f is not fold]
        self._notes.append(f"{name} is shown no more: {type(error).__name__}: {error}")
