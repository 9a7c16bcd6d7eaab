"""What the analysis will need of the recordings, asked before anything is measured."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.quantity import unit
from rigrunner.plan.problems import suggestion

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.plan.actions import Record
    from rigrunner.plan.problems import Problems
    from rigrunner.procedure import LoadedProcedure
    from rigrunner.station import LoadedStation
    from rigrunner.yamlfile.document import Path


def check_analysis(
    procedure: LoadedProcedure,
    recordings: Sequence[tuple[Record, Path]],
    problems: Problems,
    *,
    wanted: int,
) -> None:
    """Add a problem for all that would keep the analysis from using the recordings.

    `wanted` is how many the procedure asks for; those with problems are not in `recordings`.
    """
    if not _analyses(procedure):
        return
    if not wanted:
        message = "there is no recording to analyse"
        problems.add(procedure.document, ("analysis",), message, "add a record step", key=True)
    for record, path in recordings:
        _check_channels(procedure, record, path, problems)


def check_motion(
    procedure: LoadedProcedure, recordings: Sequence[tuple[Record, Path]], problems: Problems
) -> None:
    """Add a problem for every recording without the cyclic motion that the analysis needs."""
    if not _analyses(procedure):
        return
    for record, path in recordings:
        if not record.cycle_frequency_hz:
            message = "the analysis needs a cycle frequency, and none is set here"
            problems.add(procedure.document, path, message, "set the drive before", key=True)


def check_register(
    procedure: LoadedProcedure,
    station: LoadedStation,
    recordings: Sequence[tuple[Record, Path]],
    problems: Problems,
) -> None:
    """Add a problem for every recorded torque that the instrument register does not know."""
    for record, path in recordings:
        for name in channels_of(record, "torque"):
            _check_instrument(procedure, station, f"{record.role}.{name}", path, problems)


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


def _check_channels(
    procedure: LoadedProcedure, record: Record, path: Path, problems: Problems
) -> None:
    for dimension in ("torque", "angle"):
        found = channels_of(record, dimension)
        if len(found) != 1:
            got = " and ".join(found) or "none"
            message = f"the analysis needs one channel of {dimension} in each recording, got {got}"
            problems.add(procedure.document, (*path, "channels"), message)


def _check_instrument(
    procedure: LoadedProcedure, station: LoadedStation, member: str, path: Path, problems: Problems
) -> None:
    register = station.instruments
    recorded = f"it is recorded at {procedure.document.where(path)}"
    if member not in register:
        message = f"there is no instrument for the channel {member}"
        hint = f"{suggestion(member, register, 'registered')}; {recorded}"
        problems.add(station.document, ("instruments",), message, hint, key=True)
    elif register[member].low_pass is None:
        index = list(register).index(member)
        message = f"the low_pass of the instrument for {member} is missing"
        hint = f"the filter shapes the torque at the reversals; {recorded}"
        problems.add(station.document, ("instruments", index), message, hint)
