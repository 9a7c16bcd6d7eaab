"""Samples out of a LabVIEW TDMS file, scaled as the file says: what LabVIEW itself would show."""

from __future__ import annotations

import logging
import re
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import (
    Column,
    DataError,
    Location,
    MissingPackageError,
    NotInFileError,
    RigrunnerError,
    find_unit,
)
from rigrunner_plugins.importers.finding import near, numbers

try:
    import nptdms
    from nptdms.log import log_manager

    from rigrunner_plugins.importers.tdms_segments import goes_of, is_number, segment_ends, utc_time
except ImportError as error:
    raise MissingPackageError(
        "TDMS files need the package npTDMS", hint="pip install 'rigrunner[tdms]'"
    ) from error

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from datetime import datetime
    from pathlib import Path

    from rigrunner.api import NoSettings

_SCALE_TYPE = re.compile(r"NI_Scale\[\d+\]_Scale_Type")
_SCALES = {
    *("Linear", "Polynomial", "RTD", "Strain", "Table", "Thermistor", "Thermocouple"),
    *("Add", "Subtract", "AdvancedAPI"),
}
"""The scales that npTDMS applies; with another one it gives the numbers of the converter."""


@dataclass(frozen=True)
class TdmsImporter:
    """Reads TDMS files, in which a recording is a group of channels."""

    settings: NoSettings

    def read(
        self, path: Path, columns: Mapping[str, int | str], group: str
    ) -> Mapping[str, Column]:
        """Return the wanted columns; see `rigrunner.api.importing.Importer`."""
        with _open(path) as (file, ends):
            members = _group(file, group, path)
            channels = {
                wanted: _channel(file, members, str(column), wanted, path)
                for wanted, column in columns.items()
            }
            return {
                wanted: _column(file, channel, path, goes_of(path, ends, channel))
                for wanted, channel in channels.items()
            }


@contextmanager
def _open(path: Path) -> Iterator[tuple[nptdms.TdmsFile, list[int]]]:
    """Give the file, and where its segments end.

    Its index file is ignored, which may be of another recording.
    """
    place, log_level = Location(str(path)), log_manager.log_level
    # npTDMS would write to the terminal: its warnings are raised as errors here.
    log_manager.set_level(logging.CRITICAL)
    try:
        with path.open("rb") as source:
            ends = segment_ends(source, path.stat().st_size, place)
            source.seek(0)
            with nptdms.TdmsFile.open(source) as file:
                yield file, ends
    except RigrunnerError:
        raise
    except OSError as error:
        raise DataError(f"cannot be read: {error.strerror or error}", location=place) from error
    except Exception as error:
        what = f"{type(error).__name__}: {error}"
        raise DataError(f"is damaged or cut short: {what[:120]}", location=place) from error
    finally:
        log_manager.set_level(log_level)


def _group(file: nptdms.TdmsFile, name: str, path: Path) -> nptdms.TdmsGroup:
    groups = {group.name: group for group in file.groups()}
    if name in groups:
        return groups[name]
    if not name and len(groups) == 1:
        return next(iter(groups.values()))
    raise NotInFileError(
        f"there is no group '{name}'" if name else "no group is named, and the file has several",
        location=Location(str(path)),
        hint=near(name, list(groups), "groups"),
    )


def _channel(
    file: nptdms.TdmsFile, group: nptdms.TdmsGroup, name: str, wanted: str, path: Path
) -> nptdms.TdmsChannel:
    channels = {channel.name: channel for channel in group.channels()}
    place, what = Location(str(path)), f"the channel '{group.name}/{name}'"
    if name not in channels:
        raise NotInFileError(
            f"{what} of '{wanted}' is not there",
            wanted=wanted,
            location=place,
            hint=near(name, list(channels), f"channels of '{group.name}'"),
        )
    channel, status = channels[name], file.file_status
    lengths = status.channel_statuses  # of the last segment, which has only these
    if status.incomplete_final_segment and (lengths is None or channel.path in lengths):
        raise DataError(
            f"{what} is cut short: the file ends within its samples",
            location=place,
            hint="was the program that wrote it interrupted, or the copy?",
        )
    return channel


def _column(
    file: nptdms.TdmsFile,
    channel: nptdms.TdmsChannel,
    path: Path,
    goes: tuple[tuple[int, datetime], ...],
) -> Column:
    what = f"the channel '{channel.group_name}/{channel.name}'"
    if scales := _scales(file, channel) - _SCALES:
        raise DataError(
            f"{what} has a scale that is not known: {', '.join(sorted(scales))}",
            location=Location(str(path)),
            hint="write it scaled, or export it as numbers",
        )
    offset_s = channel.properties.get("wf_start_offset")
    return Column(
        numbers(np.asarray(channel[:]), what, path),
        unit=str(channel.properties.get("unit_string", "")),
        interval_s=_interval_s(channel),
        started=goes[0][1] if goes else utc_time(channel.properties.get("wf_start_time")),
        offset_s=float(offset_s) if is_number(offset_s) and not goes else 0.0,
        goes=goes[1:],
    )


def _scales(file: nptdms.TdmsFile, channel: nptdms.TdmsChannel) -> set[str]:
    """Return the types of the scales that apply: of the channel, else of its group or the file."""
    for owner in (channel, file[channel.group_name], file):
        types = {kind for key, kind in owner.properties.items() if _SCALE_TYPE.fullmatch(key)}
        if types and owner.properties.get("NI_Scaling_Status") != "scaled":
            return types
    return set()


def _interval_s(channel: nptdms.TdmsChannel) -> float | None:
    """Return the interval of the samples; None where there is none, as of a spectrum."""
    increment = channel.properties.get("wf_increment")
    x_unit = find_unit(str(channel.properties.get("wf_xunit_string") or "s"))
    if x_unit is None or x_unit.dimension != "time" or not is_number(increment) or increment <= 0:
        return None
    return float(increment) * x_unit.factor
