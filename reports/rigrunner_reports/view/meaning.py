"""What the number means, and on what it is conditional."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner_reports.numbers import fixed

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rigrunner.api.results import Result

ALLOWANCE = "support_load_dependence"
RIG_ITSELF = (
    "The torque that the rig itself puts on the sensor: the inertia of all behind it and the "
    "friction of the supports, with whatever friction the bearing has without load. It is what a "
    "loaded run is compensated with; no bearing is judged by it."
)


def meaning(result: Result) -> tuple[str, ...]:
    """Return sentences; none of a measurand of which nothing is known here."""
    if "starting torque" in result.measurand.lower():
        return tuple(_starting_torque(result))
    if not result.compensations:
        return (RIG_ITSELF,)
    return ()


def _starting_torque(result: Result) -> Iterator[str]:
    yield (
        "The value is the load-induced starting torque at the reversal of an oscillation: the "
        "largest friction torque just after the swing turns round, mean of both directions. It is "
        "not the breakaway torque from rest after a dwell, and not the total torque."
    )
    yield (
        "Friction that the bearing has at zero load is in the no-load run too, where it cannot be "
        "told from the friction of the supports: it is not part of the value."
    )
    yield (
        "The value is conditional on the friction of the supports not growing with load beyond the "
        f"stated allowance{_allowance(result)}. Such growth looks exactly like friction of the "
        "bearing; no method here can see it."
    )
    yield (
        "Limits for the no-load breakaway torque of a bearing (as in AS14101) are limits of "
        "another quantity."
    )


def _allowance(result: Result) -> str:
    compensations = result.settings.get("compensations")
    for each in compensations if isinstance(compensations, list) else []:
        if each.get("name") == result.primary:
            return _percent(each.get("settings", {}))
    return ""


def _percent(settings: Mapping[str, object]) -> str:
    value = settings.get(ALLOWANCE)
    return f" of {fixed(100 * value, 1)} %" if isinstance(value, float) else ""
