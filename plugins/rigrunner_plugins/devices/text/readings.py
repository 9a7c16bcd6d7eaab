"""Readings that are no number, in a text that an instrument sent."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, Annotated, Self

from pydantic import Field, model_validator

from rigrunner.api import DeviceRejectedError
from rigrunner_plugins.devices.declared import DeclaredReading
from rigrunner_plugins.devices.text.numbers import excerpt
from rigrunner_plugins.devices.text.patterns import Regex, fits

if TYPE_CHECKING:
    from rigrunner.api.readings import Reading

_LONGEST = 1000
"""Characters of a text: what is longer is no line, but a dump of something."""
_MOST = 100_000
"""Numbers of an array: it is kept whole in the row of a table, where samples do not belong."""


class ReadingInText(DeclaredReading):
    """Where a reading stands in what the instrument sends; by itself it is all of it."""

    pattern: Regex = ""
    """A regular expression whose one group is the reading."""
    yes: Regex = "1|ON|on|TRUE|true|YES|yes"
    """For a boolean: regular expression for the whole text of a yes."""
    no: Regex = "0|OFF|off|FALSE|false|NO|no"
    """For a boolean: regular expression for the whole text of a no."""
    separator: Annotated[str, Field(min_length=1)] = ","
    """For an array: separator of the numbers; a blank matches any number of blanks."""

    @model_validator(mode="after")
    def _has_one_group(self) -> Self:
        if self.pattern and re.compile(self.pattern).groups != 1:
            raise ValueError(
                f"pattern '{self.pattern}' needs one group, in round brackets, around the reading"
            )
        return self

    def reading_in(self, text: str, what: str) -> Reading:
        """Return the reading; raise DeviceRejectedError, whose message begins with `what`."""
        place = text.strip()
        if self.pattern:
            match = re.search(self.pattern, place)
            if match is None or match[1] is None:
                problem = f"which does not fit the pattern '{self.pattern}'"
                raise DeviceRejectedError(f"{what} is {excerpt(text)}, {problem}")
            place = match[1].strip()
        if self.kind == "text":
            if len(place) > _LONGEST or not place.isprintable():
                raise DeviceRejectedError(f"{what} is {excerpt(text)}: no text of one line")
            return place
        return self._yes_or_no(place, what) if self.kind == "boolean" else self._array(place, what)

    def _yes_or_no(self, place: str, what: str) -> bool:
        yes, no = fits(self.yes, place), fits(self.no, place)
        if yes == no:
            raise DeviceRejectedError(
                f"{what} is {excerpt(place)}: {'both' if yes else 'neither'} yes and no",
                hint="`yes` and `no` state the texts",
            )
        return yes

    def _array(self, place: str, what: str) -> tuple[float, ...]:
        parts = place.split(None if self.separator.isspace() else self.separator)
        try:
            numbers = tuple(map(float, parts))
        except ValueError as error:
            raise DeviceRejectedError(f"{what} is {excerpt(place)}: no list of numbers") from error
        if len(numbers) > _MOST or not all(map(math.isfinite, numbers)):
            raise DeviceRejectedError(f"{what} has numbers that are not finite, or over {_MOST:,}")
        return self.to_si(numbers)
