"""What the analysis will need of the recordings, asked before anything is measured."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.quantity import unit
from rigrunner.plan.actions import Measure, Scan
from rigrunner.yamlfile.problems import suggestion

if TYPE_CHECKING:
    from rigrunner.plan.actions import Record
    from rigrunner.plan.draft import Draft, Recorded
    from rigrunner.procedure import LoadedProcedure
    from rigrunner.station import LoadedStation
    from rigrunner.yamlfile.problems import Problems


def check_analysis(procedure: LoadedProcedure, draft: Draft, problems: Problems) -> None:
    """Add a problem for all that would keep the analysis from using what is recorded."""
    if not _analyses(procedure):
        return
    measures = any(isinstance(step.action, (Measure, Scan)) for step in draft.steps)
    if not draft.wanted and not measures:
        message = "there is no recording to analyse"
        problems.add(procedure.document, ("analysis",), message, "add a record step", key=True)
    for recorded in draft.recordings:
        _check_channels(recorded, problems)


def check_motion(procedure: LoadedProcedure, draft: Draft, problems: Problems) -> None:
    """Add a problem for every recording without the cyclic motion that the analysis needs."""
    if not _analyses(procedure) or procedure.model.analysis.starts is not None:
        return
    for recorded in draft.recordings:
        if not recorded.record.cycle_frequency_hz:
            message = "the analysis needs a cycle frequency, and none is set here"
            hint = "set the drive before"
            problems.add(recorded.document, recorded.path, message, hint, key=True)


def check_register(station: LoadedStation, draft: Draft, problems: Problems) -> None:
    """Add a problem for every recorded torque that the instrument register does not know."""
    for recorded in draft.recordings:
        for name in channels_of(recorded.record, "torque"):
            _check_instrument(station, f"{recorded.record.role}.{name}", recorded, problems)


def channels_of(record: Record, dimension: str) -> list[str]:
    """Return the names of the recorded channels of a dimension, such as 'torque'."""
    return [
        name
        for name in record.channels
        if unit(record.units[f"{record.role}.{name}"]).dimension == dimension
    ]


def _analyses(procedure: LoadedProcedure) -> bool:
    spec = procedure.model.analysis
    return bool(spec.fits or spec.compensations or spec.no_load)


def _check_channels(recorded: Recorded, problems: Problems) -> None:
    """Ask for one torque, and for no more than one angle: without any there are fallbacks."""
    for dimension, least, wanted in (
        ("torque", 1, "one channel"),
        ("angle", 0, "at most one channel"),
    ):
        found = channels_of(recorded.record, dimension)
        if not least <= len(found) <= 1:
            got = " and ".join(found) or "none"
            message = f"the analysis needs {wanted} of {dimension} in each recording, got {got}"
            problems.add(recorded.document, (*recorded.path, "channels"), message)


def _check_instrument(
    station: LoadedStation, member: str, asked: Recorded, problems: Problems
) -> None:
    register = station.instruments
    recorded = f"it is recorded at {asked.document.where(asked.path)}"
    if member not in register:
        message = f"there is no instrument for the channel {member}"
        hint = f"{suggestion(member, register, 'registered')}; {recorded}"
        problems.add(station.document, ("instruments",), message, hint, key=True)
    elif register[member].low_pass is None:
        index = list(register).index(member)
        message = f"the low_pass of the instrument for {member} is missing"
        hint = f"the filter shapes the torque at the reversals; {recorded}"
        problems.add(station.document, ("instruments", index), message, hint)
