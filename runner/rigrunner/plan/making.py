"""From procedure and station to a plan, or all that keeps them from being one."""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING

from pydantic_core import to_json

from rigrunner.plan.actions import Plan, PlannedStep
from rigrunner.plan.bench import Bench, check_roles
from rigrunner.plan.builder import build
from rigrunner.plan.interlocks import plan_interlocks
from rigrunner.plan.safety import check_order, drive_rules
from rigrunner.yamlfile.problems import Problems

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rigrunner.api.devices import Device
    from rigrunner.plan.actions import Interlock
    from rigrunner.procedure import LoadedProcedure
    from rigrunner.station import LoadedStation

_NAMES = ("path", *(field.name for field in fields(PlannedStep) if field.name != "within"))
_PIECE = 1000
"""Steps of which the text is made at once: what it is made of is larger."""


def make_plan(
    procedure: LoadedProcedure, station: LoadedStation, devices: Mapping[str, Device]
) -> Plan:
    """Return every single action of the procedure on the station; nothing is connected.

    `devices` are the station's by role. Raises InvalidFileError with all problems, each with its
    place in the procedure or the station.
    """
    problems = Problems()
    other_types = check_roles(procedure, station, problems)
    check_order(station, devices, problems)
    rules = drive_rules(station, devices, problems)
    fitting = {role: device for role, device in devices.items() if role not in other_types}
    draft = build(procedure, Bench(procedure, fitting, problems, rules), problems)
    interlocks = plan_interlocks(procedure, station, devices, problems)
    problems.stop_if_any()
    return Plan(tuple(draft.steps), interlocks, tuple(draft.recordings))


def check_station(station: LoadedStation, devices: Mapping[str, Device]) -> tuple[Interlock, ...]:
    """Return the interlocks of a station that is used by hand.

    Raises InvalidFileError with all that is wrong in what it says of safety.
    """
    problems = Problems()
    check_order(station, devices, problems)
    drive_rules(station, devices, problems)
    interlocks = plan_interlocks(None, station, devices, problems)
    problems.stop_if_any()
    return interlocks


def plan_text(plan: Plan) -> Iterator[bytes]:
    """Yield the plan as JSON, for the run file, in parts: one object a step, SI units."""
    yield b"["
    for first in range(0, len(plan.steps), _PIECE):
        steps = [
            {"do": type(step.action).__name__, **{name: getattr(step, name) for name in _NAMES}}
            for step in plan.steps[first : first + _PIECE]
        ]
        yield (b"," if first else b"") + to_json(steps, indent=1)[1:-2]
    yield b"\n]" if plan.steps else b"]"
