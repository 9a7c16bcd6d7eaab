"""Procedures as text: opened, checked while they are typed, compared, saved and approved."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from rigrunner.api.errors import InvalidFileError, RigrunnerError
from rigrunner.procedure import load_procedure
from rigrunner.run.approval import approval_file, approval_state, approve, approved_in, moment_of
from rigrunner.run.checked import checked_alone
from rigrunner.run.lab_plugins import lab_registry
from rigrunner.run.planning import planned_run
from rigrunner.run.runs import listed_run
from rigrunner.tools.comparing.compare import compare_procedures, compare_with_run
from rigrunner.tools.schemas.files import language_schema
from rigrunner_panel.errors import PanelError
from rigrunner_panel.files import ChangedError
from rigrunner_panel.web.answers import (
    ChangeView,
    CheckedProcedure,
    Done,
    OpenedProcedure,
    PlacedProblem,
    ProcedureComparison,
    SavedProcedure,
)

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from rigrunner.api.errors import Problem
    from rigrunner.procedure import LoadedProcedure
    from rigrunner.run.approval import ApprovalState
    from rigrunner.runfile import RunHeader
    from rigrunner.tools.comparing.compare import Comparison
    from rigrunner_panel.web.operation import ApiRequest
    from rigrunner_panel.web.panel import Panel
    from rigrunner_panel.web.requests import (
        ApproveProcedure,
        CheckText,
        CompareText,
        EditProcedure,
        SaveProcedure,
    )

MOST_RUNS = 200
"""Of a procedure, among which the approved text is looked for, newest first."""


def text(panel: Panel, request: ApiRequest) -> OpenedProcedure:
    """Return the text of a procedure, and whether it is approved as it stands."""
    name = request.query.get("name", "")
    file, last = panel.files.read(name), panel.editing.last_change(name)
    state, problem = _state(file.path)
    return OpenedProcedure(
        name=name,
        text=file.text,
        digest=file.digest,
        shipped=panel.files.is_shipped(name),
        changed_utc=last.utc,
        changed_by=last.by,
        state="draft" if state is None else state.state,
        approval=problem if state is None else state.sentence(),
        sha256="" if state is None else state.sha256,
    )


def edit(panel: Panel, request: ApiRequest) -> Done:
    """Tell others that a procedure is being edited."""
    body: EditProcedure = request.body
    panel.editing.open(request.client, body.procedure, body.by.strip(), panel.now())
    return Done()


def leave(panel: Panel, request: ApiRequest) -> Done:
    """Tell others that it is no longer edited."""
    panel.editing.leave(request.client)
    return Done()


def check(panel: Panel, request: ApiRequest) -> CheckedProcedure:
    """Check a text as `rigrunner check` does: alone, or on a station."""
    body: CheckText = request.body
    path = panel.files.place(body.procedure)
    try:
        if body.station:
            station = panel.catalogue.path("station", body.station)
            planned = planned_run(path, station, text=body.text)
            loaded = planned.procedure
        else:
            loaded = checked_alone(path, body.text)
        state = approval_state(loaded)
    except InvalidFileError as error:
        problems = [_placed_problem(problem, path) for problem in error.problems]
        return CheckedProcedure(ok=False, problems=problems, approval="", state="draft")
    except RigrunnerError as error:
        problem = PlacedProblem(message=error.message, hint=error.hint)
        return CheckedProcedure(ok=False, problems=[problem], approval="", state="draft")
    return CheckedProcedure(ok=True, problems=[], approval=state.sentence(), state=state.state)


def compare(panel: Panel, request: ApiRequest) -> ProcedureComparison:
    """Return in words what a text changes: of its file, or of what was approved or run last."""
    body: CompareText = request.body
    path = panel.files.place(body.procedure)
    now = load_procedure(path, text=body.text)
    if body.against == "file":
        return _comparison("file", "", compare_procedures(load_procedure(path), now))
    against, header = _reference(panel, now, path)
    if header is None:
        return ProcedureComparison(against=against, run="", same=False, verdict="", changes=[])
    return _comparison(against, header.run_id, compare_with_run(header, now))


def save(panel: Panel, request: ApiRequest) -> SavedProcedure:
    """Replace a file that is still as it was when it was opened."""
    body: SaveProcedure = request.body
    name, by = body.procedure, body.by.strip()
    try:
        digest = panel.files.write(name, body.text, body.digest)
    except ChangedError as error:
        raise _changed_error(panel, name) from error
    panel.editing.saved(name, digest, by, panel.now())
    return SavedProcedure(digest=digest)


def approve_text(panel: Panel, request: ApiRequest) -> Done:
    """Approve a procedure as it stands, if that is what the person has seen."""
    body: ApproveProcedure = request.body
    loaded = load_procedure(panel.files.place(body.procedure))
    if loaded.digest_with_called != body.sha256:
        raise _changed_error(panel, body.procedure)
    approve(loaded, body.by, moment_of(None, panel.now()))
    return Done()


def schema(panel: Panel, request: ApiRequest) -> str:
    """Return the JSON Schema of procedures, with the plugins of a station's folder if named."""
    station = request.query.get("station", "")
    path = str(panel.catalogue.path("station", station)) if station else None
    return json.dumps(language_schema("procedure", lab_registry(path)), ensure_ascii=False)


def _state(path: Path) -> tuple[ApprovalState | None, str]:
    """Return whether a file is approved; for one that cannot be read, why that is not known."""
    try:
        return approval_state(load_procedure(path)), ""
    except RigrunnerError as error:
        return None, error.message


def _placed_problem(problem: Problem, path: Path) -> PlacedProblem:
    """Return a problem with its line, of another file with that file's name."""
    location = problem.location
    is_in_text = location is not None and location.file == str(path)
    return PlacedProblem(
        message=problem.message.replace(str(path), path.name),
        hint=problem.hint.replace(str(path), path.name),
        field=problem.field,
        file="" if is_in_text or location is None else location.file.rpartition("/")[2],
        line=None if location is None else location.line,
        column=None if location is None else location.column,
    )


def _comparison(against: str, run: str, comparison: Comparison) -> ProcedureComparison:
    changes = [
        ChangeView(section=change.section, text=change.text, matters=change.matters)
        for change in comparison.changes
    ]
    verdict = "" if changes else comparison.verdict
    return ProcedureComparison(
        against=against, run=run, same=not changes, verdict=verdict, changes=changes
    )


def _reference(
    panel: Panel, procedure: LoadedProcedure, path: Path
) -> tuple[str, RunHeader | None]:
    """Return the run that has the approved text, or else the last run of the procedure.

    An approval names a text by its digest alone; the text itself is kept with each run.
    """
    approved = approved_in(approval_file(path))
    last: RunHeader | None = None
    for header in _headers(panel, procedure.model.id):
        if approved is None:
            return "run", header
        if header.approval.get("sha256") == approved.sha256:
            return "approved", header
        last = last or header
    return "run", last


def _headers(panel: Panel, procedure: str) -> Iterator[RunHeader]:
    items = (item for item in panel.history.items() if item.procedure == procedure)
    for item, _ in zip(items, range(MOST_RUNS), strict=False):
        info = listed_run(panel.history.runs, item.run).info
        if info is not None:
            yield info.header


def _changed_error(panel: Panel, name: str) -> PanelError:
    """Return the answer where a file was changed since it was opened: by whom, and when."""
    hint = "compare, then open it again or save over it"
    try:
        last = panel.editing.last_change(name)
    except PanelError:
        return PanelError(409, "changed", f"{name} was removed", hint)
    by = last.by or "another program"
    return PanelError(409, "changed", f"{name} was changed by {by} at {last.utc}", hint)
