"""The device that plays back recordings: its set-points choose the file."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import (
    ChannelInfo,
    DeviceLostError,
    DeviceNotFoundError,
    DeviceRejectedError,
    DriveInfo,
    Identity,
    find_unit,
    unit,
)
from rigrunner.api.units import si_symbol
from rigrunner_plugins.devices.channels import check_channels
from rigrunner_plugins.devices.drives import Drives
from rigrunner_plugins.devices.pacing import paced_blocks
from rigrunner_plugins.devices.replay.manifest import load_manifest
from rigrunner_plugins.importers.csv_file import read_csv

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rigrunner.api import Array, Block, Column, DeviceContext, StopToken
    from rigrunner_plugins.devices.replay.manifest import Manifest, RecordingEntry
    from rigrunner_plugins.devices.replay.settings import ReplaySettings

HDF5_SUFFIXES = {".h5", ".hdf5", ".hdf", ".nxs"}


class Replay:
    """Recordings in a folder as a Device with drives and streams; knows no truth."""

    non_blocking = True

    def __init__(self, settings: ReplaySettings, context: DeviceContext) -> None:
        self._settings = settings
        self._clock = context.clock
        self._folder = context.folder / settings.folder
        frequency = DriveInfo(
            name="frequency",
            unit="Hz",
            long_name="Swing frequency",
            minimum=0.0,
            maximum=settings.max_frequency,
            sets_cycle_frequency=True,
        )
        load = DriveInfo(
            name="load", unit="N", long_name="Radial load", minimum=0.0, maximum=settings.max_load
        )
        self._drives = Drives((frequency, load), context.clock)
        self._manifest: Manifest | None = None
        self._last: tuple[RecordingEntry, Mapping[str, Array]] | None = None

    @property
    def channels(self) -> Sequence[ChannelInfo]:
        """The channels of the settings, in SI units."""
        return tuple(
            ChannelInfo(
                name,
                si_symbol(unit(channel.unit).dimension),
                channel.title or name,
                shown_in=channel.unit,
            )
            for name, channel in self._settings.channels.items()
        )

    @property
    def drives(self) -> Sequence[DriveInfo]:
        """Frequency and load; they move nothing but the choice of the recording."""
        return self._drives.infos

    @property
    def sample_rate_hz(self) -> float:
        """Samples per second and channel."""
        return self._settings.rate

    def connect(self, timeout_s: float) -> Identity:  # noqa: ARG002  (files answer at once)
        """Read the manifest; raise DeviceNotFoundError, or InvalidFileError for a bad one."""
        if not self._folder.is_dir():
            raise DeviceNotFoundError(f"there is no folder of recordings at {self._folder}")
        self._manifest = load_manifest(
            self._folder, self._settings.manifest, self._settings.channels
        )
        return Identity("Rigrunner", "replay", self._settings.folder)

    def close(self) -> None:
        """Forget the manifest and what was read."""
        self._manifest = self._last = None

    def make_safe(self) -> Mapping[str, float]:
        """Set frequency and load to zero; nothing moves."""
        return self._drives.make_safe()

    def set(self, drive: str, value: float) -> None:
        """Choose a set-point; whether there is a recording shows once it is to be played."""
        self._connected()
        self._drives.set(drive, value)

    def read_back(self, drive: str) -> float:
        """Return the set-point."""
        self._connected()
        return self._drives.read_back(drive)

    def read(self, channels: Sequence[str]) -> Mapping[str, float]:
        """Return the first sample of each channel at the present set-points."""
        samples = self._samples(channels, 1)
        return {name: float(values[0]) for name, values in samples.items()}

    def stream(
        self, channels: Sequence[str], duration_s: float, stop: StopToken
    ) -> Iterator[Block]:
        """Yield the start of the recording at the present set-points, at the clock's pace."""
        samples = self._samples(channels, round(duration_s * self.sample_rate_hz))
        return paced_blocks(samples, self.sample_rate_hz, self._clock, stop)

    def _samples(self, channels: Sequence[str], count: int) -> Mapping[str, Array]:
        check_channels(channels, self.channels)
        entry = self._entry()
        recorded = self._recorded(entry)
        return {name: _samples_of(name, entry, recorded, count) for name in channels}

    def _entry(self) -> RecordingEntry:
        """Return the recording at the present set-points."""
        manifest, set_points = self._connected(), self._drives.actual
        for entry in manifest.recordings:
            if entry.is_at(set_points["frequency"], set_points["load"]):
                return entry
        raise DeviceRejectedError(
            f"no recording of {set_points['frequency']:g} Hz at {set_points['load']:g} N"
            f" in {self._folder}",
            hint=f"there are: {', '.join(str(entry) for entry in manifest.recordings)}",
        )

    def _recorded(self, entry: RecordingEntry) -> Mapping[str, Array]:
        """Return the columns of an entry's file in SI units; the last file is remembered."""
        if entry.file is None:
            return {}
        if self._last is None or self._last[0] is not entry:
            path = self._folder / entry.file
            channels = self._settings.channels
            columns = {
                name: channel.column
                for name, channel in channels.items()
                if channel.column is not None and name not in entry.values
            }
            raw: Mapping[str, Column]
            if path.suffix.lower() in HDF5_SUFFIXES:
                from rigrunner_plugins.importers.hdf5_file import read_hdf5  # noqa: PLC0415  (h5py)

                raw = read_hdf5(path, columns, entry.group)
            else:
                raw = read_csv(path, columns, self._settings.table)
            values = {}
            for name, column in raw.items():
                unit_, stated_unit = unit(channels[name].unit), find_unit(column.unit)
                if stated_unit is not None and stated_unit.symbol != unit_.symbol:
                    raise DeviceRejectedError(
                        f"'{entry.file}' states '{column.unit}' for '{name}', not '{unit_.symbol}'",
                        hint="correct the unit of the channel in the settings",
                    )
                values[name] = column.values * unit_.factor + unit_.offset
            self._last = entry, values
        return self._last[1]

    def _connected(self) -> Manifest:
        if self._manifest is None:
            raise DeviceLostError("the replay is not connected")
        return self._manifest


def _samples_of(
    name: str, entry: RecordingEntry, recorded: Mapping[str, Array], count: int
) -> Array:
    if name in entry.values:
        return np.full(count, entry.values[name].si)
    if name not in recorded:
        raise DeviceRejectedError(
            f"the recording of {entry} has no channel '{name}'",
            hint="give it a column in the settings, or a value in the manifest",
        )
    if len(recorded[name]) < count:
        raise DeviceRejectedError(
            f"'{entry.file}', the recording of {entry}, has {len(recorded[name])} samples,"
            f" but {count} are asked for"
        )
    return recorded[name][:count]
