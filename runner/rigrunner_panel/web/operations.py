"""All operations of the API: routes and their description come from this table."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

from rigrunner.engine import Choice
from rigrunner.yamlfile.reader import MAX_BYTES
from rigrunner_panel.control import short_name
from rigrunner_panel.errors import PanelError
from rigrunner_panel.view.queue import QueueView
from rigrunner_panel.view.rigs import Rigs
from rigrunner_panel.view.sections import State
from rigrunner_panel.web import (
    answers,
    by_hand,
    certificates,
    choosing,
    editing,
    queueing,
    requests,
    running,
    stored_runs,
    studies,
)
from rigrunner_panel.web.operation import API, Operation
from rigrunner_panel.web.overview import rig_views

if TYPE_CHECKING:
    from collections.abc import Callable

    from pydantic import BaseModel

    from rigrunner_panel.web.operation import ApiRequest
    from rigrunner_panel.web.panel import Panel, Rig

    Handler = Callable[[Any, ApiRequest], Any]

_SEARCH = {"search": "words that must all occur"}
_TICKET = {"ticket": "as in the address that the panel gave, in place of the token"}
_BEGUN = 202
_A_PROCEDURE = 3 * MAX_BYTES
"""Bytes of a body with a procedure: JSON may write a character as an escape."""


def _get(
    path: str, summary: str, handler: Handler, answer: type[BaseModel] | None, **query: str
) -> Operation:
    return Operation("GET", f"{API}/{path}", summary, handler, answer, query=query)


def _post(
    path: str,
    summary: str,
    handler: Handler,
    body: type[BaseModel],
    answer: type[BaseModel] = answers.Done,
    **options: Any,
) -> Operation:
    return Operation("POST", f"{API}/{path}", summary, handler, answer, body, **options)


_steer = partial(_post, steers=True)


def _of_rig(*operations: Operation) -> tuple[Operation, ...]:
    query = {"rig": "the name of its station; it may be left out where the panel has one rig"}
    return tuple(replace(op, of_rig=True, query={**op.query, **query}) for op in operations)


def _rigs(panel: Panel, _: ApiRequest) -> Rigs:
    return Rigs(rigs=rig_views(panel.rigs()))


def _state(rig: Rig, request: ApiRequest) -> str:
    return rig.board.state(short_name(request.client) if request.client else "")


def _events(rig: Rig, request: ApiRequest) -> str:
    after = request.query.get("after", "-1")
    if not re.fullmatch(r"-1|[0-9]{1,15}", after):
        raise PanelError(400, "bad_request", f"after: got '{after[:40]}', expected a whole number")
    return rig.board.events(int(after))


_RIGS = (
    _get("rigs", "All rigs, as the overview shows them.", _rigs, Rigs),
    Operation(
        "POST", f"{API}/stop", "Make rigs safe at once, without teardown; for everyone.",
        running.stop, answers.Stopped, requests.Why, urgent=True,
        query={"rig": "the name of its station; all rigs where it is left out"},
    ),
)  # fmt: skip
_CHOOSING = (
    _get(
        "procedures", "Procedures, last used first.", choosing.procedures, answers.Procedures,
        **_SEARCH,
    ),
    _get("stations", "Stations, last used first.", choosing.stations, answers.Stations, **_SEARCH),
    _post(
        "plan", "Preview a run; nothing is connected.", choosing.plan, requests.AskPlan,
        answers.PlanAnswer, longest=_A_PROCEDURE,
    ),
    _post(
        "check-input", "Check an answer to an input.", choosing.check_input,
        requests.CheckInput, answers.InputAnswer,
    ),
)  # fmt: skip
_EDITING = (
    _get(
        "procedures/text", "The text of a procedure.", editing.text, answers.OpenedProcedure,
        name="of the procedure in the list",
    ),
    _get(
        "procedures/schema", "The JSON Schema of procedures.", editing.schema,
        answers.LanguageSchema, station="whose folder has plugins",
    ),
    _post(
        "procedures/edit", "Tell others that a procedure is being edited.", editing.edit,
        requests.EditProcedure,
    ),
    _post(
        "procedures/leave", "Tell others that it is no longer edited.", editing.leave,
        requests.Nothing,
    ),
    _post(
        "procedures/check", "Check a text, alone or on a station.", editing.check,
        requests.CheckText, answers.CheckedProcedure, longest=_A_PROCEDURE,
    ),
    _post(
        "procedures/compare", "What a text changes, in words.", editing.compare,
        requests.CompareText, answers.ProcedureComparison, longest=_A_PROCEDURE,
    ),
    _post(
        "procedures/save", "Save a text in the lab's folder, if the file is as it was opened.",
        editing.save, requests.SaveProcedure, answers.SavedProcedure, longest=_A_PROCEDURE,
    ),
    _post(
        "procedures/approve", "Approve a procedure as it is.", editing.approve_text,
        requests.ApproveProcedure,
    ),
)  # fmt: skip
_RUNNING = _of_rig(
    _get("state", "The whole state.", _state, State),
    _get(
        "events", "The latest events of the present or last job, oldest first.", _events,
        answers.Events, after="only those after this number",
    ),
    _post("control", "Take control.", running.take_control, requests.TakeControl),
    _steer("control/release", "Release control.", running.release_control, requests.Nothing),
    _steer(
        "preflight", "Connect to the rig and check what a run needs.",
        running.start_preflight, requests.StartPreflight, status=_BEGUN,
    ),
    _steer(
        "run/start", "Start a run after its preflight, or queue it.",
        queueing.start_run, requests.StartRun, answers.Started, status=_BEGUN,
    ),
    _steer(
        "runs/{run}/resume", "Resume an interrupted run of this rig.",
        running.resume_stored, requests.ResumeRun, status=_BEGUN,
    ),
    _steer("run/answer", "Answer the open prompt.", running.answer, requests.GiveAnswer),
    _steer("run/pause", "Pause at the next safe point.", running.pause, requests.Nothing),
    _steer(
        "run/resume", "Resume after a pause.",
        running.decision_handler(Choice.RESUME), requests.Nothing,
    ),
    _steer(
        "run/override", "Resume despite an interlock that may be overridden.",
        running.decision_handler(Choice.OVERRIDE), requests.BecauseOf,
    ),
    _steer(
        "run/repeat", "Repeat the set-point; a running run is paused first.",
        running.decision_handler(Choice.REPEAT), requests.Why,
    ),
    _steer(
        "run/skip", "Skip the rest of the set-point; a running run is paused first.",
        running.decision_handler(Choice.SKIP), requests.BecauseOf,
    ),
    _steer(
        "run/note", "Add a note while paused.",
        running.decision_handler(Choice.NOTE), requests.Remark,
    ),
    _steer(
        "run/abort", "Abort the run: teardown, then the rig is made safe.",
        running.abort, requests.Why,
    ),
)  # fmt: skip
_QUEUE = _of_rig(
    _get("queue", "The queue.", queueing.queue, QueueView),
    _post(
        "queue/propose", "Add specimens that a person has to release; for everyone.",
        queueing.propose, requests.ProposeEntries, answers.Added,
    ),
    _steer(
        "queue/add", "Add specimens that wait for their turn.", queueing.add,
        requests.AddEntries, answers.Added,
    ),
    _steer("queue/move", "Put an entry in front of another one.", queueing.move, requests.Move),
    _steer("queue/hold", "Hold an entry.", queueing.hold, requests.EntryBecause),
    _steer(
        "queue/release", "Release an entry that is proposed or held.", queueing.release,
        requests.OneEntry,
    ),
    _steer(
        "queue/skip", "Skip an entry, or close one whose run was interrupted.", queueing.skip,
        requests.EntryBecause,
    ),
    _steer(
        "queue/repeat", "Test the specimen of an entry again.", queueing.repeat,
        requests.EntryBecause, answers.Added,
    ),
    _steer(
        "queue/clear", "Remove finished entries; their runs stay.", queueing.clear,
        requests.Nothing, answers.Cleared,
    ),
    _steer(
        "queue/start", "Start an entry, or the next one, after a preflight.", queueing.start,
        requests.OneEntry, status=_BEGUN,
    ),
    _steer(
        "queue/automatic", "Switch the automatic start of queued runs on or off.",
        queueing.automatic, requests.SetAutomatic,
    ),
)  # fmt: skip
_BY_HAND = _of_rig(
    _steer(
        "manual/open", "Open the manual mode, after a preflight as for a run.",
        by_hand.open_manual, requests.OpenManual, status=_BEGUN,
    ),
    _steer("manual/set", "Set a drive within its limits.", by_hand.set_drive, requests.SetDrive),
    _steer(
        "manual/record", "Record a point where the rig is.", by_hand.record_point,
        requests.RecordPoint,
    ),
    _steer(
        "manual/close", "Make the rig safe, and seal what was recorded.", by_hand.close_manual,
        requests.Nothing,
    ),
)  # fmt: skip
_STORED_RUNS = (
    _get(
        "runs", "Stored runs, newest first.", stored_runs.runs, answers.Runs, **_SEARCH,
        procedure="its id", station="its id",
        outcome="completed, stopped at a limit, aborted or error",
        verdict="as the report has it", limit="how many, at most 200", before="this run",
    ),
    _get("runs/{run}", "One run.", stored_runs.run, answers.OneRun),
    _get(
        "runs/{run}/again", "What to start with for the next specimen.", stored_runs.again,
        answers.Again,
    ),
    _get("runs/{run}/files/{name}", "A file of a run.", stored_runs.file, None, **_TICKET),
    _steer(
        "runs/{run}/recover", "Close an interrupted run as it is; its rig is not touched.",
        stored_runs.recover_stored, requests.Why,
    ),
    _get("pictures/{key}", "The picture of a prompt.", stored_runs.picture, None, **_TICKET),
    _get(
        "compare", "Differences between two runs.", stored_runs.compare,
        answers.ComparisonAnswer, before="a run", after="another run",
    ),
)  # fmt: skip
_STUDIES = (
    _get(
        "overlay", "Overlay results and a channel of several runs.",
        studies.overlay, answers.OverlayAnswer, runs="their names, with commas, at most 6",
        recording="its name", channel="such as tester.torque",
    ),
    _post(
        "archive/update", "Bring the archive up to date with the runs.", studies.update,
        requests.Nothing, answers.ArchiveUpdated,
    ),
    _get(
        "archive/quantities", "Quantities to chart.", studies.quantities, answers.Quantities
    ),
    _get(
        "trend", "Control charts of a quantity.", studies.trend, answers.TrendAnswer,
        quantity="its name", by="type, lot, rig, mandrel, specimen, operator, procedure, revision",
        chart="i-mr or ewma", rules="nelson, western-electric or shewhart",
        baseline="the first N, or FROM..TO in days", procedure="its id",
        since="a day", until="a day",
    ),
)  # fmt: skip
_CERTIFICATES = (
    _get(
        "runs/{run}/certificates", "Certificates of a run.", certificates.certificates,
        answers.Certificates,
    ),
    _post(
        "runs/{run}/verify", "Verify a run, and compute its result again.",
        certificates.verify_stored, requests.Nothing, answers.VerificationAnswer,
    ),
    _post(
        "runs/{run}/certificates/{number}/verify", "Verify a certificate.", certificates.verify,
        requests.Nothing, answers.VerificationAnswer,
    ),
    _steer(
        "runs/{run}/certificate", "Issue a certificate.", certificates.issue,
        requests.AskCertificate, answers.IssuedAnswer,
    ),
    _steer(
        "runs/{run}/certificates/{number}/amend", "Issue a document that replaces a certificate.",
        certificates.change, requests.AskAmendment, answers.IssuedAnswer,
    ),
    _steer(
        "runs/{run}/certificates/{number}/withdraw", "Withdraw a certificate without replacing it.",
        certificates.withdraw_certificate, requests.AskWithdrawal, answers.WithdrawnAnswer,
    ),
    _steer(
        "runs/{run}/certificates/{number}/sign", "Sign a certificate.",
        certificates.sign_certificate, requests.AskSignature, answers.SignedAnswer,
    ),
)  # fmt: skip
OPERATIONS = (
    *_RIGS,
    *_CHOOSING,
    *_EDITING,
    *_RUNNING,
    *_QUEUE,
    *_BY_HAND,
    *_STORED_RUNS,
    *_CERTIFICATES,
    *_STUDIES,
)
