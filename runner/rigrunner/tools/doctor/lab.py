"""A lab's own station: whether its plugins are installed, and accept its settings."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.errors import InvalidFileError, RigrunnerError
from rigrunner.tools.by_hand.station import ready_station
from rigrunner.tools.doctor.finding import Finding

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.tools.doctor.finding import Surroundings

_NAME = "station"


def station(of: Surroundings) -> Iterator[Finding]:
    """Create the devices of the station. No instrument is accessed."""
    if of.station is None:
        yield Finding(_NAME, "ok", "not checked: name one with --station")
        return
    try:
        ready = ready_station(of.station)
    except InvalidFileError as error:
        for each in error.problems:
            fix = each.hint or "'rigrunner check' lists all problems in it"
            where = f"{each.location}: " if each.location else ""
            yield Finding(_NAME, "fail", f"{where}{each.message}", fix)
        return
    except RigrunnerError as error:
        yield Finding(_NAME, "fail", error.message, error.hint or "correct the file")
        return
    roles = ", ".join(ready.devices)
    found = f"{of.station}: its plugins take the settings of {roles}"
    yield Finding(_NAME, "ok", f"{found}; 'rigrunner devices' connects them")
