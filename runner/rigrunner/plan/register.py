"""Whether the register of instruments names channels that the devices have."""

from __future__ import annotations

from dataclasses import replace
from difflib import get_close_matches
from typing import TYPE_CHECKING

from rigrunner.api.devices import Observing
from rigrunner.api.errors import Problem
from rigrunner.api.member import Member
from rigrunner.station import InconsistentStationError
from rigrunner.yamlfile.document import dotted

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.devices import Device
    from rigrunner.station import LoadedStation


def check_register(station: LoadedStation, devices: Mapping[str, Device]) -> LoadedStation:
    """Return the station; raise InconsistentStationError with every channel that no device has.

    An entry may be of a drive too: then set-points have an uncertainty. In the replacement an entry
    is of the most similar channel, else its missing instrument would be a second problem.
    """
    problems: list[Problem] = []
    instruments = list(station.model.instruments)
    for index, instrument in enumerate(instruments):
        role, name = instrument.channel.role, instrument.channel.name
        device = devices.get(role)
        if device is None:  # a problem of its own
            continue
        names = [info.name for info in device.channels]
        names += [info.name for info in device.drives if info.name not in names]
        if isinstance(device, Observing):
            names += [info.name for info in device.readings]
        if name in names:
            continue
        hint = f"there are: {', '.join(names) or 'none'}"
        if near := get_close_matches(name, names, n=1):
            hint = f"did you mean '{near[0]}'? {hint}"
            channel = Member(role, near[0])
            instruments[index] = instrument.model_copy(update={"channel": channel})
        path = ("instruments", index, "channel")
        message = f"the device in the role '{role}' has no channel '{name}'"
        problems.append(Problem(message, station.document.where(path), dotted(path), hint))
    if problems:
        model = station.model.model_copy(update={"instruments": tuple(instruments)})
        raise InconsistentStationError(problems, replace(station, model=model))
    return station
