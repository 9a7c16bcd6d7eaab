"""The plan of a run, for the screen."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner_panel.view.sections import PlanView, StepView

if TYPE_CHECKING:
    from rigrunner.plan import Plan, PlannedStep


def plan_view(plan: Plan) -> PlanView:
    """Return every step of a plan in words."""
    steps = tuple(_step(index, step) for index, step in enumerate(plan.steps))
    return PlanView(estimated_s=plan.estimated_s, steps=steps)


def _step(index: int, step: PlannedStep) -> StepView:
    action = step.action
    return StepView(
        index=index,
        path=step.path,
        phase=step.phase,
        action=type(action).__name__.lower(),
        text=step.text,
        point=step.points[-1] if step.points else "",
        estimated_s=step.estimated_s,
        frequency_hz=getattr(action, "cycle_frequency_hz", None),
        scan_points=len(action.passes) if action.led and action.rows else 0,
    )
