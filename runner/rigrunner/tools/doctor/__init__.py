"""Check whether this machine is fit to measure; report findings and how to fix them."""

from __future__ import annotations

from rigrunner.tools.doctor.drivers import daqmx, serial_ports, visa
from rigrunner.tools.doctor.finding import Finding, Surroundings
from rigrunner.tools.doctor.installation import extras, packages, plugins, python, station
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
    extras,
    visa,
    daqmx,
    serial_ports,
    station,
    browser,
    editor,
)


def examine(surroundings: Surroundings) -> list[Finding]:
    """Return all findings, in the order in which to fix them; raises nothing."""
    findings: list[Finding] = []
    for check in CHECKS:
        try:
            findings += list(check(surroundings))  # all, or none if it fails on its way
        except Exception as error:  # noqa: BLE001  (a check that fails is a finding)
            name, problem = check.__name__.replace("_", " "), f"{type(error).__name__}: {error}"
            findings.append(Finding(name, "fail", problem, "reinstall Rigrunner"))
    return findings
