"""Turns the events of a run into the state that screens show."""

from __future__ import annotations

import time
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Protocol

from msgspec import structs

from rigrunner.api.events import (
    Event,
    Intervention,
    MadeSafe,
    RunEnded,
    RunStarted,
    Samples,
    Scanned,
    StepEnded,
    StepStarted,
)
from rigrunner.api.findings import Findings
from rigrunner.clock import utc_text
from rigrunner_panel.live.curves import Curves
from rigrunner_panel.process.messages import (
    Analysed,
    Drawn,
    Ended,
    Failed,
    LiveFindings,
    Show,
    Values,
)
from rigrunner_panel.view.alarms import alarms_after, with_rigs
from rigrunner_panel.view.reading import (
    readings_after,
    readings_at,
    readings_now,
    readings_safe,
    readings_set,
)
from rigrunner_panel.view.result import with_live
from rigrunner_panel.view.sections import Finished, JobView, Preflight, PreflightItem, Progress
from rigrunner_panel.view.track import Track

if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Any

    from rigrunner_panel.view.board import Board
    from rigrunner_panel.view.sections import AlarmView, ChannelView, FileLink, LiveView, Phase


UNKEPT = "-"
"""The name of a recording of which only the statistics are stored."""
AFTER_LOSS = "check the rig first; then resume the run, or close it as it is"
AFTER_EARLY_LOSS = (
    "no run had begun, so there is nothing to resume: check the rig, then start again"
)


CHANNELS_S = 0.1
"""Interval in s at which the latest samples appear among the channels during a recording."""


class Links(Protocol):
    """Returns the addresses of files for screens."""

    def picture(self, path: str) -> str:
        """Return the address of a procedure's picture."""
        ...

    def run_links(self, run: str) -> tuple[FileLink, ...]:
        """Return the files of a run with their addresses."""
        ...


class Story:
    """The state of one job, from start to end, written to the board. Not thread-safe."""

    def __init__(
        self, board: Board, job: JobView, links: Links, left_energised: tuple[AlarmView, ...] = ()
    ) -> None:
        self.curves = Curves()
        self.is_over = False
        self.latest = -1
        """The number of the latest event."""
        self.follows_record = False
        """Whether the process died in a run: later events are only on the disk."""
        self._step: StepStarted | None = None
        self._board = board
        self._links = links
        self._track: Track | None = None
        self._started_s = 0.0
        self._analysed: LiveView | None = None
        self._findings = Findings()
        self._watched: LiveView | None = None
        """The analysis of data that are watched in a manual session and not stored."""
        self._has_begun = self._has_ended = False
        self._channels_due_s = 0.0
        cleared = dict.fromkeys(("plan", "progress", "prompt", "pause", "live", "analysing"))
        cleared |= dict.fromkeys(("finished", "manual"))
        board.forget_events()
        # what an earlier job found of the rig may no longer be so
        board.put(channels=(), readings={}, **cleared)
        board.put(job=job, asked="", alarms=left_energised)
        if job.kind == "preflight":
            self._preflight(())
        self._show_phase()

    @property
    def job(self) -> JobView:
        """The job as it is on the board."""
        job: JobView = self._board.get("job")
        return job

    def request(self, what: str) -> None:
        """Store who requested what."""
        self._board.put(asked=what)
        self._show_phase()

    def take(self, message: object) -> None:
        """Handle a message of the job's process."""
        if isinstance(message, Event):
            self.latest = message.seq
        match message:
            case Samples():
                self._take_samples(message)
            case Event():
                self._take_event(message)
            case Show(sections=sections):
                self._show(dict(sections))
            case Values(values=values, time_s=time_s, interval_s=interval_s):
                utc = utc_text(datetime.fromtimestamp(time_s, UTC))
                self._show_channels(values, utc, interval_s)
            case Analysed() | LiveFindings() | Drawn():
                self._take_findings(message)
            case Ended(finished=finished, live=live):
                self._end(finished)
                if live is not None:
                    self._board.put(live=live)
            case Failed():
                self._fail(message)
        self._show_phase()

    def _show(self, sections: dict[str, Any]) -> None:
        """Show sections that the process sent, and update what depends on them."""
        for name, view in sections.items():
            match name:
                case "manual" if view is not None:
                    sets = {drive.name: drive.set for drive in view.drives if drive.set is not None}
                    self._board.put(readings=readings_set(self._board.get("readings"), sets))
                case "plan":
                    self._track = Track(view)
                case "prompt" if view is not None and view.picture:
                    address = self._links.picture(view.picture)
                    sections["prompt"] = view.model_copy(update={"picture": address})
                case "pause":
                    self._board.put(asked="")
                    if view is not None and self._track is not None:
                        self._track.break_off()
        self._board.put(**sections, progress=self._progress())

    def tick(self) -> None:
        """Update the elapsed time on the screen when the rig sends nothing."""
        if self._track is not None and self.job.realtime and not self._has_ended:
            self._board.put(progress=self._progress())

    def show_left_energised(self, rigs: tuple[AlarmView, ...]) -> None:
        """Show which rigs of this computer were left energised."""
        self._board.put(alarms=with_rigs(self._board.get("alarms"), rigs))

    def _take_findings(self, message: Analysed | LiveFindings | Drawn) -> None:
        """Show what the analyst found, unless the run's own result is already there."""
        match message:
            case Drawn(recording=recording, curve=curve, ended_s=ended_s):
                late_s = time.monotonic() - ended_s if self.job.realtime else 0.0
                self.curves.draw(recording or UNKEPT, curve, ended_s, late_s)
            case _ if self.is_over:
                return
            case LiveFindings(findings=findings):
                self._findings = findings
                self._show_live()
            case Analysed(view=view, is_watched=is_watched) if view is not None:
                if is_watched:
                    self._watched = view
                else:
                    self._analysed = view
                self._show_live()

    def _show_live(self) -> None:
        """Show what the analysis has of finished recordings, and the live analyses of the rest."""
        view = with_live(self._analysed, self._findings)
        if (watched := self._watched) is not None:
            ongoing = [result.model_copy(update={"is_ongoing": True}) for result in watched.results]
            results, problem = (*view.results, *ongoing), watched.problem or view.problem
            view = view.model_copy(update={"results": results, "problem": problem})
        self._board.put(live=view)

    def lost(self, code: int | None) -> None:
        """Handle a process that ended without its final message."""
        if not self.is_over:
            how = f"with code {code}" if code is not None else "without a word"
            self.follows_record = bool(self.job.run)
            hint = AFTER_LOSS if self.job.run else AFTER_EARLY_LOSS  # nothing else is resumed
            self.take(Failed(f"the process of the run ended {how}", hint))

    def _take_samples(self, event: Samples) -> None:
        event = event if event.recording else structs.replace(event, recording=UNKEPT)
        block = event.block
        start_s = event.monotonic_s - self._started_s - block.samples / block.rate_hz
        units = {channel.name: channel.unit for channel in self._board.get("channels")}
        self.curves.take(event, max(start_s, 0.0), units)
        now_s = time.monotonic()
        if now_s >= self._channels_due_s and block.samples:
            self._channels_due_s = now_s + 0.9 * CHANNELS_S  # blocks may come as often as that
            latest = {name: float(samples[-1]) for name, samples in block.channels.items()}
            self._show_channels(latest, self._time_of(event), CHANNELS_S)
        if self._track is not None:
            self._track.set_recorded((block.first_sample + block.samples) / block.rate_hz)
            self._board.put(progress=self._progress())

    def _show_channels(
        self, values: Mapping[str, float], utc: str, interval_s: float | None = None
    ) -> None:
        """Show values of channels, and how often they are read if that is known."""
        channels: tuple[ChannelView, ...] = self._board.get("channels")
        now = tuple(
            view.read(values[view.name], utc, interval_s) if view.name in values else view
            for view in channels
        )
        self._board.put(channels=now)
        if interval_s is not None:  # values of an event are among the readings already
            self._board.put(readings=readings_now(self._board.get("readings"), values, utc))

    def _time_of(self, event: Event) -> str:
        """Return the time of an event; in simulated time, the elapsed time on the screen."""
        return event.utc if self.job.realtime else utc_text(datetime.now(UTC))

    def _take_event(self, event: Event) -> None:
        match event:
            case RunStarted():
                self._has_begun, self._started_s = True, event.monotonic_s
                update = {"run": event.run_id, "started_utc": event.utc}
                self._board.put(job=self.job.model_copy(update=update))
            case RunEnded():
                self._has_ended = True
                self._board.put(prompt=None, pause=None)
            case StepStarted():
                self._begin(event)
            case Scanned():
                self._scan(event)
                return
            case StepEnded():
                self._finish(event)
            case MadeSafe():
                self._board.put(readings=readings_safe(self._board.get("readings"), event))
                self._show_channels(event.read_back, self._time_of(event))
            case Intervention(action="skip") if self._track is not None:
                self._track.skip()
            case Intervention(action="abort") if not self._board.get("asked"):
                self._board.put(asked="abort")
        self._board.add_event(event)
        alarms = alarms_after(self._board.get("alarms"), event)
        self._board.put(alarms=alarms, progress=self._progress())

    def _begin(self, event: StepStarted) -> None:
        self._step = event
        if self._watched is not None:
            self._watched = None
            self._show_live()
        recording = event.recording or (UNKEPT if event.action == "record" else "")
        if self._track is not None:
            self._track.begin(event.index, recording)

    def _scan(self, event: Scanned) -> None:
        if self._track is not None:
            self._track.set_scanned(event.point + 1)
        if self._step is not None:
            readings = readings_at(self._board.get("readings"), event, self._step)
            self._board.put(readings=readings, progress=self._progress())

    def _finish(self, event: StepEnded) -> None:
        if self._track is not None:
            self._track.end(event.index, ok=event.ok)
            self._track.leave_out(range(event.index + 1, event.index + 1 + event.leaves))
        readings = readings_after(self._board.get("readings"), event, self._step)
        sets = self._track.sets(event.index) if self._track is not None and event.ok else {}
        self._board.put(readings=readings_set(readings, sets))
        if event.action in ("set", "ramp", "measure"):  # others have means over a time
            self._show_channels(event.values, self._time_of(event))

    def _progress(self) -> Progress | None:
        if self._track is None:
            return None
        return self._track.view(time.monotonic() if self.job.realtime else None)

    def _preflight(self, items: tuple[PreflightItem, ...], *, done: bool = False) -> None:
        self._board.put(preflight=Preflight.of(self.job, items, done=done))

    def _end(self, finished: Finished | None) -> None:
        self.is_over = True
        if self._track is not None:
            self._track.stop()
        progress = self._progress()
        self._board.put(analysing=None, asked="", prompt=None, pause=None, progress=progress)
        if self.job.kind == "preflight":
            self._preflight(self._board.get("preflight").items, done=True)
        else:
            if finished is not None and finished.run:
                files = self._links.run_links(finished.run)
                finished = finished.model_copy(update={"files": files})
            self._board.put(finished=finished)

    def _fail(self, failed: Failed) -> None:
        """Show a job that did not start, or that an internal error ended."""
        problems = tuple(str(problem) for problem in failed.problems)
        if self.job.kind == "preflight":
            text = "; ".join(problems) or failed.message
            item = PreflightItem(
                kind="procedure", name="files", state="fail", text=text, fix=failed.hint
            )
            self._preflight((*self._board.get("preflight").items, item))
        finished = Finished(
            run=self.job.run,
            folder="",
            outcome="aborted" if failed.code == "aborted" else "error",
            reason=failed.message,
            verdict="",
            error=failed.trace or failed.message,
            hint=failed.hint,
            problems=problems,
        )
        self._end(finished)

    def _show_phase(self) -> None:
        self._board.put(phase=self._phase())

    def _phase(self) -> Phase:  # noqa: PLR0911  (the table of phases, gravest first)
        if self.is_over:
            return "idle" if self.job.kind == "preflight" else "finished"
        if self.job.kind == "preflight":
            return "checking"
        if self._has_ended:
            return "analysing"
        asked = self._board.get("asked")
        if asked in ("abort", "stop"):
            return "ending"
        if self._board.get("pause") is not None:
            return "paused"
        if self._board.get("prompt") is not None:
            return "asking"
        if asked in ("pause", "repeat", "skip"):
            return "pausing"
        if not self._has_begun:
            return "starting"
        return "manual" if self.job.kind == "manual" else "running"
