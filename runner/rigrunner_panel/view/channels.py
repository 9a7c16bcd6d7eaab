"""The channels of a planned rig, with the limits within which they are watched."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING

from rigrunner.api.member import Member
from rigrunner.run.calibration import entering_channels
from rigrunner_panel.view.sections import ChannelView, Reading

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.run.prepare import Planned


def channels_of(planned: Planned) -> Iterator[ChannelView]:
    """Yield each channel of each device, with the limits of the interlocks that watch it.

    Those whose values enter the result come first.
    """
    interlocks = {interlock.member: interlock for interlock in planned.plan.interlocks}
    infos = {
        Member(role, info.name): info
        for role, device in planned.devices.items()
        for info in device.channels
    }
    entering = [name for name in entering_channels(planned) if name in infos]
    for name in dict.fromkeys((*entering, *infos)):
        info, interlock = infos[name], interlocks.get(name)
        unit = Reading.of(0.0, info.unit, info.shown_in).shown_in
        yield ChannelView(
            name=name,
            long_name=info.long_name,
            si=info.unit,
            unit=unit,
            lower=None if interlock is None else _limit(interlock.minimum, info.unit, unit),
            upper=None if interlock is None else _limit(interlock.maximum, info.unit, unit),
        )


def _limit(value: float, si: str, unit: str) -> float | None:
    return Reading.of(value, si, unit).shown if isfinite(value) else None
