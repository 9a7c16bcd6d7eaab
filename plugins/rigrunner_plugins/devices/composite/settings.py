"""Settings of the composite: which parts it has, and what its channels and drives are of them."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Annotated, Self

from pydantic import AfterValidator, Field, model_validator

from rigrunner.api.settings import MadeOfOthers, Settings, WrapperSettings
from rigrunner_plugins.devices.declared import QuantityName  # noqa: TC001  (pydantic reads it)

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

_PLACE = r"[a-z][a-z0-9_]*\.[a-z][a-z0-9_]*"


def _place(text: str) -> str:
    if not re.fullmatch(_PLACE, text):
        raise ValueError(f"'{text[:40]}' is not of the form part.name, such as daq.torque")
    return text


Place = Annotated[str, AfterValidator(_place), Field(json_schema_extra={"pattern": f"^{_PLACE}$"})]
"""A channel or a drive of a part: `part.name`."""


class PartSettings(WrapperSettings):
    """One instrument of the role: the plugin that drives it, and what that is told."""


class DriveSource(Settings):
    """A drive that one part sets and another one measures."""

    set: Place
    """The drive that is set, such as press.load."""
    read_back: Place
    """The channel that says where it stands, such as cell.force."""


class CompositeSettings(MadeOfOthers):
    """One role from several instruments."""

    parts: Annotated[dict[QuantityName, PartSettings], Field(min_length=1)]
    """The instruments by name; they are connected in this order."""
    channels: dict[QuantityName, Place] = Field(default_factory=dict)
    """Each channel of the role, and of which part it is: torque: daq.torque."""
    drives: dict[QuantityName, Place | DriveSource] = Field(default_factory=dict)
    """Each drive of the role, and which part's it is; parts are made safe in this order."""

    def others(self) -> Mapping[tuple[str, ...], WrapperSettings]:
        """Return the parts."""
        return {("parts", name): part for name, part in self.parts.items()}

    def source(self, channel: str) -> tuple[WrapperSettings, str] | None:
        """Return the part that gives a channel."""
        if channel not in self.channels:
            return None
        part, name = split(self.channels[channel])
        return self.parts[part], name

    @model_validator(mode="after")
    def _names_its_parts(self) -> Self:
        for what, place in self._places():
            if split(place)[0] not in self.parts:
                known = ", ".join(self.parts)
                raise ValueError(f"{what}: '{place}' is of no part; the parts are: {known}")
        return self

    def _places(self) -> Iterator[tuple[str, str]]:
        for name, place in self.channels.items():
            yield f"channel {name}", place
        for name, source in self.drives.items():
            if isinstance(source, DriveSource):
                yield f"drive {name}", source.set
                yield f"drive {name}", source.read_back
            else:
                yield f"drive {name}", source


def split(place: str) -> tuple[str, str]:
    """Return the part and the name of its channel or drive."""
    part, _, name = place.partition(".")
    return part, name
