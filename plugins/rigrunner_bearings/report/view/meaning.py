"""Sentences on the meaning of a torque and its conditions, by what was measured."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner_bearings.api.measurand import Validity
from rigrunner_reports.numbers import fixed

if TYPE_CHECKING:
    from rigrunner_bearings.api.torque import TorqueDetails

RIG_ITSELF = (
    "The torque that the rig itself puts on the sensor: the inertia of all behind it and the "
    "friction of the supports, with whatever friction the bearing has without load. It is what a "
    "loaded run is compensated with; no bearing is judged by it."
)
SENTENCES = {
    Validity.AT_REVERSAL: (
        "The value is the load-induced starting torque at the reversal of an oscillation: the "
        "largest friction torque just after the swing turns round, mean of both directions. It is "
        "not the breakaway torque from rest after a dwell, and not the total torque."
    ),
    Validity.ZERO_LOAD_FRICTION: (
        "Friction that the bearing has at zero load is in the no-load run too, where it cannot be "
        "distinguished from the friction of the supports: it is not part of the value."
    ),
    Validity.SUPPORT_FRICTION: (
        "The value is conditional on the friction of the supports not growing with load beyond the "
        "stated allowance{allowance}. Such growth looks exactly like friction of the "
        "bearing; no method here can see it."
    ),
    Validity.PROPORTIONAL: (
        "Friction is taken to be proportional to load: an error of the load is counted as the same "
        "relative error of the value."
    ),
    Validity.OTHER_LIMITS: (
        "Limits for the no-load breakaway torque of a bearing (as in AS14101) are limits of "
        "another quantity."
    ),
}


def meaning(torque: TorqueDetails) -> tuple[str, ...]:
    """Return the sentences on a result; none for an unknown measurand."""
    if not torque.compensations:
        return (RIG_ITSELF,)
    if torque.kind is None:
        return ()
    allowed = torque.support_allowance
    allowance = "" if allowed is None else f" of {fixed(allowed[0], 1)} {allowed[1]}"
    return tuple(SENTENCES[code].format(allowance=allowance) for code in torque.kind.validity)
