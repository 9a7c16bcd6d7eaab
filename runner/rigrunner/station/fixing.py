"""A station with wrong parts replaced, to find further problems.

Checks come in rounds: single values, their consistency, then plugins, devices and the plan. All
problems of a new station are reported at once. The replacements are not used for anything else.
"""

from __future__ import annotations

import re
from copy import deepcopy
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from rigrunner.api.errors import InvalidFileError
from rigrunner.api.instruments import DEFAULT_QUANTITY
from rigrunner.station.model import Station
from rigrunner.yamlfile import validate

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api.errors import Problem
    from rigrunner.yamlfile import Document

_ROUNDS = 3
_ENTRY = re.compile(r"instruments\[(?P<at>\d+)\](?:\.(?P<key>\w+))?")
_PART = re.compile(
    r"(?P<part>rig|safety|listeners|durability|description|plugins)\b\.?(?P<key>\w*)"
)
_ACCURACY = "0 % FS"
_INSTRUMENT: dict[str, Any] = {
    "channel": "nowhere.none",
    "serial": "none",
    "full_scale": "1 N·m",
    "low_pass": {"type": "butterworth", "order": 2, "corner": "1 kHz"},
    "accuracy": _ACCURACY,
}
_OTHER_INSTRUMENT = {key: _INSTRUMENT[key] for key in ("channel", "serial")}
_COMPARED = ("calibrated", "due", "range", "points")
"""Attributes of an instrument that are compared with each other."""


def as_if_fixed(
    document: Document, problems: Sequence[Problem]
) -> tuple[Station | None, list[Problem]]:
    """Return the station with replacements for wrong parts, and further problems in it.

    None if a wrong part has no replacement, such as a device without a plugin.
    """
    data, wrong = deepcopy(document.data), list(problems)
    more: list[Problem] = []
    for _ in range(_ROUNDS):
        if not all(_replace_part(data, problem.field) for problem in wrong):
            return None, more
        try:
            return validate(Station, replace(document, data=data)), more
        except InvalidFileError as error:
            wrong = list(error.problems)
            for problem in wrong:
                entry = _ENTRY.fullmatch(problem.field)
                # A whole entry is inconsistent; single values were checked before.
                is_new = entry is not None and entry["key"] is None
                if is_new and problem not in (*problems, *more):
                    more.append(problem)
    return None, more


def _replace_part(data: Any, field: str) -> bool:
    """Replace a wrong part; return False if there is no replacement."""
    entry = _ENTRY.match(field)
    if entry:
        if entry["key"] == "measures":
            return False  # what else it must have depends on the quantity
        return _replace_in_instrument(data["instruments"], int(entry["at"]), entry["key"])
    part = _PART.match(field)
    if part is None:
        return False
    data.pop(part["part"], None)
    return True


def _replace_in_instrument(instruments: Any, at: int, key: str | None) -> bool:
    entry = instruments[at]
    if not isinstance(entry, dict):
        instruments[at] = dict(_INSTRUMENT)
    elif key is None:
        for attribute in _COMPARED:
            entry.pop(attribute, None)
        if entry.get("measures", DEFAULT_QUANTITY) == DEFAULT_QUANTITY:
            entry.setdefault("accuracy", _ACCURACY)
    else:
        is_default = entry.get("measures", DEFAULT_QUANTITY) == DEFAULT_QUANTITY
        replacements = _INSTRUMENT if is_default else _OTHER_INSTRUMENT
        entry.pop(key, None)
        if key in replacements:
            entry[key] = replacements[key]
    return True
