"""A run, as the command line would do it, with the panel in the place of the terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.queue import Queue
from rigrunner.run.following import following
from rigrunner.run.inputs import answer_inputs, with_operator
from rigrunner.run.partners import partners_for
from rigrunner.run.planning import planned_run
from rigrunner.run.record import execute
from rigrunner.tools.by_hand.settling import settle_left
from rigrunner_panel.jobs.overriding import overrides_of
from rigrunner_panel.process.messages import Ended, Found
from rigrunner_panel.process.person import PanelAnswers, PanelPauses, PanelPerson
from rigrunner_panel.process.watched import WatchedChannels
from rigrunner_panel.view.channels import channels_of
from rigrunner_panel.view.of_plan import plan_view
from rigrunner_panel.view.of_result import finished_view, live_view
from rigrunner_panel.view.sections import AnalysingView

if TYPE_CHECKING:
    from rigrunner.api.findings import Findings
    from rigrunner_panel.process.link import Link
    from rigrunner_panel.process.messages import Job


def run(job: Job, link: Link) -> Ended:
    """Do the run; raise what keeps it from starting."""
    operator = job.view.operator
    planned = planned_run(job.procedure, job.station, realtime=job.view.realtime)
    person = PanelPerson(link.sender, planned.clock, operator)
    settle_left(job.station, person)
    overrides = tuple(overrides_of(planned, job))
    partners = partners_for(planned, job.runs, job.partners)
    taken = tuple(each.name for each in partners.values())
    known = {"title": planned.procedure.model.title, "partners": taken}
    link.show(
        job=job.view.model_copy(update=known),
        plan=plan_view(planned.plan),
        channels=tuple(channels_of(planned)),
    )
    watched = WatchedChannels(link.sender.send_unless_behind, planned.devices)
    queue = Queue(job.runs)
    entry = None if job.entry is None else queue.get(job.entry)
    answers = PanelAnswers(link, operator, watched)
    given = with_operator(job.view.inputs, operator or None, planned.procedure)

    def show(found: Findings, *, is_whole: bool) -> None:  # noqa: ARG001  (a screen is told both)
        link.sender.send(Found(found))

    def progress(what: str, done: int, of: int) -> None:
        link.show(analysing=AnalysingView(what=what, done=done, of=of))

    with following(planned, show) as live:
        finished = execute(
            planned,
            runs=job.runs,
            inputs=answer_inputs(planned.procedure, given, answers),
            partners=partners,
            answers=answers,
            stop=link.switch,
            listeners=[
                link.switch,
                *([queue.began(entry.id)] if entry else []),
                link.sender,
                *live,
            ],
            operator=operator,
            overrides=overrides,
            pauses=PanelPauses(link, watched),
            person=person,
            told=entry.told() if entry else (),
            progress=progress,
        )
    view = None if finished.result is None else live_view(finished.result, final=True)
    return Ended(finished_view(finished), view)
