"""The plan of a run, for the screen."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.member import Member
from rigrunner_panel.view.sections import PlanView, StepView

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.devices import Device
    from rigrunner.plan import Plan, PlannedStep


def plan_view(plan: Plan, devices: Mapping[str, Device]) -> PlanView:
    """Return every step of a plan in words."""
    return PlanView(
        estimated_s=plan.estimated_s,
        steps=tuple(_step(index, step) for index, step in enumerate(plan.steps)),
        drives={
            Member(role, drive.name): drive.long_name
            for role, device in devices.items()
            for drive in device.drives
        },
    )


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
        scan_points=len(action.moves_to) if action.moves and action.rows else 0,
        sets={action.moves: action.moves_to[-1]} if action.moves and action.moves_to else {},
    )
