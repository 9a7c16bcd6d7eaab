"""What counts as an answer: any words, one of some choices, or a number with a unit."""

from __future__ import annotations

import re
from dataclasses import dataclass

from rigrunner.api.errors import RigrunnerError, did_you_mean
from rigrunner.api.quantity import Quantity, parse_quantity
from rigrunner.api.texts import name_of, refused_character
from rigrunner.api.units import unit

_BARE_NUMBER = re.compile(
    r"[+\N{MINUS SIGN}-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?", re.ASCII
)
_LONGEST = 60


class AnswerError(RigrunnerError, ValueError):
    """An answer that the question does not accept."""


@dataclass(frozen=True)
class Expected:
    """What is allowed as the answer to a question; without choices and unit, any words."""

    choices: tuple[str, ...] = ()
    unit: str = ""
    minimum: Quantity | None = None
    maximum: Quantity | None = None

    @property
    def words(self) -> str:
        """What is allowed, for the person who is asked; empty where anything is."""
        if self.choices:
            return " / ".join(self.choices)
        allowed = f", {self._range}" if self._range else ""
        return f"in {self.unit}{allowed}" if self.unit else ""

    @property
    def _range(self) -> str:
        if self.minimum is None:
            return "" if self.maximum is None else f"{self.maximum} or less"
        return f"{self.minimum} {'or more' if self.maximum is None else f'to {self.maximum}'}"

    def accept(self, answer: str) -> str:
        """Return the answer as it is put on record; raise AnswerError saying what is allowed.

        A number without a unit is in the unit of the question, which the person sees.
        """
        text = answer.strip()
        match = refused_character(text)
        if match:
            shown = text[:_LONGEST].encode("unicode_escape").decode()
            raise AnswerError(
                f"got '{shown}', expected a text without control characters",
                hint=f"its character {match.start() + 1} is {name_of(match[0])}: type it again",
            )
        for choice in self.choices:
            if choice.casefold() == text.casefold():
                return choice
        if self.choices:
            message = f"got '{text[:_LONGEST]}', expected one of: {', '.join(self.choices)}"
            raise AnswerError(message, hint=did_you_mean(text, self.choices))
        return self._quantity(text) if self.unit else text

    def _quantity(self, text: str) -> str:
        written = f"{text} {self.unit}" if _BARE_NUMBER.fullmatch(text) else text
        try:
            quantity = parse_quantity(written, unit(self.unit).dimension)
        except RigrunnerError as error:
            raise AnswerError(error.message, hint=error.hint) from error
        low = self.minimum is not None and quantity.si < self.minimum.si
        high = self.maximum is not None and quantity.si > self.maximum.si
        if low or high:
            raise AnswerError(f"{quantity} is out of range ({self._range})")
        return str(quantity)
