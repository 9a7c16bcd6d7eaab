"""A run from start to sealed folder: measure, analyse, seal, report."""

from __future__ import annotations

import json
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.analysis.analyse import unseen
from rigrunner.analysis.document import document
from rigrunner.api.errors import AbortedError, ExitCode, RigrunnerError
from rigrunner.api.events import Outcome
from rigrunner.api.results import Verdict
from rigrunner.bus import Bus
from rigrunner.clock import utc_text
from rigrunner.engine import run_plan
from rigrunner.plan import plan_text
from rigrunner.rig import Patience, Rig
from rigrunner.runfile import RunHeader, RunWriter, create_run_folder
from rigrunner.station.drive_rules import DriveRules
from rigrunner.workflow.log import RunLog
from rigrunner.workflow.overrides import require_overridden
from rigrunner.workflow.plot import sweep_plot
from rigrunner.workflow.provenance import identities, software
from rigrunner.workflow.report import write_report
from rigrunner.workflow.rig_lock import rig_lock
from rigrunner.workflow.stored import NO_ANALYSIS, analyse_run

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from pathlib import Path

    from rigrunner.analysis.analyse import Progress
    from rigrunner.api.devices import Identity, StopToken
    from rigrunner.api.events import EventSink
    from rigrunner.api.results import Result
    from rigrunner.engine import AnswerSource, Override, Pauses, RunSummary
    from rigrunner.workflow.prepare import Planned

RESULT_FILE = "result.json"


@dataclass(frozen=True, kw_only=True, eq=False)
class FinishedRun:
    """What a run left behind."""

    folder: Path
    outcome: Outcome
    reason: str
    error: BaseException | None
    """The first error of the run, or else that of its analysis."""
    result: Result | None = None
    report: Path | None = None
    passed_over: tuple[str, ...] = ()
    """The failures after which the run went on because the procedure says so."""

    @property
    def exit_code(self) -> ExitCode:
        """How a command that did this run ends."""
        if isinstance(self.error, KeyboardInterrupt):
            return ExitCode.INTERRUPTED
        if self.outcome is Outcome.ABORTED and not isinstance(self.error, AbortedError):
            return ExitCode.ABORTED
        if isinstance(self.error, RigrunnerError):
            return self.error.exit_code
        if self.error is not None:
            return ExitCode.BUG
        code = verdict_code(self.result)
        return ExitCode.UNDECIDED if code is ExitCode.PASS and self.passed_over else code


def verdict_code(result: Result | None) -> ExitCode:
    """Return the exit code of a completed run: its verdict, where there is one to give."""
    if result is None or result.decision is None:
        return ExitCode.PASS
    codes = {Verdict.PASS: ExitCode.PASS, Verdict.FAIL: ExitCode.FAIL}
    return codes.get(result.decision.verdict, ExitCode.UNDECIDED)


def execute(
    planned: Planned,
    *,
    runs: Path,
    inputs: Mapping[str, str],
    no_load: Path | None,
    answers: AnswerSource,
    stop: StopToken,
    listeners: Sequence[EventSink] = (),
    operator: str = "",
    overrides: Sequence[Override] = (),
    pauses: Pauses | None = None,
    progress: Progress = unseen,
) -> FinishedRun:
    """Connect the rig, run the plan, seal the folder and write the report.

    `operator` is who does it, or else the input of that name. Raises InvalidFileError where a
    calibration keeps the run from starting and is not overridden, a DeviceError if the rig cannot
    be connected or another run has it, and DataError if the folder cannot be made; from then on
    what happens is in the FinishedRun, and the rig is made safe on every way.
    """
    require_overridden(planned, overrides)
    people = {"operator": name} if (name := operator or inputs.get("operator", "")) else {}
    errors: list[BaseException] = []
    with rig_lock(planned):
        rig = _rig_of(planned)
        identified = rig.connect()
        try:
            writer = _new_folder(planned, runs, inputs, people, identified)
            with RunLog(writer.folder / "run.log") as log:
                bus = Bus(critical=[writer], guarded=[log, *listeners])
                run_id = writer.folder.name
                summary = run_plan(
                    planned.plan,
                    rig,
                    bus,
                    planned.clock,
                    answers,
                    stop,
                    run_id,
                    overrides,
                    pauses=pauses,
                )
        finally:
            rig.make_safe()
            with _kept(errors):
                rig.close()
    if summary.error is not None:
        errors.insert(0, summary.error)
    return _finish(planned, writer, summary, no_load, errors, progress=_stoppable(progress, stop))


def _rig_of(planned: Planned) -> Rig:
    safety = planned.station.model.safety
    patience = Patience(safety.patience.connect, safety.patience.answer)
    rules = DriveRules(safety.drives, safety.combinations)
    return Rig(planned.devices, planned.clock, patience, safety.order, rules)


def _new_folder(
    planned: Planned,
    runs: Path,
    inputs: Mapping[str, str],
    people: Mapping[str, str],
    identified: Mapping[str, Identity],
) -> RunWriter:
    procedure, station = planned.procedure, planned.station
    started = planned.clock.utc()
    folder = create_run_folder(runs, started, procedure.model.id, inputs.get("specimen", ""))
    header = RunHeader(
        run_id=folder.name,
        started_utc=utc_text(started),
        procedure_id=procedure.model.id,
        procedure_revision=procedure.model.revision,
        procedure_title=procedure.model.title,
        station_id=station.model.id,
        procedure_text=procedure.text,
        station_text=station.text,
        plan_text=plan_text(planned.plan),
        called_texts=procedure.called_texts,
        inputs=inputs,
        people=people,
        approval=planned.approval.texts(),
        provenance=software(planned.registry) | identities(identified),
    )
    return RunWriter(folder, header)


def _finish(
    planned: Planned,
    writer: RunWriter,
    summary: RunSummary,
    no_load: Path | None,
    errors: list[BaseException],
    *,
    progress: Progress,
) -> FinishedRun:
    """Analyse what was recorded, seal it whatever comes of that, and report."""
    writer.close()
    folder = writer.folder
    result = report = None
    asked = planned.procedure.model.analysis != NO_ANALYSIS
    if asked and summary.outcome is Outcome.COMPLETED:
        with _kept(errors):
            result = analyse_run(folder, planned.registry, no_load, progress=progress)
    content = None if result is None else document(result)
    writer.seal(content, None if result is None else sweep_plot(result), no_load)
    if content is not None:
        with _kept(errors):
            _write_result(folder, content)
            report = write_report(folder, planned.registry, result=result)
    return FinishedRun(
        folder=folder,
        outcome=summary.outcome,
        reason=summary.reason,
        error=next(iter(errors), None),
        result=result,
        report=report,
        passed_over=summary.passed_over,
    )


def _stoppable(progress: Progress, stop: StopToken) -> Progress:
    """Return a progress that ends the analysis at a stop: the run is sealed without a result."""

    def told(what: str, done: int, of: int) -> None:
        progress(what, done, of)
        if stop.is_set():
            raise AbortedError(
                f"stopped at {done} of {of} {what}",
                hint="the run is whole: 'rigrunner analyse' makes its result",
            )

    return told


def _write_result(folder: Path, content: Mapping[str, object]) -> None:
    text = json.dumps(content, ensure_ascii=False, indent=2, allow_nan=False)
    (folder / RESULT_FILE).write_text(text + "\n", encoding="utf-8")


@contextmanager
def _kept(errors: list[BaseException]) -> Iterator[None]:
    """Keep an error for the FinishedRun: what was measured must be sealed all the same."""
    try:
        yield
    except BaseException as error:  # noqa: BLE001  (of a plugin, or Ctrl-C)
        errors.append(error)
