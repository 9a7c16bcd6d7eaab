"""Check whether this machine is fit to measure; report findings and how to fix them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.tools.doctor.drivers import daqmx, serial_ports, visa
from rigrunner.tools.doctor.extras import each_extra
from rigrunner.tools.doctor.finding import Finding, Surroundings
from rigrunner.tools.doctor.installation import packages, plugins, python
from rigrunner.tools.doctor.lab import station
from rigrunner.tools.doctor.machine import (
    browser,
    clock,
    disk,
    editor,
    fonts,
    hdf5,
    runs_folder,
    text,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

__all__ = ["Finding", "Surroundings", "examine"]

CHECKS = (
    python,
    packages,
    plugins,
    clock,
    runs_folder,
    disk,
    hdf5,
    fonts,
    text,
    each_extra,
    visa,
    daqmx,
    serial_ports,
    station,
    browser,
    editor,
)


def examine(surroundings: Surroundings) -> list[Finding]:
    """Return all findings, in the order in which to fix them; raises nothing."""
    return [finding for check in CHECKS for finding in _findings(check, surroundings)]


def _findings(
    check: Callable[[Surroundings], Iterator[Finding]], of: Surroundings
) -> list[Finding]:
    try:
        return list(check(of))
    except Exception as error:  # noqa: BLE001  (what is broken here is what is looked for)
        name = check.__name__.replace("_", " ")
        return [Finding(name, "fail", f"{type(error).__name__}: {error}", "reinstall Rigrunner")]
