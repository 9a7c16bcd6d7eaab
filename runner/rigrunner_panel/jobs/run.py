"""A run, as the command line would do it, with the panel in the place of the terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.queue import Queue
from rigrunner.run.following import following
from rigrunner.run.inputs import answer_inputs, with_operator
from rigrunner.run.noload import no_load_for
from rigrunner.run.planning import planned_run
from rigrunner.run.record import execute
from rigrunner.tools.by_hand.settling import settle_left
from rigrunner_panel.jobs.overriding import overrides_of
from rigrunner_panel.process.news import Analysing, Ended, LiveNow, Planned
from rigrunner_panel.process.person import PanelAnswers, PanelPauses, PanelPerson
from rigrunner_panel.process.watched import WatchedChannels
from rigrunner_panel.view.channels import channels_of
from rigrunner_panel.view.of_plan import plan_view
from rigrunner_panel.view.of_result import finished_view, live_view

if TYPE_CHECKING:
    from rigrunner_panel.process.link import Link
    from rigrunner_panel.process.orders import Job


def run(job: Job, link: Link) -> Ended:
    """Do the run; raise what keeps it from starting."""
    planned = planned_run(job.procedure, job.station, realtime=job.realtime)
    person = PanelPerson(link.outbox, planned.clock, job.operator)
    settle_left(job.station, person)
    overrides = tuple(overrides_of(planned, job))
    no_load = no_load_for(planned, job.runs, job.no_load)
    title = planned.procedure.model.title
    channels = tuple(channels_of(planned))
    link.send(Planned(plan_view(planned.plan), no_load.name if no_load else "", title, channels))
    watched = WatchedChannels(link.outbox.send_unless_behind, planned.devices)
    queue = Queue(job.runs)
    entry = None if job.entry is None else queue.get(job.entry)
    answers = PanelAnswers(link.send, link.inbox, link.switch, job.operator, watched)
    given = with_operator(job.inputs, job.operator or None, planned.procedure)
    with following(planned, lambda found, *, is_whole: link.send(LiveNow(found))) as live:  # noqa: ARG005  (a screen is told both)
        finished = execute(
            planned,
            runs=job.runs,
            inputs=answer_inputs(planned.procedure, given, answers),
            no_load=no_load,
            answers=answers,
            stop=link.switch,
            listeners=[
                link.switch,
                *([queue.began(entry.id)] if entry else []),
                link.outbox,
                *live,
            ],
            operator=job.operator,
            overrides=overrides,
            pauses=PanelPauses(link.send, link.inbox, watched),
            person=person,
            told=entry.told() if entry else (),
            progress=lambda what, done, of: link.send(Analysing(what, done, of)),
        )
    view = None if finished.result is None else live_view(finished.result, final=True)
    return Ended(finished_view(finished), view)
