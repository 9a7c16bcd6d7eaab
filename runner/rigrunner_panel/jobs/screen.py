"""The panel in place of a terminal: the questions and outputs of a job."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner_panel.process.person import PanelAnswers, PanelPauses, PanelPerson
from rigrunner_panel.process.watched import WatchedChannels
from rigrunner_panel.view.channels import channels_of
from rigrunner_panel.view.plan import plan_view
from rigrunner_panel.view.sections import AnalysingView

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from rigrunner.plan import Plan
    from rigrunner.run.prepare import Planned
    from rigrunner_panel.process.link import Link
    from rigrunner_panel.process.messages import Job


class Screen:
    """The screens of a job that runs, or that a person controls manually."""

    def __init__(self, job: Job, link: Link, planned: Planned) -> None:
        operator = job.view.operator
        self._job = job
        self._link = link
        self._planned = planned
        self.watched = WatchedChannels(link.sender.send_unless_behind, planned.devices)
        self.person = PanelPerson(link.sender, planned.clock, operator)
        self.answers = PanelAnswers(link, operator, self.watched)
        self.pauses = PanelPauses(link, self.watched)

    def begin(self, plan: Plan, partners: Mapping[str, Path]) -> None:
        """Show what is about to run."""
        names = tuple(path.name for path in partners.values())
        update = {"title": self._planned.procedure.model.title, "partners": names}
        self._link.show(
            job=self._job.view.model_copy(update=update),
            plan=plan_view(plan, self._planned.devices),
            channels=tuple(channels_of(self._planned)),
        )

    def progress(self, what: str, done: int, of: int) -> None:
        """Show how far the analysis is."""
        self._link.show(analysing=AnalysingView(what=what, done=done, of=of))
