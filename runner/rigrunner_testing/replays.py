"""A device that replays a tape, for the tests of a plugin's author."""

from __future__ import annotations

from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rigrunner.api.devices import DeviceContext
from rigrunner.api.errors import UsageError
from rigrunner.clock import SimulatedClock
from rigrunner.registry import load_registry
from rigrunner.tape import ReplayedTape

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rigrunner.api.devices import Device
    from rigrunner.registry import Registry
    from rigrunner.tape import TapeManifest


@contextmanager
def replayed(
    plugin: str,
    settings: Mapping[str, Any],
    tape: Path | str,
    role: str = "",
    registry: Registry | None = None,
) -> Iterator[Device]:
    """Yield a device whose exchanges come from a tape that `--record` made.

    For a `wired` plugin the author's own code runs on them; its requests must be those of the tape,
    in order, or DeviceRejectedError reports the first difference. The rest of the tape is no error.
    The role, or 'role/part', is needed only if the plugin has none or several on the tape. Raises
    DataError without a tape, UsageError for a role that is not on it.
    """
    with ReplayedTape(Path(tape)) as played:
        name = role or _role(plugin, played.manifest)
        if name.partition("/")[0] not in played.manifest.devices:
            raise UsageError(
                f"the tape {tape} has no device in the role '{name}'",
                hint=f"it has: {', '.join(played.manifest.devices)}",
            )
        context = DeviceContext(name, SimulatedClock(played.manifest.began_utc), Path())
        yield (registry or load_registry()).make_device(plugin, settings, context, played)


def _role(plugin: str, manifest: TapeManifest) -> str:
    roles = [role for role, device in manifest.devices.items() if device.plugin == plugin]
    if len(roles) == 1:
        return roles[0]
    drives = ", ".join(f"{device.plugin} {role}" for role, device in manifest.devices.items())
    raise UsageError(
        f"'{plugin}' drives {len(roles)} devices on the tape: say which role",
        hint=f"it has: {drives}",
    )
