"""The number in the text that an instrument sent: its place, its unit, and overloads."""

from __future__ import annotations

import re
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from rigrunner.api import DeviceRejectedError, Settings
from rigrunner_plugins.devices.text.patterns import Regex

OVERLOAD = 9.89e37
"""SCPI sends 9.9E37 for infinity and 9.91E37 for 'not a number' (SCPI-99, vol. 1, 7.2.1.4 and
7.2.1.5); a little less here, since a 32-bit number rounds it."""
# Balances pad between sign and digits, as in "-  100.00 g".
_DECIMAL = re.compile(
    r"([+-]?)\s*((?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)(.*)", re.DOTALL
)
_HEXADECIMAL = re.compile(r"()(?:0[xX]|#[hH])?([0-9A-Fa-f]+)(.*)", re.DOTALL)
"""As IEEE 488.2-1992, 8.7.5, writes it, #H1F, or as programmers do, 0x1F."""
_LONGEST = 60
"""Characters of an answer that a message shows."""


class NumberInText(Settings):
    """The place of the number in the text of the instrument; if omitted, the whole text."""

    pattern: Regex = ""
    """A regular expression whose one group is the number."""
    field: Annotated[int, Field(ge=1)] | None = None
    """Which field of a list it is, counted from 1."""
    separator: Annotated[str, Field(min_length=1)] = ","
    """Separator of the fields; a blank matches any number of blanks."""
    number: Literal["decimal", "hexadecimal"] = "decimal"
    """Notation of the number."""
    overload: Annotated[float, Field(gt=0, strict=False)] = OVERLOAD
    """Least number, of either sign, that means overload; in SCPI 9.9E37."""
    unit_in_answer: str = ""
    """The unit after the number, which is checked; if omitted, nothing may follow."""

    @model_validator(mode="after")
    def _says_one_place(self) -> Self:
        if self.pattern and self.field is not None:
            raise ValueError("pattern and field are two places; expected one of them")
        if self.pattern and re.compile(self.pattern).groups != 1:
            raise ValueError(
                f"pattern '{self.pattern}' needs one group, in round brackets, around the number"
            )
        return self

    def number_in(self, text: str, what: str) -> float:
        """Return the number; raise DeviceRejectedError, whose message begins with `what`."""
        place = self._place(text.strip(), what)
        shape = _DECIMAL if self.number == "decimal" else _HEXADECIMAL
        match = shape.fullmatch(place)
        if match is None:
            raise DeviceRejectedError(
                f"{what} is {excerpt(text)}: {excerpt(place)} is not a {self.number} number",
                hint="select the number with `pattern` or `field`",
            )
        sign, digits, rest = match.groups()
        if rest.strip() != self.unit_in_answer:
            expected = f"'{self.unit_in_answer}'" if self.unit_in_answer else "nothing more"
            raise DeviceRejectedError(
                f"{what} is {excerpt(text)}: after the number is {excerpt(rest.strip())}, expected"
                f" {expected}",
                hint="a unit? set the instrument to the station's, or change `unit_in_answer`"
                " together with `unit`",
            )
        if self.number == "hexadecimal":
            return float(int(digits, 16))
        number = float(sign + digits)
        # Not `>=`: a NaN compares with nothing, and is refused too.
        if not abs(number) < self.overload:
            raise DeviceRejectedError(
                f"{what} is {number:g}: the instrument reports overload or 'not a number'",
                hint="choose a larger range, or check the wiring",
            )
        return number

    def _place(self, text: str, what: str) -> str:
        if self.pattern:
            match = re.search(self.pattern, text)
            if match is None or match[1] is None:
                raise DeviceRejectedError(
                    f"{what} is {excerpt(text)}, which does not fit the pattern '{self.pattern}'"
                )
            return match[1].strip()
        if self.field is None:
            return text
        fields = text.split(None if self.separator.isspace() else self.separator)
        if self.field > len(fields):
            raise DeviceRejectedError(
                f"{what} is {excerpt(text)}: it has {len(fields)} fields, no {self.field}"
            )
        return fields[self.field - 1].strip()


def excerpt(text: str) -> str:
    """Return an answer as a message may show it: on one line, and not endless."""
    cut = text if len(text) <= _LONGEST else f"{text[:_LONGEST]}…"
    return repr(cut)
