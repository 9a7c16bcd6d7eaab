"""How far a run is in its plan."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from rigrunner_panel.view.sections import Progress

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner_panel.view.sections import PlanView, StepView

TO_COME, RUNNING, DONE, FAILED, SKIPPED = ".", "r", "o", "x", "s"
_ROUND = 1


class Track:
    """The state of each step, and the time that is left by the plan's estimates."""

    def __init__(self, plan: PlanView) -> None:
        self._steps = plan.steps
        self._estimated_s = plan.estimated_s
        self._states = [TO_COME] * len(plan.steps)
        self._index = -1
        self._began_s = 0.0
        self._recording = ""
        self._recorded_s = 0.0
        self._scanned = 0

    def begin(self, index: int, recording: str) -> None:
        """Take note that a step begins, perhaps again."""
        if index < len(self._states):
            self._states[index] = RUNNING
        self._index, self._began_s = index, time.monotonic()
        self._recording, self._recorded_s, self._scanned = recording, 0.0, 0

    def end(self, index: int, *, ok: bool) -> None:
        """Take note that a step is over."""
        if index < len(self._states):
            self._states[index] = DONE if ok else FAILED

    def sets(self, index: int) -> Mapping[str, float]:
        """Return the set-points at which a step leaves its drives, in SI units."""
        return self._steps[index].sets if index < len(self._steps) else {}

    def leave_out(self, steps: range) -> None:
        """Take note that a condition leaves these steps out."""
        for index in steps:
            self._states[index] = SKIPPED

    def break_off(self) -> None:
        """Take note that a pause broke off the step that the run is at: it comes again."""
        if self._is(self._index, FAILED):
            self._states[self._index] = TO_COME

    def stop(self) -> None:
        """Take note that the run is over: a step that never ended has failed."""
        if self._is(self._index, RUNNING):
            self._states[self._index] = FAILED

    def set_recorded(self, seconds: float) -> None:
        """Set how many seconds of the recording are there."""
        self._recorded_s = seconds

    def set_scanned(self, points: int) -> None:
        """Set how many points of the scan were read."""
        self._scanned = points

    def skip(self) -> None:
        """Leave out what is to come of the set-point that the run is at."""
        index = self._index + 1 if self._is(self._index, DONE) else self._index
        if not 0 <= index < len(self._steps):
            return
        point = self._steps[index].point
        while index < len(self._steps) and self._steps[index].point == point:
            if not self._is(index, DONE):
                self._states[index] = SKIPPED
            index += 1
            # Without a set-point the step alone is left out.
            if not point:
                return

    def view(self, now_s: float | None) -> Progress:
        """Return how far it is; `now_s` lets the running step take its time between events."""
        step = self._steps[self._index] if 0 <= self._index < len(self._steps) else None
        running = step is not None and self._is(self._index, RUNNING)
        done_s = sum(
            planned.estimated_s
            for planned, state in zip(self._steps, self._states, strict=True)
            if state in (DONE, SKIPPED, FAILED)
        )
        if step is not None and running:
            done_s += min(self._part_s(step, now_s), step.estimated_s)
        return Progress(
            index=self._index,
            states="".join(self._states),
            done_s=round(done_s, _ROUND),
            estimated_s=round(self._estimated_s, _ROUND),
            left_s=round(max(self._estimated_s - done_s, 0.0), _ROUND),
            recording=self._recording if running else "",
            recording_s=step.estimated_s if step is not None and self._recording else 0.0,
            recording_done_s=round(self._recorded_s, _ROUND) if running else 0.0,
            scanned=self._scanned if running else 0,
            scan_points=step.scan_points if step is not None and running else 0,
        )

    def _part_s(self, step: StepView, now_s: float | None) -> float:
        """Return how much of the time of the running step is over."""
        if step.scan_points:
            return step.estimated_s * self._scanned / step.scan_points
        if now_s is not None and not self._recording:
            return now_s - self._began_s
        return self._recorded_s

    def _is(self, index: int, state: str) -> bool:
        return 0 <= index < len(self._states) and self._states[index] == state
