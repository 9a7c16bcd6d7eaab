"""The end of a run once the rig is safe: analysed, sealed, reported."""

from __future__ import annotations

import json
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api.cleanup import add_beside, error_text
from rigrunner.api.errors import AbortedError, ExitCode, RigrunnerError
from rigrunner.api.events import CONCLUDED, Outcome
from rigrunner.engine.pausing import Reasoned
from rigrunner.run.partners import later_partners
from rigrunner.run.report import AnalysedRun, write_report
from rigrunner.run.stored import verdict_code, with_partners
from rigrunner.runfile import check_file
from rigrunner.runfile.durable import reading, write_whole
from rigrunner.runfile.folder import RunFolder

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

    from rigrunner.api.devices import StopToken
    from rigrunner.api.progress import Progress
    from rigrunner.api.results import Result
    from rigrunner.run.prepare import Planned
    from rigrunner.runfile import RunWriter

RESULT_FILE = "result.json"


@dataclass(frozen=True, kw_only=True, eq=False)
class FinishedRun:
    """What a run left behind."""

    folder: Path
    outcome: Outcome
    reason: str
    error: BaseException | None
    """The first error of the run, or else of its analysis or sealing."""
    sealed: bool = True
    """Whether run.h5 exists; else the folder has the recorded data, as after a crash."""
    result: Result | None = None
    report: Path | None = None
    passed_over: tuple[str, ...] = ()
    """Failures after which the run continued, as the procedure says."""
    unsafe: str = ""
    """Why the rig is not known to be safe, as text."""
    waits: bool = False
    """Whether it stays open for a partner run after it; it has no result until then."""

    @property
    def exit_code(self) -> ExitCode:
        """Exit code of the command; a rig that is not safe comes before all else."""
        if self.unsafe:
            return ExitCode.DEVICE
        if isinstance(self.error, KeyboardInterrupt):
            return ExitCode.INTERRUPTED
        if self.outcome is Outcome.ABORTED and not isinstance(self.error, AbortedError):
            return ExitCode.ABORTED
        if isinstance(self.error, RigrunnerError):
            return self.error.exit_code
        if self.error is not None:
            return ExitCode.BUG
        code = verdict_code(self.result)
        undecided = self.waits or (code is ExitCode.PASS and self.passed_over)
        return ExitCode.UNDECIDED if undecided else code


def finish(
    planned: Planned,
    writer: RunWriter,
    end: tuple[Outcome, str, tuple[str, ...]],
    partners: Mapping[str, Path],
    errors: list[BaseException],
    *,
    progress: Progress,
    to_be_resumed: bool = False,
) -> FinishedRun:
    """Analyse the data, seal the run in any case, and report.

    `end` is outcome, reason, and failures that were skipped. A run that cannot be sealed stays
    open, and so does one that is `to_be_resumed`, or whose procedure requires a partner run after
    it.
    """
    outcome, reason, passed_over = end
    folder = writer.folder
    # Before the data are read: this waits until each finished recording has its file.
    with collecting(errors):
        writer.close()
    run = report = plot = None
    # A manual session, which has no planned step, may end without a point.
    is_empty = not planned.plan.steps and not writer.recordings
    analysed = bool(planned.procedure.model.analysis) and not is_empty
    awaited = {*later_partners(planned)} - partners.keys()
    waits = outcome is Outcome.COMPLETED and analysed and bool(awaited)
    with collecting(errors):
        if not waits and outcome in CONCLUDED:
            analysed_run = _analysed(planned, writer, partners, progress, analysed=analysed)
            if analysed_run is not None:
                plots = (details.plot() for details in analysed_run.result.details)
                plot = next(filter(None, plots), None)
                # Only now: the details are a plugin's, and may fail.
                run = analysed_run
    if not (to_be_resumed or waits):
        with collecting(errors):
            writer.seal(None if run is None else run.document, plot, partners)
    file, sealed = RunFolder(folder).sealed_file, False
    with collecting(errors), reading(folder):
        # Checked, since a Ctrl-C is raised only after the file has its name.
        sealed = file.exists()
    if run is not None and sealed:
        with collecting(errors), reading(folder):
            _write_result(folder, run.document)
            # Read from the disk: the report is made of the data that were written to it.
            check_file(file)
            report = write_report(folder, planned.registry, analysed=run)
    for error in errors[1:]:
        add_beside(errors[0], error_text(error))
    return FinishedRun(
        folder=folder,
        outcome=outcome,
        reason=reason,
        error=next(iter(errors), None),
        sealed=sealed,
        result=None if run is None else run.result,
        report=report,
        passed_over=passed_over,
        waits=waits and not sealed,
    )


def _analysed(
    planned: Planned,
    writer: RunWriter,
    partners: Mapping[str, Path],
    progress: Progress,
    *,
    analysed: bool,
) -> AnalysedRun | None:
    """Return a run that is `analysed`, or has limited measured values, with its result."""
    if not analysed and not any(step.limits or step.terms.expected for step in planned.plan.steps):
        return None  # without reading what may be many thousands of rows
    stored, truth = writer.read_with_truth()
    if not analysed and not any(row.limits or row.expected for row in stored.measurements):
        return None
    stored = with_partners(stored, partners)
    return AnalysedRun.of(stored, truth, planned.registry, progress)


def stoppable(progress: Progress, stop: StopToken) -> Progress:
    """Return a progress that ends the analysis at a stop: the run is sealed without a result."""

    def report_progress(what: str, done: int, of: int) -> None:
        progress(what, done, of)
        if stop.is_set():
            kind = type(stop.reason()) if isinstance(stop, Reasoned) else AbortedError
            raise kind(
                f"stopped at {done} of {of} {what}",
                hint="the run is complete: 'rigrunner analyse' makes its result",
            )

    return report_progress


def _write_result(folder: Path, content: Mapping[str, object]) -> None:
    text = json.dumps(content, ensure_ascii=False, indent=2, allow_nan=False)
    write_whole(folder / RESULT_FILE, f"{text}\n".encode())


@contextmanager
def collecting(errors: list[BaseException]) -> Iterator[None]:
    """Collect an error for the FinishedRun, since the data must be sealed in any case."""
    try:
        yield
    except BaseException as error:  # noqa: BLE001  (of a plugin, or Ctrl-C)
        errors.append(error)
