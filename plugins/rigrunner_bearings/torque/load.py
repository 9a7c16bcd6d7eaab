"""How well the load is known: by the register's instrument for it, or as the station says."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api import Member
from rigrunner_bearings.api.rig import rig_of
from rigrunner_bearings.torque.channels import role_of

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rigrunner.api import RunData
    from rigrunner_bearings.api.rig import RigDescription


def with_known_load(run: RunData, torque: str, loads_n: Iterable[float]) -> RigDescription:
    """Return the run's rig with the load's relative limit of error at the least of its loads.

    That of the instrument for the load of the device that has the torque channel; as the station
    states it where the register has none, or does not say how accurate it is.
    """
    least = min((load for load in loads_n if load > 0), default=0.0)
    channel = Member(role_of(torque), "load")
    cell = run.instruments.get(channel)
    limit = None if cell is None or least == 0 else cell.limit_of_error(least)
    if limit is None:
        return rig_of(run)
    return rig_of(run).model_copy(update={"load_tolerance": limit / least})
