"""The queue of a rig at the panel: its requests, and when the next run starts."""

from __future__ import annotations

import logging
from contextlib import ExitStack
from typing import TYPE_CHECKING

from rigrunner.api.errors import RigrunnerError, UsageError
from rigrunner.api.events import CONCLUDED
from rigrunner.procedure import load_procedure
from rigrunner.queue import SPECIMEN, Draft, accepted_inputs, read_list, tested_before
from rigrunner_panel.errors import PanelError, wrong_state
from rigrunner_panel.sequence import PendingStart
from rigrunner_panel.view.queue import EntryView, QueueView
from rigrunner_panel.web.answers import Added, Cleared, Done, Started
from rigrunner_panel.web.choosing import files
from rigrunner_panel.web.requests import Pair, StartPreflight, StartRun
from rigrunner_panel.web.running import (
    begin_preflight,
    check_inputs,
    named_runs,
    preflight_passed,
    start_job,
)

if TYPE_CHECKING:
    from rigrunner.queue.entries import Entry
    from rigrunner.queue.store import Shown
    from rigrunner_panel.web.operation import ApiRequest
    from rigrunner_panel.web.panel import Rig
    from rigrunner_panel.web.requests import (
        AddEntries,
        EntryBecause,
        Move,
        OneEntry,
        ProposeEntries,
        SetAutomatic,
    )

_log = logging.getLogger("rigrunner.panel")
MOST_FINISHED = 200
"""The most finished entries in the list."""
_FINISHED = ("done", "skipped", "closed")


def queue(rig: Rig, _: ApiRequest) -> QueueView:
    """Return the queue."""
    return refresh(rig)


def add(rig: Rig, request: ApiRequest) -> Added:
    """Add specimens that wait for their turn."""
    return _add(rig, request.body, request.by, proposed=False)


def propose(rig: Rig, request: ApiRequest) -> Added:
    """Add specimens that a person has to release first."""
    body: ProposeEntries = request.body
    by = body.by.strip() or rig.control.holds(request.client)
    if not by:
        problem = "a proposal needs a name"
        raise PanelError(422, "invalid", problem, "state in 'by' who or which program proposes it")
    return _add(rig, body, by, proposed=True)


def move(rig: Rig, request: ApiRequest) -> Done:
    """Put an entry in front of another one."""
    body: Move = request.body
    rig.queue.move(_entry(rig, body.entry).id, body.before)
    refresh(rig)
    return Done()


def hold(rig: Rig, request: ApiRequest) -> Done:
    """Hold an entry."""
    body: EntryBecause = request.body
    rig.queue.hold(_entry(rig, body.entry).id, request.by, body.reason.strip())
    refresh(rig)
    return Done()


def release(rig: Rig, request: ApiRequest) -> Done:
    """Release an entry that was proposed or held."""
    body: OneEntry = request.body
    rig.queue.release(_entry(rig, body.entry).id, request.by)
    refresh(rig)
    return Done()


def skip(rig: Rig, request: ApiRequest) -> Done:
    """Skip an entry, or close one whose run was interrupted."""
    body: EntryBecause = request.body
    rig.queue.skip(_entry(rig, body.entry).id, request.by, body.reason.strip())
    refresh(rig)
    return Done()


def repeat(rig: Rig, request: ApiRequest) -> Added:
    """Test the specimen of an entry again."""
    body: EntryBecause = request.body
    entry, reason = _entry(rig, body.entry), body.reason.strip()
    new_entry = rig.queue.repeat(entry.id, request.by, reason, rig.panel.now())
    refresh(rig)
    return Added(entries=[new_entry.id])


def clear(rig: Rig, _: ApiRequest) -> Cleared:
    """Remove finished entries."""
    removed = rig.queue.clear(rig.name)
    refresh(rig)
    return Cleared(removed=removed)


def start(rig: Rig, request: ApiRequest) -> Done:
    """Start an entry, or the next one that waits, after a preflight."""
    body: OneEntry = request.body
    with rig.sequence.lock:
        entry = rig.queue.next(rig.name)  # raises while an interrupted entry needs a decision
        if body.entry:
            entry = _entry(rig, body.entry)
        if entry is None:
            raise wrong_state("no entry of the queue is waiting", "add or release one")
        _start(rig, entry, request.by)
    return Done()


def automatic(rig: Rig, request: ApiRequest) -> Done:
    """Switch the automatic start of runs on or off."""
    body: SetAutomatic = request.body
    with rig.sequence.lock:
        rig.sequence.automatic_by = request.by if body.on else ""
        rig.sequence.problem = ""
    refresh(rig)
    return Done()


def start_run(rig: Rig, request: ApiRequest) -> Started:
    """Start a run that the preflight permits; queue it if the rig is in use."""
    body: StartRun = request.body
    procedure, _ = files(rig.panel, body)
    check_inputs(procedure, body.inputs)
    procedure_id, specimen = load_procedure(procedure).model.id, body.inputs.get(SPECIMEN, "")
    notes = tested_before(rig.panel.settings.runs, procedure_id, [specimen])
    note = notes.get(specimen, "")
    with rig.sequence.lock:
        if body.entry is not None:
            _claim_and_start(rig, _matching_entry(rig, body), request.by, body)
        # A preflight that runs is no reason to queue: until it is done the start is refused.
        elif rig.desk.is_busy and rig.board.get("phase") != "checking":
            draft = _draft(rig, body, body.inputs)
            (new_entry,) = rig.queue.add([draft], request.by, rig.panel.now())
            refresh(rig)
            return Started(entry=new_entry.id, note=note)
        else:
            start_job(rig, "run", body, request.by, body.inputs)
    return Started(note=note)


def tick(rig: Rig) -> None:
    """Finish the entry of a run that has ended; start an entry after its preflight, or the next."""
    sequence = rig.sequence
    try:
        rig.reread()
        with sequence.lock:
            if not rig.desk.is_busy:
                _finish_entry(rig)
                if sequence.pending is not None:
                    _after_preflight(rig)
                elif sequence.automatic_by:
                    _start_next(rig)
            if _queue_version(rig) != sequence.shown_version:
                refresh(rig)
    except Exception:  # noqa: BLE001  (a thread that is not waited for)
        _log.exception("a bug in the panel: the queue has stopped")


def refresh(rig: Rig) -> QueueView:
    """Show the queue as it is on the disk."""
    sequence = rig.sequence
    sequence.shown_version = _queue_version(rig)
    try:
        items = rig.queue.shown(rig.name)
        is_interrupted = any(item.status == "interrupted" for item in items)
        waiting = (item.entry.id for item in items if item.status == "waiting")
        next_entry, problem = None if is_interrupted else next(waiting, None), sequence.problem
    except RigrunnerError as error:
        items, next_entry, problem = [], None, f"{error.message} ({error.hint})"
    finished = [item for item in items if item.status in _FINISHED]
    left_out = {item.entry.id for item in finished[:-MOST_FINISHED]}
    view = QueueView(
        entries=tuple(_view(rig, item) for item in items if item.entry.id not in left_out),
        left_out=len(left_out),
        next=next_entry,
        starting=sequence.pending.entry if sequence.pending else None,
        automatic_by=sequence.automatic_by,
        problem=problem,
    )
    rig.board.put(queue=view)
    return view


def _queue_version(rig: Rig) -> object:
    """Return a value that changes with the displayed queue; a Stop changes it without a file."""
    sequence = rig.sequence
    changed_ns = rig.queue.changed_ns(rig.name)
    return changed_ns, sequence.automatic_by, sequence.problem, sequence.pending


def _entry(rig: Rig, number: int) -> Entry:
    """Return an entry of this rig's queue; raise UsageError for one of another rig."""
    entry = rig.queue.get(number)
    if entry.station != rig.name:
        message = f"entry {number} is in the queue of {entry.station}, not of {rig.name}"
        raise UsageError(message)
    return entry


def _view(rig: Rig, shown: Shown) -> EntryView:
    entry = shown.entry
    return EntryView(
        **entry.model_dump(
            include={"id", "procedure", "station", "inputs", "realtime", "by", "repeats"}
        ),
        reason=entry.reason or entry.again,
        specimen=entry.specimen,
        run=entry.run,
        status=shown.status,
        outcome=shown.outcome,
        verdict=rig.panel.history.item(entry.run).verdict if shown.status == "done" else "",
    )


def _add(rig: Rig, body: AddEntries, by: str, *, proposed: bool) -> Added:
    procedure, _ = files(rig.panel, body)
    loaded = load_procedure(procedure)
    inputs = loaded.inputs
    common = accepted_inputs(body.inputs, inputs)
    items, invalid = read_list(body.list, inputs) if body.list.strip() else ([], [])
    rows = [item.inputs for item in items] if items or invalid else [{}]
    drafts = [
        _draft(rig, body, {**common, **row}).model_copy(update={"again": body.again.strip()})
        for row in rows
    ]
    new_entries = rig.queue.add(
        drafts,
        by,
        rig.panel.now(),
        procedure_id=loaded.model.id,
        proposed=proposed,
        invalid=invalid,
    )
    refresh(rig)
    return Added(entries=[entry.id for entry in new_entries])


def _draft(rig: Rig, body: AddEntries | StartRun, inputs: dict[str, str]) -> Draft:
    return Draft(
        procedure=body.procedure,
        station=body.station,
        inputs=inputs,
        operator=body.operator.strip(),
        partners=named_runs(rig, body.partners),
        realtime=body.realtime,
    )


def _matching_entry(rig: Rig, body: StartRun) -> Entry:
    """Return the entry that a start names; raise PanelError for another test than the entry's."""
    entry = _entry(rig, body.entry or 0)
    draft = _draft(rig, body, body.inputs)
    pair = (draft.procedure, draft.station, draft.specimen.strip())
    if pair != (entry.procedure, entry.station, entry.specimen):
        message = f"entry {entry.id} is {entry.specimen} in {entry.procedure} on {entry.station}"
        raise PanelError(422, "invalid", message, "start that, or start without the entry")
    return entry


def _start(rig: Rig, entry: Entry, by: str, *, by_itself: bool = False) -> None:
    """Start an entry if the rig passed its preflight just now; else start the preflight."""
    body = _body(entry)
    if entry.state != "waiting":
        raise wrong_state(f"entry {entry.id} is not waiting", "release or repeat it first")
    rig.sequence.problem = ""
    if preflight_passed(rig, body):
        _claim_and_start(rig, entry, by, body)
        return
    rig.sequence.pending = PendingStart(entry.id, by, rig.sequence.stops, by_itself)
    try:
        begin_preflight(rig, StartPreflight(**_pair(entry).model_dump()), by)
    except BaseException:
        rig.sequence.pending = None
        raise
    refresh(rig)


def _claim_and_start(rig: Rig, entry: Entry, by: str, body: StartRun) -> None:
    """Mark an entry as started, on the disk, and start its run."""
    sequence, stops = rig.sequence, rig.sequence.stops
    if rig.desk.is_busy:
        raise wrong_state("the rig is in use", "wait until it ends, or abort it")
    with ExitStack() as claim:
        claim.enter_context(rig.queue.started(entry.id, by))
        try:
            start_job(rig, "run", body, by, body.inputs, entry=entry.id)
        except Exception as error:
            rig.queue.give_back(entry.id, str(error))
            refresh(rig)
            raise
        sequence.entry, sequence.entry_lock = entry.id, claim.pop_all()
    if sequence.stops != stops:  # pressed while the process was started
        rig.desk.stop(by, "stop button")
    refresh(rig)


def _finish_entry(rig: Rig) -> None:
    """Release the lock of the entry whose run has ended; hold one whose run never began."""
    sequence = rig.sequence
    if sequence.entry is None:
        return
    finished = rig.board.get("finished")
    reason, run = ("", "") if finished is None else (finished.reason, finished.run)
    entry, sequence.entry = sequence.entry, None
    try:
        with sequence.entry_lock:
            rig.queue.give_back(entry, reason or "the run did not start", run)
    except RigrunnerError as error:  # such as a file that was moved away or damaged meanwhile
        _give_up(rig, error)
    refresh(rig)


def _after_preflight(rig: Rig) -> None:
    sequence = rig.sequence
    pending, sequence.pending = sequence.pending, None
    if pending is None or pending.stops != sequence.stops:
        return
    if pending.by_itself and not sequence.automatic_by:  # switched off meanwhile
        refresh(rig)
        return
    try:
        if pending.by_itself:
            _refuse_alarm(rig)
        entry = rig.queue.get(pending.entry)
        body = _body(entry)
        if not preflight_passed(rig, body):
            raise wrong_state("a check of the preflight failed", "open the entry to see it")
        _claim_and_start(rig, entry, pending.by, body)
    except (PanelError, RigrunnerError) as error:
        _give_up(rig, error)


def _start_next(rig: Rig) -> None:
    """Start the next entry if its procedure, the run before and the alarms allow it."""
    finished = rig.board.get("finished")
    try:
        if finished is not None and (finished.outcome not in CONCLUDED or finished.error):
            raise wrong_state("the previous run was not completed")
        _refuse_alarm(rig)
        entry = rig.queue.next(rig.name)
        if entry is None:
            return
        procedure, _ = files(rig.panel, _pair(entry))
        if load_procedure(procedure).model.automatic_start:
            _start(rig, entry, rig.sequence.automatic_by, by_itself=True)
    except (PanelError, RigrunnerError) as error:
        _give_up(rig, error)


def _refuse_alarm(rig: Rig) -> None:
    if any(alarm.active or alarm.until_end for alarm in rig.board.get("alarms")):
        raise wrong_state("an alarm is active")


def _give_up(rig: Rig, error: PanelError | RigrunnerError) -> None:
    """Show why nothing starts, and switch the automatic start off."""
    view = error.view if isinstance(error, PanelError) else error
    rig.sequence.problem = "; ".join(text for text in (view.message, view.hint) if text)
    rig.sequence.automatic_by = ""
    refresh(rig)


def _pair(entry: Entry) -> Pair:
    return Pair(procedure=entry.procedure, station=entry.station)


def _body(entry: Entry) -> StartRun:
    try:
        return StartRun(
            procedure=entry.procedure,
            station=entry.station,
            inputs=entry.inputs,
            operator=entry.operator,
            partners=dict(entry.partners),
            realtime=entry.realtime,
            entry=entry.id,
        )
    except ValueError as error:
        raise UsageError(f"entry {entry.id} of the queue cannot be run: {error}") from error
