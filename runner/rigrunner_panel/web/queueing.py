"""The queue of a rig at the panel: what is asked of it, and when its next run starts."""

from __future__ import annotations

import logging
from contextlib import ExitStack
from typing import TYPE_CHECKING

from rigrunner.api.errors import RigrunnerError, UsageError
from rigrunner.api.events import CONCLUDED
from rigrunner.procedure import load_procedure
from rigrunner.queue import SPECIMEN, Draft, accepted_inputs, read_list, tested_before
from rigrunner_panel.errors import PanelError, wrong_state
from rigrunner_panel.sequence import Wanted
from rigrunner_panel.view.queue import EntryView, QueueView
from rigrunner_panel.web.answers import Added, Cleared, Done, Started
from rigrunner_panel.web.choosing import files
from rigrunner_panel.web.requests import Pair, StartPreflight, StartRun
from rigrunner_panel.web.running import (
    begin_preflight,
    check_inputs,
    named_runs,
    ready_preflight,
    start_job,
)

if TYPE_CHECKING:
    from rigrunner.queue.entries import Entry
    from rigrunner.queue.store import Shown
    from rigrunner_panel.web.asked import Asked
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
MOST_OVER = 200
"""Finished entries that are still listed."""
_OVER = ("done", "skipped", "closed")


def queue(rig: Rig, _: Asked) -> QueueView:
    """Return the queue."""
    return refresh(rig)


def add(rig: Rig, asked: Asked) -> Added:
    """Add specimens that wait for their turn."""
    return _add(rig, asked.body, asked.by, proposed=False)


def propose(rig: Rig, asked: Asked) -> Added:
    """Add specimens that a person has to release first."""
    body: ProposeEntries = asked.body
    by = body.by.strip() or rig.control.holds(asked.client)
    if not by:
        problem = "a proposal needs a name"
        raise PanelError(422, "invalid", problem, "state in 'by' who or which program proposes it")
    return _add(rig, body, by, proposed=True)


def move(rig: Rig, asked: Asked) -> Done:
    """Put an entry in front of another one."""
    body: Move = asked.body
    rig.queue.move(_own(rig, body.entry).id, body.before)
    refresh(rig)
    return Done()


def hold(rig: Rig, asked: Asked) -> Done:
    """Hold an entry."""
    body: EntryBecause = asked.body
    rig.queue.hold(_own(rig, body.entry).id, asked.by, body.reason.strip())
    refresh(rig)
    return Done()


def release(rig: Rig, asked: Asked) -> Done:
    """Release an entry that was proposed or held."""
    body: OneEntry = asked.body
    rig.queue.release(_own(rig, body.entry).id, asked.by)
    refresh(rig)
    return Done()


def skip(rig: Rig, asked: Asked) -> Done:
    """Skip an entry, or close one whose run was interrupted."""
    body: EntryBecause = asked.body
    rig.queue.skip(_own(rig, body.entry).id, asked.by, body.reason.strip())
    refresh(rig)
    return Done()


def repeat(rig: Rig, asked: Asked) -> Added:
    """Test the specimen of an entry again."""
    body: EntryBecause = asked.body
    entry, reason = _own(rig, body.entry), body.reason.strip()
    made = rig.queue.repeat(entry.id, asked.by, reason, rig.panel.now())
    refresh(rig)
    return Added(entries=[made.id])


def clear(rig: Rig, _: Asked) -> Cleared:
    """Remove finished entries."""
    removed = rig.queue.clear(rig.name)
    refresh(rig)
    return Cleared(removed=removed)


def start(rig: Rig, asked: Asked) -> Done:
    """Start an entry, or the next one that waits, after a preflight."""
    body: OneEntry = asked.body
    with rig.sequence.lock:
        found = rig.queue.next(rig.name)  # refuses while an interrupted entry asks
        if body.entry:
            found = _own(rig, body.entry)
        if found is None:
            raise wrong_state("no entry of the queue is waiting", "add or release one")
        _start(rig, found, asked.by)
    return Done()


def automatic(rig: Rig, asked: Asked) -> Done:
    """Let runs start by themselves, or not any more."""
    body: SetAutomatic = asked.body
    with rig.sequence.lock:
        rig.sequence.automatic_by = asked.by if body.on else ""
        rig.sequence.problem = ""
    refresh(rig)
    return Done()


def start_run(rig: Rig, asked: Asked) -> Started:
    """Start a run that the preflight lets start; where the rig is in use, queue it."""
    body: StartRun = asked.body
    procedure, _ = files(rig.panel, body)
    check_inputs(procedure, body.inputs)
    procedure_id, specimen = load_procedure(procedure).model.id, body.inputs.get(SPECIMEN, "")
    notes = tested_before(rig.panel.settings.runs, procedure_id, [specimen])
    note = notes.get(specimen, "")
    with rig.sequence.lock:
        if body.entry is not None:
            _claim_and_start(rig, _matching(rig, body), asked.by, body)
        # A preflight that runs is no reason to queue: until it is done the start is refused.
        elif rig.desk.is_busy and rig.board.get("phase") != "checking":
            (made,) = rig.queue.add([_draft(rig, body, body.inputs)], asked.by, rig.panel.now())
            refresh(rig)
            return Started(entry=made.id, note=note)
        else:
            start_job(rig, "run", body, asked.by, body.inputs)
    return Started(note=note)


def tick(rig: Rig) -> None:
    """Let go of a run that is over, start what waits for its preflight, or what may start."""
    sequence = rig.sequence
    try:
        rig.reread()
        with sequence.lock:
            if not rig.desk.is_busy:
                _let_go(rig)
                if sequence.wanted is not None:
                    _after_preflight(rig)
                elif sequence.automatic_by:
                    _by_itself(rig)
            if _made_of(rig) != sequence.shown:
                refresh(rig)
    except Exception:  # noqa: BLE001  (a thread that is not waited for)
        _log.exception("a bug in the panel: the queue has stopped")


def refresh(rig: Rig) -> QueueView:
    """Show the queue as it is on the disk."""
    sequence = rig.sequence
    sequence.shown = _made_of(rig)
    try:
        shown = rig.queue.shown(rig.name)
        asks = any(each.status == "interrupted" for each in shown)
        waiting = (each.entry.id for each in shown if each.status == "waiting")
        following, problem = None if asks else next(waiting, None), sequence.problem
    except RigrunnerError as error:
        shown, following, problem = [], None, f"{error.message} ({error.hint})"
    over = [each for each in shown if each.status in _OVER]
    left_out = {each.entry.id for each in over[:-MOST_OVER]}
    view = QueueView(
        entries=tuple(_view(rig, each) for each in shown if each.entry.id not in left_out),
        left_out=len(left_out),
        next=following,
        starting=sequence.wanted.entry if sequence.wanted else None,
        automatic_by=sequence.automatic_by,
        problem=problem,
    )
    rig.board.put(queue=view)
    return view


def _made_of(rig: Rig) -> object:
    """Return what the displayed queue is made of; a Stop changes it without waiting for a file."""
    sequence = rig.sequence
    changed_ns = rig.queue.changed_ns(rig.name)
    return changed_ns, sequence.automatic_by, sequence.problem, sequence.wanted


def _own(rig: Rig, number: int) -> Entry:
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
    made = rig.queue.add(
        drafts,
        by,
        rig.panel.now(),
        procedure_id=loaded.model.id,
        proposed=proposed,
        invalid=invalid,
    )
    refresh(rig)
    return Added(entries=[each.id for each in made])


def _draft(rig: Rig, body: AddEntries | StartRun, inputs: dict[str, str]) -> Draft:
    return Draft(
        procedure=body.procedure,
        station=body.station,
        inputs=inputs,
        operator=body.operator.strip(),
        partners=named_runs(rig, body.partners),
        realtime=body.realtime,
    )


def _matching(rig: Rig, body: StartRun) -> Entry:
    """Return the entry that a start names; raise PanelError for another test than the entry's."""
    entry = _own(rig, body.entry or 0)
    asked = _draft(rig, body, body.inputs)
    pair = (asked.procedure, asked.station, asked.specimen.strip())
    if pair != (entry.procedure, entry.station, entry.specimen):
        message = f"entry {entry.id} is {entry.specimen} in {entry.procedure} on {entry.station}"
        raise PanelError(422, "invalid", message, "start that, or start without the entry")
    return entry


def _start(rig: Rig, entry: Entry, by: str, *, by_itself: bool = False) -> None:
    """Start an entry if the rig was looked at just now; else look first."""
    body = _body(entry)
    if entry.state != "waiting":
        raise wrong_state(f"entry {entry.id} is not waiting", "release or repeat it first")
    rig.sequence.problem = ""
    if ready_preflight(rig, body):
        _claim_and_start(rig, entry, by, body)
        return
    rig.sequence.wanted = Wanted(entry.id, by, rig.sequence.stops, by_itself)
    try:
        begin_preflight(rig, StartPreflight(**_pair(entry).model_dump()), by)
    except BaseException:
        rig.sequence.wanted = None
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
        except PanelError as error:
            rig.queue.give_back(entry.id, error.view.message)
            refresh(rig)
            raise
        sequence.entry, sequence.held = entry.id, claim.pop_all()
    if sequence.stops != stops:  # pressed while the process was started
        rig.desk.stop(by, "stop button")
    refresh(rig)


def _let_go(rig: Rig) -> None:
    """Let go of the entry whose run is over; one whose run never began is held."""
    sequence = rig.sequence
    if sequence.entry is None:
        return
    finished = rig.board.get("finished")
    why = finished.reason if finished is not None else ""
    rig.queue.give_back(sequence.entry, why or "the run did not start")
    sequence.held.close()
    sequence.entry = None
    refresh(rig)


def _after_preflight(rig: Rig) -> None:
    sequence = rig.sequence
    wanted, sequence.wanted = sequence.wanted, None
    if wanted is None or wanted.stops != sequence.stops:
        return
    if wanted.by_itself and not sequence.automatic_by:  # switched off meanwhile
        refresh(rig)
        return
    try:
        if wanted.by_itself:
            _refuse_alarm(rig)
        entry = rig.queue.get(wanted.entry)
        body = _body(entry)
        if not ready_preflight(rig, body):
            raise wrong_state("a check of the preflight failed", "open the entry to see it")
        _claim_and_start(rig, entry, wanted.by, body)
    except (PanelError, RigrunnerError) as error:
        _give_up(rig, error)


def _by_itself(rig: Rig) -> None:
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
    if any(each.active or each.until_end for each in rig.board.get("alarms")):
        raise wrong_state("an alarm is active")


def _give_up(rig: Rig, error: PanelError | RigrunnerError) -> None:
    """Say why nothing starts, and start nothing by itself any more."""
    view = error.view if isinstance(error, PanelError) else error
    rig.sequence.problem = "; ".join(each for each in (view.message, view.hint) if each)
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
