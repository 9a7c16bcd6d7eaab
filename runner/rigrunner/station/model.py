"""A station as frozen models: the devices in roles, the rig, the register of instruments."""

from __future__ import annotations

import re
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field

from rigrunner.api.instruments import Instrument
from rigrunner.api.member import NAME, Member
from rigrunner.api.names import Identifier, Name, Text
from rigrunner.api.settings import ListOf, PlainText, PositiveDuration, Settings, YesNo
from rigrunner.interlock import Interlock
from rigrunner.station.limits import Combination, DriveLimits


def _place_in_order(text: str) -> Member | str:
    try:
        return text if re.fullmatch(NAME, text) else Member.parse(text)
    except ValueError:
        message = f"'{text[:40]}' is neither a role nor role.drive, such as tester.load"
        raise ValueError(message) from None


class Waiting(Settings):
    """Time limits of a device that may block, beyond the time that its drives need."""

    connect: PositiveDuration = 10.0
    """Time until it has identified itself."""
    answer: PositiveDuration = 10.0
    """Time until any other call returns; then the call is abandoned and the rig is made safe."""


class Safety(Settings):
    """How the rig is made and kept safe."""

    guardian: YesNo = True
    """Whether a second process makes the rig safe if the process of a run dies or hangs."""
    order: ListOf[Annotated[str, AfterValidator(_place_in_order)]] = ()
    """Drives (role.drive) and whole devices (role) that are made safe first, one after another. All
    other devices follow at the same time."""
    patience: Waiting = Field(default_factory=Waiting)
    drives: dict[Member, DriveLimits] = Field(default_factory=dict)
    """Tighter limits of drives than those of their devices, by role.drive."""
    combinations: ListOf[Combination] = ()
    """Drives that must not all be high at the same time."""
    interlocks: ListOf[Interlock] = ()
    """Conditions that are monitored throughout every run."""


class DeviceBinding(Settings):
    """The device in a role."""

    type: Text
    """Type of the device for procedures, such as climate_chamber."""
    plugin: Annotated[Text, Field(json_schema_extra={"x-plugin": "device"})]
    """The plugin of the device."""
    settings: dict[str, Any] = Field(default_factory=dict)
    """Settings of the plugin."""
    shared: YesNo = False
    """Whether a run on another station of this machine may use the same instrument at the same
    time: the thermometer of a room, or a PLC of two rigs with different drives."""


class ListenerBinding(Settings):
    """A plugin that gets the events of each run."""

    plugin: Annotated[Text, Field(json_schema_extra={"x-plugin": "event_sink"})]
    """The plugin of the listener."""
    settings: dict[str, Any] = Field(default_factory=dict)
    """Settings of the plugin."""


class Durability(Settings):
    """When recorded data are on the disk, not only with the operating system.

    A killed program loses nothing in either case; a power failure may lose data.
    """

    sync: Literal["each_second", "each_measurement"] = "each_second"
    """`each_measurement`: the values of a `measure` or of a point of a `scan` are on the disk
    before the next step or point, which takes the time of the disk. Recordings always are."""


class Station(Settings):
    """One rig with its devices and instruments."""

    rigrunner: Literal["station/1"]
    """Type and version of this file."""
    id: Identifier
    """Name of the station in runs."""
    title: Text
    """One line for lists and for the report."""
    description: PlainText = ""
    """Any further description."""
    rig: Annotated[dict[str, Any], Field(json_schema_extra={"x-rig": True})] = Field(
        default_factory=dict
    )
    """Data of the rig, under keys that plugins declare."""
    devices: Annotated[dict[Name, DeviceBinding], Field(min_length=1)]
    """The device in each role."""
    instruments: ListOf[Instrument] = ()
    """The register of instruments, by channel."""
    safety: Safety = Field(default_factory=Safety)
    """How the rig is made and kept safe."""
    durability: Durability = Field(default_factory=Durability)
    """What survives a power failure."""
    listeners: ListOf[ListenerBinding] = ()
    """Plugins that get the events of each run, and cannot stop it."""
    plugins: Text | None = None
    """Folder of the plugins of the lab, relative to the station file."""
