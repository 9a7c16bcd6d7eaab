"""Samples out of a LabVIEW TDMS file, scaled as the file says: what LabVIEW itself would show."""

from __future__ import annotations

import logging
import struct
from contextlib import contextmanager
from datetime import UTC, datetime
from typing import TYPE_CHECKING

import nptdms
import numpy as np
from nptdms.log import log_manager

from rigrunner.api.errors import DataError, Location, RigrunnerError
from rigrunner.api.importing import Column, NotInFileError
from rigrunner_plugins.importers.finding import near, numbers

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path
    from typing import BinaryIO, TypeGuard

_BEGINS = b"TDSm"
_INDEX_BEGINS = b"TDSh"
_LEAD_IN = 28
_BIG_ENDIAN = 1 << 6
_NEVER = datetime(1904, 1, 2, tzinfo=UTC)
"""Up to here a start is LabVIEW's zero: nobody entered one."""


class TdmsImporter:
    """Reads TDMS files, in which a recording is a group of channels."""

    def read(
        self, path: Path, columns: Mapping[str, int | str], group: str
    ) -> Mapping[str, Column]:
        """Return the wanted columns; see `rigrunner.api.importing.Importer`."""
        with _opened(path) as file:
            members = _group(file, group, path)
            return {
                wanted: _column(file, members, str(column), wanted, path)
                for wanted, column in columns.items()
            }


@contextmanager
def _opened(path: Path) -> Iterator[nptdms.TdmsFile]:
    """Give the file; its index file is not looked at, which may be of another recording."""
    place = Location(str(path))
    try:
        with path.open("rb") as source:
            _refuse_other_kinds(source.read(len(_BEGINS)), place)
            refuse_torn(source, path.stat().st_size, place)
            with _silent(), nptdms.TdmsFile.open(source) as file:
                yield file
    except RigrunnerError:
        raise
    except OSError as error:
        raise DataError(f"cannot be read: {error.strerror or error}", location=place) from error
    except Exception as error:
        what = f"{type(error).__name__}: {error}"
        raise DataError(f"is damaged or cut short: {what[:120]}", location=place) from error


@contextmanager
def _silent() -> Iterator[None]:
    """Keep npTDMS from writing to the terminal: what it warns of is told as an error."""
    before = log_manager.log_level
    log_manager.set_level(logging.CRITICAL)
    try:
        yield
    finally:
        log_manager.set_level(before)


def refuse_torn(source: BinaryIO, size: int, place: Location) -> None:
    """Raise DataError where the file ends within what says which samples follow.

    npTDMS leaves such a segment out without a word, and nobody would miss its samples. Each segment
    begins with a lead-in: tag, contents, version, and the distances from its end to the next
    segment and to its own samples (NI, TDMS File Format Internal Structure).
    """
    at = 0
    while at < size:
        source.seek(at)
        lead_in = source.read(_LEAD_IN)
        if len(lead_in) < _LEAD_IN or lead_in[: len(_BEGINS)] != _BEGINS:
            break
        order = ">" if lead_in[4] & _BIG_ENDIAN else "<"
        to_next, to_samples = struct.unpack(f"{order}QQ", lead_in[12:])
        if at + _LEAD_IN + to_samples > size:
            break
        at += _LEAD_IN + to_next
    else:
        source.seek(0)
        return
    raise DataError(
        f"is cut short or damaged in the segment that begins at byte {at}",
        location=place,
        hint="was the program that wrote it broken off, or the copy?",
    )


def _refuse_other_kinds(begins: bytes, place: Location) -> None:
    if begins != _BEGINS:
        hint = "this is the index of one" if begins == _INDEX_BEGINS else ""
        raise DataError("is not a TDMS file", location=place, hint=hint)


def _group(file: nptdms.TdmsFile, name: str, path: Path) -> nptdms.TdmsGroup:
    groups = {each.name: each for each in file.groups()}
    if name in groups:
        return groups[name]
    if not name and len(groups) == 1:
        return next(iter(groups.values()))
    raise NotInFileError(
        f"there is no group '{name}'" if name else "no group is named, and the file has several",
        location=Location(str(path)),
        hint=near(name, list(groups), "groups"),
    )


def _column(
    file: nptdms.TdmsFile, group: nptdms.TdmsGroup, name: str, wanted: str, path: Path
) -> Column:
    channels = {each.name: each for each in group.channels()}
    place, what = Location(str(path)), f"the channel '{group.name}/{name}'"
    if name not in channels:
        raise NotInFileError(
            f"{what} of '{wanted}' is not there",
            wanted=wanted,
            location=place,
            hint=near(name, list(channels), f"channels of '{group.name}'"),
        )
    channel = channels[name]
    if _is_cut(file, channel.path):
        raise DataError(
            f"{what} is cut short: the file ends within its samples",
            location=place,
            hint="was the program that wrote it broken off, or the copy?",
        )
    interval_s = channel.properties.get("wf_increment")
    offset_s = channel.properties.get("wf_start_offset")
    return Column(
        numbers(np.asarray(channel[:]), what, path),
        unit=str(channel.properties.get("unit_string", "")),
        interval_s=float(interval_s) if _is_number(interval_s) and interval_s > 0 else None,
        started=_started(channel.properties.get("wf_start_time")),
        offset_s=float(offset_s) if _is_number(offset_s) else 0.0,
    )


def _is_cut(file: nptdms.TdmsFile, channel: str) -> bool:
    """Say whether the last segment of the file is cut, and has samples of the channel."""
    status = file.file_status
    if not status.incomplete_final_segment:
        return False
    lengths = status.channel_statuses
    return lengths is None or channel in lengths


def _is_number(value: object) -> TypeGuard[float]:
    return isinstance(value, (int, float, np.number)) and bool(np.isfinite(value))


def _started(time: object) -> datetime | None:
    """Return a time stamp of the file, which is in UTC."""
    if not isinstance(time, np.datetime64) or np.isnat(time):
        return None
    found = time.astype("datetime64[us]").astype(datetime)
    if not isinstance(found, datetime):  # a date that Python does not know
        return None
    started = found.replace(tzinfo=UTC)
    return started if started > _NEVER else None
