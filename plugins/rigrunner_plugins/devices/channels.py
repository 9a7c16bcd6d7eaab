"""Channels and drives by their names; those that a device does not have are refused."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

from rigrunner.api import DeviceRejectedError, PluginError

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from rigrunner.api import ChannelInfo, DriveInfo
    from rigrunner.api.devices import ReadingInfo

_T = TypeVar("_T")
_Info = TypeVar("_Info", "ChannelInfo", "DriveInfo", "ReadingInfo")


def check_channels(names: Iterable[str], infos: Sequence[ChannelInfo]) -> None:
    """Raise DeviceRejectedError for the first name that no channel has."""
    by_name = {info.name: info for info in infos}
    for name in names:
        find("channel", name, by_name)


def find(kind: str, name: str, known: Mapping[str, _T]) -> _T:
    """Return what has that name; raise DeviceRejectedError with the names that there are."""
    if name not in known:
        listing = ", ".join(known) or "none"
        raise DeviceRejectedError(f"there is no {kind} '{name}'", hint=f"there are: {listing}")
    return known[name]


def info_of(infos: Iterable[_Info], name: str, absent: str) -> _Info:
    """Return what has that name; raise PluginError that begins with `absent`."""
    by_name = {info.name: info for info in infos}
    if name not in by_name:
        raise PluginError(f"{absent} '{name}'", hint=f"there are: {', '.join(by_name) or 'none'}")
    return by_name[name]
