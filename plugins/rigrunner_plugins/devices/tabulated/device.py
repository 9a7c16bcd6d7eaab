"""Gives at each set-point the values that a table has there, and nothing in between."""

from __future__ import annotations

from math import isclose
from typing import TYPE_CHECKING

from rigrunner.api import ChannelInfo, DeviceLostError, DeviceRejectedError, DriveInfo, Identity
from rigrunner.api.units import from_si
from rigrunner_plugins.devices.channels import check_channels
from rigrunner_plugins.devices.drives import Drives

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigrunner.api import DeviceContext
    from rigrunner_plugins.devices.tabulated.settings import Row, TabulatedSettings

MOST_LISTED = 6
"""Rows that an error names."""
SAME = 1e-9
"""Relative difference within which a set-point is that of a row: the rounding of units."""


class Tabulated:
    """A table as a device: its set-points are drives, its other columns can be read."""

    non_blocking = True

    def __init__(self, settings: TabulatedSettings, context: DeviceContext) -> None:
        self._settings = settings
        self._drives = Drives(
            [_drive(settings, name) for name in settings.set_points], context.clock
        )
        self._connected = False

    @property
    def channels(self) -> Sequence[ChannelInfo]:
        """The columns that are no set-points."""
        table = self._settings
        return [
            ChannelInfo(name, table.unit(name), name.capitalize(), shown_in=table.written_in(name))
            for name in table.channels
        ]

    @property
    def drives(self) -> Sequence[DriveInfo]:
        """The set-points, each from 0 (not of a temperature) or its least to its greatest value."""
        return self._drives.infos

    def connect(self, timeout_s: float) -> Identity:  # noqa: ARG002  (it answers at once)
        """Name the table."""
        self._connected = True
        return Identity("a table", self._settings.title, "", simulated=True)

    def close(self) -> None:
        """Give no more values."""
        self._connected = False

    def make_safe(self) -> Mapping[str, float]:
        """Set all set-points to zero, a temperature to its least."""
        return self._drives.make_safe()

    def set(self, drive: str, value: float) -> None:
        """Go to a set-point."""
        self._need_connection()
        self._drives.set(drive, value)

    def read_back(self, drive: str) -> float:
        """Return the set-point."""
        self._need_connection()
        return self._drives.read_back(drive)

    def read(self, channels: Sequence[str]) -> Mapping[str, float]:
        """Return the row's values; raise DeviceRejectedError where the table has no row."""
        self._need_connection()
        check_channels(channels, self.channels)
        row = self._row(self._drives.actual)
        if row is None:
            raise self._no_row(self._drives.actual)
        return {name: row[name].si for name in channels}

    def unreadable_at(self, set_points: Mapping[str, float]) -> DeviceRejectedError | None:
        """Return the error of a place that has no row."""
        return None if self._row(set_points) else self._no_row(set_points)

    def _row(self, set_points: Mapping[str, float]) -> Row | None:
        values = [set_points[name] for name in self._settings.set_points]
        for row in self._settings.rows:
            row_values = self._settings.place(row)
            if all(isclose(a, b, rel_tol=SAME) for a, b in zip(row_values, values, strict=True)):
                return row
        return None

    def _no_row(self, set_points: Mapping[str, float]) -> DeviceRejectedError:
        names, rows = self._settings.set_points, self._settings.rows
        units = {name: rows[0][name].unit.symbol for name in names}
        at = ", ".join(
            f"{name} {from_si(set_points[name], units[name]):.6g} {units[name]}" for name in names
        )
        places = [", ".join(f"{name} {row[name]}" for name in names) for row in rows[:MOST_LISTED]]
        more = f"; and {len(rows) - MOST_LISTED} more" if len(rows) > MOST_LISTED else ""
        return DeviceRejectedError(
            f"the table has no row for {at}", hint=f"it has rows for {'; '.join(places)}{more}"
        )

    def _need_connection(self) -> None:
        if not self._connected:
            raise DeviceLostError("the table is not connected")


def _drive(settings: TabulatedSettings, name: str) -> DriveInfo:
    values = [row[name].si for row in settings.rows]
    # Nothing rests at the zero of temperature.
    safe_value = min(values) if settings.unit(name) == "K" else 0.0
    return DriveInfo(
        name=name,
        unit=settings.unit(name),
        long_name=name.capitalize(),
        minimum=min(safe_value, *values),
        maximum=max(safe_value, *values),
        safe_value=safe_value,
        sets_cycle_frequency=name == settings.cycle_frequency,
    )
