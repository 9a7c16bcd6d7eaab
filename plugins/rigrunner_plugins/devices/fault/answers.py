"""What goes wrong with a call as a whole: no answer in time, a late one, none at all, a refusal."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api import DeviceLostError, DeviceRejectedError, DeviceTimeoutError

if TYPE_CHECKING:
    from rigrunner.api import Clock
    from rigrunner_plugins.devices.fault.settings import Call, FaultSettings

HINT = "a fault that the station injects"


def affect(fault: FaultSettings, call: Call, clock: Clock) -> None:
    """Let a call fail or wait by the fault; do nothing if the fault is of another kind."""
    if fault.kind in ("timeout", "late"):
        clock.sleep(fault.extent_si)
    if fault.kind == "timeout":
        message = f"'{call}' was not answered within {fault.extent_si:g} s"
        raise DeviceTimeoutError(message, hint=HINT)
    if fault.kind == "lost":
        raise DeviceLostError(f"the connection broke in '{call}'", hint=HINT)
    if fault.kind == "rejected":
        raise DeviceRejectedError(f"'{call}' was refused", hint=HINT)
