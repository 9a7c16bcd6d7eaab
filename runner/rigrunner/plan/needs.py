"""What the analysis will need of the recordings, asked before anything is measured."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.coordinates import matches
from rigrunner.api.member import Member
from rigrunner.api.units import unit
from rigrunner.yamlfile.problems import suggestion

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rigrunner.plan.actions import Recorded, Recording
    from rigrunner.plan.draft import Draft
    from rigrunner.procedure import LoadedProcedure
    from rigrunner.station import LoadedStation
    from rigrunner.yamlfile.document import Path
    from rigrunner.yamlfile.problems import Problems


INDEX = "index"
"""The name of a channel of pulses; of all others the unit says what they are."""
ANALYSED_IN = {"torque": "N·m", "angle": "rad", "angular velocity": "rad/s"}
"""The units in which the analysis takes recorded channels, by dimension."""
TORQUE = ANALYSED_IN["torque"]


def chosen(recordings: Iterable[Recorded], procedure: LoadedProcedure) -> list[Recorded]:
    """Return the recordings that the analysis is of."""
    where = procedure.model.torque_analysis.where
    return [each for each in recordings if matches(each.coordinates, where)]


def check_analysis(procedure: LoadedProcedure, draft: Draft, problems: Problems) -> None:
    """Add a problem for all that would keep the analysis from using what is recorded."""
    if not analyses(procedure):
        return
    measures = any(step.action.rows for step in draft.steps)
    if not draft.wanted and not measures:
        message = "there is no recording to analyse"
        at = procedure.model.torque_analysis_at
        problems.add(procedure.document, at, message, "add a record step", key=True)
    for recorded in chosen(draft.recordings, procedure):
        _check_channels(recorded, problems)


def check_motion(procedure: LoadedProcedure, draft: Draft, problems: Problems) -> None:
    """Add a problem for every recording without the cyclic motion that the analysis needs."""
    if not analyses(procedure) or procedure.model.torque_analysis.starts is not None:
        return
    for recorded in chosen(draft.recordings, procedure):
        if not recorded.record.cycle_frequency_hz:
            message = "the analysis needs a cycle frequency, and none is set here"
            hint = "set the drive before"
            problems.add(recorded.document, recorded.path, message, hint, key=True)
        elif Member(recorded.record.role, "frequency") not in recorded.record.setpoints:
            message = f"the analysis needs the set frequency of '{recorded.record.role}' itself"
            hint = f"set {recorded.record.role}.frequency, also where another device drives it"
            problems.add(recorded.document, recorded.path, message, hint, key=True)


def check_rig(
    station: LoadedStation, procedure: LoadedProcedure, draft: Draft, problems: Problems
) -> None:
    """Add a problem for all that the analysis needs to know of the rig, and the station leaves out.

    Swings are read by the law of the crank.
    """
    if not analyses(procedure):
        return
    spec, rig = procedure.model.torque_analysis, station.rig
    needed: dict[str, Path] = {}
    at = procedure.model.torque_analysis_at
    if spec.starts is None and chosen(draft.recordings, procedure):
        needed |= dict.fromkeys(("eccentric", "centre_distance"), at)
    for key, path in needed.items():
        if getattr(rig, key) in (None, ""):
            message = f"the analysis needs the key '{key}' of the rig, which is missing"
            hint = f"it is needed at {procedure.document.where(path, key=True)}"
            problems.add(station.document, ("rig", key), message, hint, key=True)


def check_register(
    station: LoadedStation, procedure: LoadedProcedure, draft: Draft, problems: Problems
) -> None:
    """Add a problem for every torque that is analysed and that the register does not know."""
    if not analyses(procedure):
        return
    for recorded in chosen(draft.recordings, procedure):
        for name in channels_of(recorded.record, "torque"):
            _check_instrument(station, Member(recorded.record.role, name), recorded, problems)


def channels_of(record: Recording, dimension: str) -> list[str]:
    """Return the names of the recorded channels of a dimension, such as 'torque'."""
    return [
        name
        for name in record.channels
        if unit(record.units[Member(record.role, name)]).dimension == dimension
    ]


def motion_channels(record: Recording) -> list[str]:
    """Return the names of the recorded channels that show the crank phase of a swing."""
    return [
        *channels_of(record, "angle"),
        *channels_of(record, "angular velocity"),
        *(name for name in record.channels if name == INDEX),
    ]


def analyses(procedure: LoadedProcedure) -> bool:
    """Say whether a procedure asks for an analysis."""
    spec = procedure.model.torque_analysis
    return bool(spec.fits or spec.compensations or spec.no_load)


def _check_channels(recorded: Recorded, problems: Problems) -> None:
    """Ask for one torque, and for no more than one angle: without any there are fallbacks."""
    record, path = recorded.record, (*recorded.path, "channels")
    for dimension, least, wanted in (
        ("torque", 1, "one channel"),
        ("angle", 0, "at most one channel"),
        ("angular velocity", 0, "at most one channel"),
    ):
        found = channels_of(record, dimension)
        if not least <= len(found) <= 1:
            got = " and ".join(found) or "none"
            message = f"the analysis needs {wanted} of {dimension} in each recording, got {got}"
            problems.add(recorded.document, path, message)
        for name in found:
            given = record.units[Member(record.role, name)]
            if given != ANALYSED_IN[dimension]:
                message = f"the device gives {name} in {given}"
                hint = f"the analysis takes a device whose {dimension} is in "
                problems.add(recorded.document, path, message, hint + ANALYSED_IN[dimension])


def _check_instrument(
    station: LoadedStation, member: str, asked: Recorded, problems: Problems
) -> None:
    register = station.register
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
