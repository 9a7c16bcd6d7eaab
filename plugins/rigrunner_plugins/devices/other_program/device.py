"""The device of a rig that another program drives: procedures fit it, but nothing can be run."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api import DeviceNotFoundError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from typing import Never

    from rigrunner.api import Block, ChannelInfo, DeviceContext, DriveInfo, Identity, StopToken
    from rigrunner_plugins.devices.other_program.settings import OtherProgramSettings


class OtherProgram:
    """Says what there is, so that a procedure can be planned and recordings be imported."""

    non_blocking = True

    def __init__(self, settings: OtherProgramSettings, _: DeviceContext) -> None:
        self._settings = settings

    @property
    def channels(self) -> Sequence[ChannelInfo]:
        """What is recorded or read."""
        return [channel.info(name) for name, channel in self._settings.channels.items()]

    @property
    def drives(self) -> Sequence[DriveInfo]:
        """What is set."""
        return [drive.info(name) for name, drive in self._settings.drives.items()]

    @property
    def sample_rate_hz(self) -> float:
        """Samples per second and channel."""
        return self._settings.rate

    def connect(self, timeout_s: float) -> Identity:  # noqa: ARG002  (not used)
        """Raise DeviceNotFoundError: the rig is not Rigrunner's to drive."""
        self._refuse()

    def close(self) -> None:
        """Do nothing: nothing is open."""

    def make_safe(self) -> Mapping[str, float]:
        """Raise DeviceNotFoundError: the rig cannot be reached."""
        self._refuse()

    def set(self, drive: str, value: float) -> None:  # noqa: ARG002  (not used)
        """Raise DeviceNotFoundError."""
        self._refuse()

    def read_back(self, drive: str) -> float:  # noqa: ARG002  (not used)
        """Raise DeviceNotFoundError."""
        self._refuse()

    def read(self, channels: Sequence[str]) -> Mapping[str, float]:  # noqa: ARG002  (not used)
        """Raise DeviceNotFoundError."""
        self._refuse()

    def stream(
        self,
        channels: Sequence[str],  # noqa: ARG002  (not used)
        duration_s: float,  # noqa: ARG002  (not used)
        stop: StopToken,  # noqa: ARG002  (not used)
    ) -> Iterator[Block]:
        """Raise DeviceNotFoundError."""
        self._refuse()

    def _refuse(self) -> Never:
        raise DeviceNotFoundError(
            f"{self._settings.program} controls this rig, not Rigrunner",
            hint="record with that program, and import its files: 'rigrunner import MAPPING'",
        )
