"""A station as frozen models: which devices fill the roles, the rig, the instrument register."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field

from rigrunner.api.instruments import RigDescription, TorqueInstrument
from rigrunner.api.settings import ListOf, Settings
from rigrunner.yamlfile.names import Identifier, Name, Text


class DeviceBinding(Settings):
    """A device in a role: what it is for procedures, and the plugin that drives it."""

    type: Text
    plugin: Text
    settings: dict[str, Any] = Field(default_factory=dict)


class Station(Settings):
    """One rig with its devices and instruments."""

    rigrunner: Literal["station/1"]
    id: Identifier
    title: Text
    description: str = ""
    rig: RigDescription
    devices: Annotated[dict[Name, DeviceBinding], Field(min_length=1)]
    instruments: ListOf[TorqueInstrument] = ()
    plugins: Text | None = None
    """The folder of the lab's own plugins, relative to the station file."""
