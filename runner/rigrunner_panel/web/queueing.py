"""The queue at the panel: what is asked of it, and when its next run starts."""

from __future__ import annotations

import logging
from contextlib import ExitStack
from typing import TYPE_CHECKING

from rigrunner.api.errors import RigrunnerError, UsageError
from rigrunner.api.events import CONCLUDED
from rigrunner.procedure import load_procedure
from rigrunner.queue import Draft, accepted_inputs, read_list
from rigrunner_panel.errors import PanelError, wrong_state
from rigrunner_panel.sequence import Wanted
from rigrunner_panel.view.queue import EntryView, QueueView
from rigrunner_panel.web.answers import Added, Cleared, Done, Started
from rigrunner_panel.web.choosing import files
from rigrunner_panel.web.requests import Pair, StartPreflight, StartRun
from rigrunner_panel.web.running import begin_preflight, check_inputs, ready_preflight, start_job

if TYPE_CHECKING:
    from rigrunner.queue.entries import Entry
    from rigrunner.queue.store import Shown
    from rigrunner_panel.web.asked import Asked
    from rigrunner_panel.web.panel import Panel
    from rigrunner_panel.web.requests import (
        AddEntries,
        EntryBecause,
        Move,
        OneEntry,
        SetAutomatic,
    )

_log = logging.getLogger("rigrunner.panel")
MOST_OVER = 200
"""Entries that are over and still listed."""
_OVER = ("done", "skipped", "closed")


def queue(panel: Panel, _: Asked) -> QueueView:
    """Return the queue."""
    return refresh(panel)


def add(panel: Panel, asked: Asked) -> Added:
    """Add specimens that wait for their turn."""
    return _add(panel, asked, proposed=False)


def propose(panel: Panel, asked: Asked) -> Added:
    """Add specimens that a person has to release first."""
    return _add(panel, asked, proposed=True)


def move(panel: Panel, asked: Asked) -> Done:
    """Put an entry in front of another one."""
    body: Move = asked.body
    panel.queue.move(body.entry, body.before)
    refresh(panel)
    return Done()


def hold(panel: Panel, asked: Asked) -> Done:
    """Keep an entry back."""
    body: EntryBecause = asked.body
    panel.queue.hold(body.entry, asked.by, body.reason.strip())
    refresh(panel)
    return Done()


def release(panel: Panel, asked: Asked) -> Done:
    """Release an entry that was proposed or held."""
    body: OneEntry = asked.body
    panel.queue.release(body.entry, asked.by)
    refresh(panel)
    return Done()


def skip(panel: Panel, asked: Asked) -> Done:
    """Skip an entry, or close one whose run was interrupted."""
    body: EntryBecause = asked.body
    panel.queue.skip(body.entry, asked.by, body.reason.strip())
    refresh(panel)
    return Done()


def repeat(panel: Panel, asked: Asked) -> Added:
    """Test the specimen of an entry again."""
    body: EntryBecause = asked.body
    made = panel.queue.repeat(body.entry, asked.by, body.reason.strip(), panel.now())
    refresh(panel)
    return Added(entries=[made.id])


def clear(panel: Panel, _: Asked) -> Cleared:
    """Remove the entries that are over."""
    removed = panel.queue.clear()
    refresh(panel)
    return Cleared(removed=removed)


def start(panel: Panel, asked: Asked) -> Done:
    """Start an entry, or the next one that waits, after a preflight."""
    body: OneEntry = asked.body
    with panel.sequence.lock:
        found = panel.queue.next()  # refuses while an interrupted entry asks
        if body.entry:
            found = panel.queue.get(body.entry)
        if found is None:
            raise wrong_state("no entry of the queue waits", "add or release one")
        _start(panel, found, asked.by)
    return Done()


def automatic(panel: Panel, asked: Asked) -> Done:
    """Let runs start by themselves, or not any more."""
    body: SetAutomatic = asked.body
    with panel.sequence.lock:
        panel.sequence.automatic_by = asked.by if body.on else ""
        panel.sequence.problem = ""
    refresh(panel)
    return Done()


def start_run(panel: Panel, asked: Asked) -> Started:
    """Start a run that the preflight lets start; where the rig is in use, queue it."""
    body: StartRun = asked.body
    procedure, _ = files(panel, body)
    check_inputs(procedure, body.inputs)
    with panel.sequence.lock:
        if body.entry is not None:
            _claim_and_start(panel, _matching(panel, body), asked.by, body)
        elif panel.desk.is_busy and panel.board.get("phase") != "checking":
            made = _added(panel, [_draft(body, body.inputs)], asked.by, proposed=False)
            return Started(entry=made.entries[0])
        else:
            start_job(panel, "run", body, asked.by, body.inputs)
    return Started()


def tick(panel: Panel) -> None:
    """Let go of a run that is over, start what waits for its preflight, or what may start."""
    sequence = panel.sequence
    try:
        with sequence.lock:
            if not panel.desk.is_busy:
                _let_go(panel)
                if sequence.wanted is not None:
                    _after_preflight(panel)
                elif sequence.automatic_by:
                    _by_itself(panel)
            if panel.queue.changed_ns() != sequence.seen_ns:
                refresh(panel)
    except Exception:  # noqa: BLE001  (a thread that nobody waits for)
        _log.exception("a bug in the panel: the queue stands still")


def refresh(panel: Panel) -> QueueView:
    """Show the queue as it is on the disk."""
    sequence = panel.sequence
    sequence.seen_ns = panel.queue.changed_ns()
    try:
        shown = panel.queue.shown()
        asks = any(each.status == "interrupted" for each in shown)
        waiting = (each.entry.id for each in shown if each.status == "waiting")
        following, problem = None if asks else next(waiting, None), sequence.problem
    except RigrunnerError as error:
        shown, following, problem = [], None, f"{error.message} ({error.hint})"
    over = [each for each in shown if each.status in _OVER]
    left_out = {each.entry.id for each in over[:-MOST_OVER]}
    view = QueueView(
        entries=tuple(_view(panel, each) for each in shown if each.entry.id not in left_out),
        left_out=len(left_out),
        next=following,
        starting=sequence.wanted.entry if sequence.wanted else None,
        automatic_by=sequence.automatic_by,
        problem=problem,
    )
    panel.board.put(queue=view)
    return view


def _view(panel: Panel, shown: Shown) -> EntryView:
    entry = shown.entry
    return EntryView(
        **entry.model_dump(
            include={"id", "procedure", "station", "inputs", "realtime", "by", "reason", "repeats"}
        ),
        specimen=entry.specimen,
        run=entry.run,
        status=shown.status,
        outcome=shown.outcome,
        verdict=panel.history.item(entry.run).verdict if shown.status == "done" else "",
    )


def _add(panel: Panel, asked: Asked, *, proposed: bool) -> Added:
    body: AddEntries = asked.body
    procedure, _ = files(panel, body)
    inputs = load_procedure(procedure).inputs
    common = accepted_inputs(body.inputs, inputs)
    rows = [item.inputs for item in read_list(body.list, inputs)] if body.list.strip() else [{}]
    drafts = [_draft(body, {**common, **row}) for row in rows]
    return _added(panel, drafts, asked.by, proposed=proposed)


def _added(panel: Panel, drafts: list[Draft], by: str, *, proposed: bool) -> Added:
    made = panel.queue.add(drafts, by, panel.now(), proposed=proposed)
    refresh(panel)
    return Added(entries=[each.id for each in made])


def _draft(body: AddEntries | StartRun, inputs: dict[str, str]) -> Draft:
    return Draft(
        procedure=body.procedure,
        station=body.station,
        inputs=inputs,
        operator=body.operator.strip(),
        partners=dict(body.partners),
        realtime=body.realtime,
    )


def _matching(panel: Panel, body: StartRun) -> Entry:
    """Return the entry that a start names; raise PanelError for another test than the entry's."""
    entry = panel.queue.get(body.entry or 0)
    asked = _draft(body, body.inputs)
    pair = (asked.procedure, asked.station, asked.specimen.strip())
    if pair != (entry.procedure, entry.station, entry.specimen):
        message = f"entry {entry.id} is {entry.specimen} in {entry.procedure} on {entry.station}"
        raise PanelError(422, "invalid", message, "start that, or start without the entry")
    return entry


def _start(panel: Panel, entry: Entry, by: str) -> None:
    """Start an entry if the rig was looked at just now; else look first."""
    body = _body(entry)
    if entry.state != "waiting":
        raise wrong_state(f"entry {entry.id} does not wait", "release or repeat it first")
    panel.sequence.problem = ""
    if ready_preflight(panel, body):
        _claim_and_start(panel, entry, by, body)
        return
    panel.sequence.wanted = Wanted(entry.id, by, panel.sequence.stops)
    try:
        begin_preflight(panel, StartPreflight(**_pair(entry).model_dump()), by)
    except BaseException:
        panel.sequence.wanted = None
        raise
    refresh(panel)


def _claim_and_start(panel: Panel, entry: Entry, by: str, body: StartRun) -> None:
    """Mark an entry as started, on the disk, and start its run."""
    sequence, stops = panel.sequence, panel.sequence.stops
    if panel.desk.is_busy:
        raise wrong_state("the rig is in use", "wait for the end, or abort what goes on")
    with ExitStack() as claim:
        claim.enter_context(panel.queue.started(entry.id, by))
        try:
            start_job(panel, "run", body, by, body.inputs, entry=entry.id)
        except PanelError as error:
            panel.queue.give_back(entry.id, error.view.message)
            refresh(panel)
            raise
        sequence.entry, sequence.held = entry.id, claim.pop_all()
    if sequence.stops != stops:  # pressed while the process was started
        panel.desk.stop(by, "stop button")
    refresh(panel)


def _let_go(panel: Panel) -> None:
    """Let go of the entry whose run is over; one whose run never began is held."""
    sequence = panel.sequence
    if sequence.entry is None:
        return
    finished = panel.board.get("finished")
    why = finished.reason if finished is not None else ""
    panel.queue.give_back(sequence.entry, why or "the run did not begin")
    sequence.held.close()
    sequence.entry = None
    refresh(panel)


def _after_preflight(panel: Panel) -> None:
    sequence = panel.sequence
    wanted, sequence.wanted = sequence.wanted, None
    if wanted is None or wanted.stops != sequence.stops:
        return
    try:
        entry = panel.queue.get(wanted.entry)
        body = _body(entry)
        if not ready_preflight(panel, body):
            raise wrong_state("a check of the preflight failed", "open the entry to see it")
        _claim_and_start(panel, entry, wanted.by, body)
    except (PanelError, RigrunnerError) as error:
        _give_up(panel, error)


def _by_itself(panel: Panel) -> None:
    """Start the next entry if its procedure, the run before and the alarms allow it."""
    finished = panel.board.get("finished")
    try:
        if finished is not None and (finished.outcome not in CONCLUDED or finished.error):
            raise wrong_state("the run before was not completed")
        if any(each.active for each in panel.board.get("alarms")):
            raise wrong_state("an alarm is active")
        entry = panel.queue.next()
        if entry is None:
            return
        procedure, _ = files(panel, _pair(entry))
        if load_procedure(procedure).model.automatic_start:
            _start(panel, entry, panel.sequence.automatic_by)
    except (PanelError, RigrunnerError) as error:
        _give_up(panel, error)


def _give_up(panel: Panel, error: PanelError | RigrunnerError) -> None:
    """Say why nothing starts, and start nothing by itself any more."""
    view = error.view if isinstance(error, PanelError) else error
    panel.sequence.problem = "; ".join(each for each in (view.message, view.hint) if each)
    panel.sequence.automatic_by = ""
    refresh(panel)


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
