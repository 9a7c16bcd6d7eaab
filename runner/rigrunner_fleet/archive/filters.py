"""Filters of an archive, parsed from the options of a command."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeVar

from rigrunner.api.errors import UsageError, did_you_mean
from rigrunner.api.events import Outcome
from rigrunner.api.verdict import Verdict
from rigrunner_fleet.archive.ranges import place_of, range_of, since, until

if TYPE_CHECKING:
    from collections.abc import Callable
    from datetime import datetime

    from rigrunner.api.quantity import Quantity
    from rigrunner_fleet.archive.ranges import Range

NONE = "none"
"""The verdict of runs without a decision."""
TEXTS = ("specimen", "type", "lot", "rig", "procedure", "revision", "operator")
"""Text columns of a run; '*' in a pattern stands for any characters, '?' for one."""
CHOICES: Mapping[str, tuple[str, ...]] = {
    "verdict": (*Verdict, NONE),
    "outcome": tuple(Outcome),
}
RANGES: Mapping[str, str] = {
    "torque": "torque",
    "uncertainty": "torque",
    "raw_peak": "torque",
    "frequency": "frequency",
    "load": "force",
}
"""Ranges of values, by dimension. With a frequency or a load, torque, uncertainty and raw peak are
those of that set-point, else those of the result of the run."""
NOMINAL = "frequency"
"""A nominal value, not a measured one: a single value is accepted as well as a range."""
NAMED = ("inputs", "figures", "where")
Texts = str | Sequence[str]
_Read = TypeVar("_Read")


@dataclass(frozen=True, kw_only=True)
class Filters:
    """What a run must match; several texts of one kind are alternatives."""

    texts: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    """Patterns, by the column of the run."""
    inputs: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    """Patterns, by the name of the procedure's input."""
    ranges: Mapping[str, Range] = field(default_factory=dict)
    """In SI units, by the names in RANGES."""
    figures: Mapping[str, Range] = field(default_factory=dict)
    """In SI units, by the name of the figure of the rig."""
    results: Mapping[str, Range | None] = field(default_factory=dict)
    """In SI units, by the name of the result; None: any value."""
    where: Mapping[str, Quantity | str] = field(default_factory=dict)
    """The place of the results, by coordinate, with or without its role."""
    since: datetime | None = None
    until: datetime | None = None
    """Runs that started before this time."""
    real: bool = False
    """Leave out runs on simulated instruments and replays of tapes."""
    copies: bool = False
    """Count every copy of a run."""


def filters_of(**filters: Any) -> Filters:
    """Return the filters; raise UsageError for an unknown one or a wrong value.

    Texts and choices are a text or several, `inputs` and `figures` mappings of names to them,
    ranges as '0.5..0.8 N·m', `result` names or a mapping of them to ranges, `where` a mapping of
    coordinates to values, such as {"chamber.temperature": "100 °C"}, `since` and `until` as
    2026-01-31 or with a time. None is no filter.
    """
    terms = {name: value for name, value in filters.items() if value not in (None, (), [], {}, "")}
    unknown = sorted(set(terms) - set(KNOWN))
    if unknown:
        hint = did_you_mean(unknown[0], KNOWN, f"there are: {', '.join(KNOWN)}", cutoff=0.5)
        raise UsageError(f"there is no filter '{unknown[0]}'", hint=hint)
    _check_choices(terms)
    results = terms.get("result", {})
    if not isinstance(results, Mapping):
        results = dict.fromkeys(_as_tuple(results))
    return Filters(
        texts={name: _as_tuple(terms[name]) for name in (*TEXTS, *CHOICES) if name in terms},
        inputs={name: _as_tuple(patterns) for name, patterns in terms.get("inputs", {}).items()},
        ranges={
            name: range_of(terms[name], dimension, nominal=name == NOMINAL)
            for name, dimension in RANGES.items()
            if name in terms
        },
        figures={name: range_of(text) for name, text in terms.get("figures", {}).items()},
        results={name: _parsed(range_of, text) for name, text in results.items()},
        where={name: place_of(str(value)) for name, value in terms.get("where", {}).items()},
        since=_parsed(since, terms.get("since")),
        until=_parsed(until, terms.get("until")),
        real=bool(terms.get("real")),
        copies=bool(terms.get("copies")),
    )


KNOWN = (*TEXTS, *CHOICES, *RANGES, *NAMED, "result", "since", "until", "real", "copies")


def _check_choices(terms: Mapping[str, Any]) -> None:
    for name, allowed in CHOICES.items():
        for choice in _as_tuple(terms.get(name, ())):
            if choice not in allowed:
                hint = f"it is one of: {', '.join(allowed)}"
                raise UsageError(f"there is no {name} '{choice}'", hint=hint)


def _as_tuple(texts: Texts) -> tuple[str, ...]:
    return (texts,) if isinstance(texts, str) else tuple(texts)


def _parsed(read: Callable[[str], _Read], text: str | None) -> _Read | None:
    return None if text is None else read(text)
