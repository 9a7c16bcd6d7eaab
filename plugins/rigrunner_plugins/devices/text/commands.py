"""Commands that carry a number."""

from __future__ import annotations

import re
from typing import Annotated

from pydantic import AfterValidator

_VALUE = re.compile(r"\{value(?::([+]?0?[0-9]*(?:\.[0-9]+)?[feEgG]))?\}")
_SAMPLES = "{samples}"


def _has_a_value(text: str) -> str:
    if len(_VALUE.findall(text)) != 1:
        raise ValueError(
            f"'{text}' has to hold the set-point once, as {{value}},"
            " or with a format such as {value:.3f}"
        )
    return text


SettingCommand = Annotated[str, AfterValidator(_has_a_value)]
"""A command with the place of the number, such as 'SOUR:FREQ {value:.3f}'."""


def with_value(command: str, number: float) -> str:
    """Return the command with the number in its place; by itself with 12 digits."""
    return _VALUE.sub(lambda match: _formatted(match, number), command)


def as_sent(command: str, number: float) -> float:
    """Return the number that the command has in place of the given one, which it may round."""
    match = _VALUE.search(command)
    return number if match is None else float(_formatted(match, number))


def _formatted(match: re.Match[str], number: float) -> str:
    return format(number, match[1] or ".12g")


def with_samples(command: str, samples: int) -> str:
    """Return the command with a number of samples in its place, if it has one."""
    return command.replace(_SAMPLES, str(samples))


def has_samples(command: str) -> bool:
    """Return whether a command holds the number of samples."""
    return _SAMPLES in command
