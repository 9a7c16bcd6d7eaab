"""The device old_device: put your instrument's words in the place of these."""

from rigrunner.api.devices import ChannelInfo, DriveInfo
from rigrunner.api.hooks import DeviceRecord, hookimpl
from rigrunner.api.lines import LineDriver, LineSettings

api_version = 1


class SimulatedOldDevice:
    """Answers as the instrument does, to try a procedure without it."""

    force = 0.0

    def answer(self, request: str) -> str:
        """Return the line that answers a line."""
        if request.startswith("FORCE "):
            self.force = float(request.removeprefix("FORCE "))
        return "Example,Model 1,SIM-1,1.0" if request == "*IDN?" else f"{self.force}"


class OldDevice(LineDriver):
    """What is asked of the instrument; all values are in the unit that is declared."""

    channels = (ChannelInfo("force", "N", "Force"),)
    drives = (DriveInfo("force", "N", "Force", minimum=0.0, maximum=1000.0),)
    simulator = SimulatedOldDevice

    def get(self, channel: str) -> float:
        """Return the present value of a channel."""
        return float(self.ask(f"{channel.upper()}?"))

    def put(self, drive: str, value: float) -> None:
        """Give a drive a new set-point."""
        self.ask(f"{drive.upper()} {value}")


@hookimpl
def rigrunner_devices() -> list[DeviceRecord]:
    """Tell Rigrunner what is in this file."""
    return [
        DeviceRecord(
            name="old_device",
            help="Old device, by lines of text",
            settings=LineSettings,
            factory=OldDevice,
            wired=True,
            trial={"simulated": True},
            absent={"simulated": False, "address": "192.0.2.1:5025"},
        )
    ]
