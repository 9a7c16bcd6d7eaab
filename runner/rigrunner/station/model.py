"""A station as frozen models: which devices fill the roles, the rig, the instrument register."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field

from rigrunner.api.instruments import Instrument
from rigrunner.api.settings import ListOf, PlainText, Settings, YesNo
from rigrunner.station.safety import Safety
from rigrunner.yamlfile.names import Identifier, Name, Text


class DeviceBinding(Settings):
    """A device in a role: what it is for procedures, and the plugin that drives it."""

    type: Text
    """What the device is for procedures, such as swing_tester."""
    plugin: Annotated[Text, Field(json_schema_extra={"x-plugin": "device"})]
    """The plugin that drives it."""
    settings: dict[str, Any] = Field(default_factory=dict)
    """What the plugin is told."""
    shared: YesNo = False
    """Whether a run on another station of this machine may reach the same instrument meanwhile: a
    room's thermometer, or a PLC of two rigs whose drives are not the same."""


class ListenerBinding(Settings):
    """A plugin that is told the events of each run."""

    plugin: Annotated[Text, Field(json_schema_extra={"x-plugin": "event_sink"})]
    """The listener's plugin."""
    settings: dict[str, Any] = Field(default_factory=dict)
    """What the plugin is told."""


class Durability(Settings):
    """When what was recorded is on the disk, beyond what the operating system has at once.

    A program that is killed loses nothing of it either way; a machine that loses its power does.
    """

    sync: Literal["each_second", "each_measurement"] = "each_second"
    """`each_measurement`: what a `measure` or a point of a `scan` found is on the disk before the
    next step or point, which costs as long as the disk takes. Recordings are, either way."""


class Station(Settings):
    """One rig with its devices and instruments."""

    rigrunner: Literal["station/1"]
    """What this file is, and its version of the language."""
    id: Identifier
    """How runs name it."""
    title: Text
    """One line for lists and for the report."""
    description: PlainText = ""
    """In as many words as it takes."""
    rig: Annotated[dict[str, Any], Field(json_schema_extra={"x-rig": True})] = Field(
        default_factory=dict
    )
    """What is known of the rig itself, by the keys that plugins declare; left out, nothing."""
    devices: Annotated[dict[Name, DeviceBinding], Field(min_length=1)]
    """Role to the device that fills it."""
    instruments: ListOf[Instrument] = ()
    """The register: what is known of each transducer and of any other instrument."""
    safety: Safety = Field(default_factory=Safety)
    """How the rig is made safe, and what keeps it so."""
    durability: Durability = Field(default_factory=Durability)
    """What of a run survives if the power fails."""
    listeners: ListOf[ListenerBinding] = ()
    """Plugins that are told what happens in each run, and cannot stop it."""
    plugins: Text | None = None
    """The folder of the lab's own plugins, relative to the station file."""
