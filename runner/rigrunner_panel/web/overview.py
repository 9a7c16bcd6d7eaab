"""The overview of all rigs, made from their states at each request."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.queue import SPECIMEN
from rigrunner_panel.view.rigs import RigView

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rigrunner_panel.view.board import Board
    from rigrunner_panel.view.queue import QueueView
    from rigrunner_panel.view.sections import (
        AlarmView,
        Finished,
        JobView,
        PauseView,
        PlanView,
        Progress,
        PromptView,
        StepView,
    )
    from rigrunner_panel.web.panel import Rig


def rig_views(rigs: Iterable[Rig]) -> tuple[RigView, ...]:
    """Return each rig in a few words."""
    return tuple(map(_view, rigs))


def _view(rig: Rig) -> RigView:
    board = rig.board
    job: JobView | None = board.get("job")
    progress: Progress | None = board.get("progress")
    finished: Finished | None = board.get("finished")
    alarms: tuple[AlarmView, ...] = board.get("alarms")
    queue: QueueView = board.get("queue")
    plan: PlanView | None = board.get("plan")
    control, step = board.get("control"), _step(board)
    return RigView(
        station=rig.name,
        title=rig.station.title or rig.name,
        problem=rig.station.problem,
        phase=board.get("phase"),
        asked=board.get("asked"),
        control="" if control is None else control.name,
        kind="" if job is None else job.kind,
        procedure="" if job is None else job.title or job.procedure,
        specimen="" if job is None else job.inputs.get(SPECIMEN, ""),
        run="" if job is None else job.run,
        step=step,
        number=0 if step is None else step.index + 1,
        steps=0 if plan is None else len(plan.steps),
        done_s=0 if progress is None else round(progress.done_s),
        left_s=0 if progress is None else round(progress.left_s),
        waits_for=_waits_for(board),
        alarms=tuple(alarm.text for alarm in alarms if alarm.active),
        outcome="" if finished is None else finished.outcome,
        verdict="" if finished is None else finished.verdict,
        result="" if finished is None else finished.result,
        reason=queue.problem or ("" if finished is None else finished.reason),
        waiting=sum(entry.status == "waiting" for entry in queue.entries),
        next=next((entry.specimen for entry in queue.entries if entry.id == queue.next), ""),
        automatic_by=queue.automatic_by,
    )


def _step(board: Board) -> StepView | None:
    plan: PlanView | None = board.get("plan")
    progress: Progress | None = board.get("progress")
    if plan is None or progress is None or not 0 <= progress.index < len(plan.steps):
        return None
    return plan.steps[progress.index]


def _waits_for(board: Board) -> str:
    prompt: PromptView | None = board.get("prompt")
    pause: PauseView | None = board.get("pause")
    if prompt is not None:
        return prompt.text
    return "" if pause is None else pause.reason or pause.point
