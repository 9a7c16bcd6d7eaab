"""The lab folder with which a laboratory for bearings begins."""

from __future__ import annotations

from rigrunner.api import hookimpl
from rigrunner.api.hooks import LabRecord

PROCEDURES = ("no_load_inertia_sweep", "starting_torque_1000n")


@hookimpl
def rigrunner_labs() -> list[LabRecord]:
    """Return the lab folders that this package brings."""
    return [
        LabRecord(
            name="bearings",
            help="A swing friction tester for bearings, simulated, and a thermometer",
            files="rigrunner_bearings:lab",
            procedures=PROCEDURES,
        )
    ]
