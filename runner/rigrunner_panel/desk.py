"""Starts and controls jobs on the rig: one at a time, each in its own process."""

from __future__ import annotations

import logging
import threading
import time
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING

from rigrunner.api.errors import RigrunnerError
from rigrunner.api.events import Samples
from rigrunner.engine import Choice, Decision
from rigrunner.procedure.answers import AnswerError
from rigrunner.runfile import read
from rigrunner.runfile.folder import RunFolder
from rigrunner_panel.errors import PanelError, wrong_state
from rigrunner_panel.live.story import Story
from rigrunner_panel.live.watcher import Watcher
from rigrunner_panel.process.launch import Process
from rigrunner_panel.process.messages import Abort, Answer, Decide, Drawn, Pause, PutOnRecord, Stop

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from rigrunner.engine import Interference
    from rigrunner_panel.live.curves import Curves
    from rigrunner_panel.live.story import Links
    from rigrunner_panel.process.messages import ByHand, Job
    from rigrunner_panel.view.board import Board
    from rigrunner_panel.view.sections import AlarmView

_log = logging.getLogger("rigrunner_panel")

RIG_PROCESS = "rigrunner_panel.jobs.main"
GUARDIAN_S = 3600.0
"""How long the events of the guardian are read after the process of a run has died."""
LOOK_S = 0.5


class Desk:
    """Starts jobs, receives their events, and forwards commands. Thread-safe."""

    def __init__(
        self, board: Board, runs: Path, left_energised: Callable[[], tuple[AlarmView, ...]]
    ) -> None:
        self.board = board
        self.runs = runs
        self._left_energised = left_energised
        self._lock = threading.RLock()
        self._story: Story | None = None
        self._process: Process | None = None
        self._watcher: Watcher | None = None

    @property
    def is_busy(self) -> bool:
        """Whether a job is running."""
        with self._lock:
            return self._story is not None and not self._story.is_over

    @property
    def name(self) -> str:
        """A description of the running job."""
        with self._lock:
            job = self._story.job if self._story is not None else None
        return "nothing" if job is None else job.run or f"the {job.kind} of {job.procedure}"

    @property
    def curves(self) -> Curves | None:
        """The live curves of the current or last job."""
        with self._lock:
            return None if self._story is None else self._story.curves

    def start(self, job: Job, links: Links) -> None:
        """Start a job; raise PanelError while another one is running."""
        with self._lock:
            if self.is_busy:
                raise wrong_state("the rig is in use", "wait until it ends, or abort it")
            process = Process(RIG_PROCESS)
            story = Story(self.board, job.view, links, self._left_energised())
            watcher = None
            if job.view.kind != "preflight":
                watcher = Watcher(self.runs, job.station, partial(self._show_findings, story))
            self._story, self._process, self._watcher = story, process, watcher
            process.send(job)
            process.listen(partial(self._receive, story), partial(self._lost, story))

    def answer(self, prompt: int, text: str, by: str) -> None:
        """Answer a prompt; raise PanelError for another prompt or an invalid answer."""
        with self._lock:
            self._running_story()
            prompt_view = self.board.get("prompt")
            if prompt_view is None or prompt_view.id != prompt:
                raise wrong_state("this question is no longer open", "look at state.prompt")
            if not text.strip():
                raise PanelError(422, "invalid", "the answer is empty", prompt_view.expected)
            try:
                accepted = prompt_view.accepts.accept(text)
            except AnswerError as error:
                raise PanelError(422, "invalid", error.message, error.hint) from error
            self._send(Answer(prompt, accepted, by))

    def pause(self, by: str, decision: Decision | None = None) -> None:
        """Pause at the next safe point; with a decision, apply it at once."""
        with self._lock:
            story = self._running_story()
            if self.board.get("phase") not in ("running", "asking", "pausing"):
                raise wrong_state("no run is in progress")
            self._send(Pause(by, decision))
            story.request(str(decision.choice) if decision else "pause")

    def decide(self, choice: Choice, by: str, reason: str) -> None:
        """Continue a paused run as decided; to repeat or skip, a running one is paused first."""
        decision = Decision(choice, by, reason)
        with self._lock:
            self._running_story()
            if self.board.get("pause") is None:
                if choice not in (Choice.REPEAT, Choice.SKIP):
                    raise wrong_state("the run is not paused", "pause it first")
                self.pause(by, decision)
                return
            allowed = self.board.get("pause").choices
            if choice not in allowed:
                raise wrong_state(f"'{choice}' is not possible here", f"now: {', '.join(allowed)}")
            self._send(Decide(decision))

    def abort(self, by: str, reason: str) -> None:
        """Abort the run: its teardown is done and the rig is made safe."""
        with self._lock:
            story = self._running_story()
            self._send(Abort(by, reason))
            story.request("abort")

    def stop(self, by: str, reason: str) -> bool:
        """Make the rig safe at once; return whether a job was running."""
        process = self._process  # without the lock: nothing may be waited for
        stopped = process is not None and process.send(Stop(by, reason))
        with self._lock:
            if self._story is not None and not self._story.is_over:
                self._story.request("stop")
                return stopped
        return False

    def by_hand(self, command: ByHand) -> None:
        """Forward a manual command; raise PanelError if the manual page is not open."""
        with self._lock:
            if self._running_story().job.kind != "manual":
                raise wrong_state("manual mode is not connected to the rig", "open it first")
            self._send(command)

    def put_on_record(self, what: Interference) -> None:
        """Record in the run what a person did, if a run is in progress."""
        with self._lock:
            if self.is_busy:
                self._send(PutOnRecord(what))

    def tick(self) -> None:
        """Update the elapsed time on the screen, and check for rigs that were left energised."""
        rigs = self._left_energised()
        with self._lock:
            if self._story is None:
                self.board.put(alarms=rigs)
                return
            self._story.show_left_energised(rigs)
            self._story.tick()

    def wait(self, timeout_s: float) -> bool:
        """Wait until no job is running; return whether none is."""
        until_s = time.monotonic() + timeout_s
        while self.is_busy and time.monotonic() < until_s:
            time.sleep(0.05)
        return not self.is_busy

    def close(self) -> None:
        """Close the connection to the process; it then aborts a run in progress."""
        if self._process is not None:
            self._process.close()
        if self._watcher is not None:
            self._watcher.close()

    def _show_findings(self, story: Story, message: object) -> None:
        """Show what the analyst found."""
        with self._lock:
            self._show(story, message)
        if isinstance(message, Drawn):
            self.board.wake()

    def _show(self, story: Story, message: object) -> None:
        try:
            story.take(message)
        except Exception:  # noqa: BLE001  (nothing on a screen may cost the run its listener)
            _log.exception("a bug in the panel: the screen may be wrong, the run is not")

    def _receive(self, story: Story, message: object) -> None:
        with self._lock:
            self._show(story, message)
            # Late messages of an earlier job are not for the analyst of this one.
            watcher = self._watcher if story is self._story else None
        if watcher is not None:
            watcher.notice(message)
        if isinstance(message, Samples):
            self.board.wake()

    def _lost(self, story: Story, code: int | None) -> None:
        with self._lock:
            story.show_left_energised(self._left_energised())
            story.lost(code)
            is_lost = story.follows_record
            if self._watcher is not None and story is self._story:
                self._watcher.close()
        if is_lost:
            self._follow_record(story)

    def _follow_record(self, story: Story) -> None:
        """Show what is recorded in a run after its process died: what the guardian read back."""
        run, size = self.runs / story.job.run, -1
        until_s = time.monotonic() + GUARDIAN_S
        while story is self._story and time.monotonic() < until_s:
            with suppress(OSError, RigrunnerError):  # it was closed as it is, or is being written
                if (now := RunFolder(run).events.stat().st_size) != size:
                    events, size = read(run).events, now
                    with self._lock:
                        for event in events:
                            if event.seq > story.latest:
                                self._show(story, event)
            time.sleep(LOOK_S)

    def _running_story(self) -> Story:
        if self._story is None or self._story.is_over:
            raise wrong_state("nothing is running")
        return self._story

    def _send(self, message: object) -> None:
        if self._process is None or not self._process.send(message):
            raise wrong_state("the process of the run no longer exists", "check the rig")
