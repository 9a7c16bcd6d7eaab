"""Refuses channels that a device does not have."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.errors import DeviceRejectedError

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from rigrunner.api.devices import ChannelInfo


def check_channels(wanted: Iterable[str], infos: Sequence[ChannelInfo]) -> None:
    """Raise DeviceRejectedError for the first name that no channel has."""
    known = [info.name for info in infos]
    for name in wanted:
        if name not in known:
            raise DeviceRejectedError(
                f"there is no channel '{name}'", hint=f"there are: {', '.join(known)}"
            )
