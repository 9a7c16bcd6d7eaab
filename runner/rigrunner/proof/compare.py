"""Two documents of numbers compared, to the resolution to which the numbers are printed.

Sums of floating-point numbers differ in their last digits from machine to machine, so numbers that
were computed again are not compared bit by bit:

- a value that stands beside its uncertainty, to the place to which it is printed: that of the
  second significant digit of U (GUM 7.2.6);
- any other number to four significant digits, a member of an array to as much of the largest;
- checks by their names, see `_of_checks`; results of a name that was not recorded are new;
- numbers within a text to one unit of their last digit, and what older programs wrote in the words
  of today;
- all else must be equal.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from math import isfinite
from typing import TYPE_CHECKING, Any, TypeGuard

from rigrunner.signal.rounding import places

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

SIGNIFICANT = 5e-5
"""Half a unit of the fourth significant digit, relative to the smallest number that has it."""
NEGLIGIBLE = 1e-12
"""In the document's units: what remains of a difference that should be zero, of a number whose
resolution is unknown."""
# The first that is there counts: a value is printed to the digits of U.
_WIDTHS = ("expanded_uncertainty_95", "expanded_uncertainty", "standard_uncertainty")
_NAMES = ("recording", "name", "item", "symbol")
_CHECK = {"name", "ok", "text"}
_RESULT = {"name", "coordinates", "estimate"}
_NUMBER = re.compile(r"\d+(?:\.\d+)?")
_OLDER_DIGITS = 6
"""Older programs wrote a limit with so many; the rest of it stands beside the text."""
_LONGEST = 80
"""Letters of a value in a message."""
_REASON = re.compile(
    r"(?P<of>.*: )?[^:]+? is (?P<away>[^:]+?) (?P<side>within|outside) the limit (?P<limit>[^:]+?)"
    r"(?:, (?P<how>by at least|but by less than|but by no more than|by more than"
    r"|but no value is within both limits by) (?P<width>[^:]+?))?"
    r"(?P<why>: conformity is not demonstrated|: so uncertain a result cannot pass)?\."
)
_BY_HOW = {
    None: "",
    "by at least": " ({width})",
    "but by less than": ", less than {width}",
    "but by no more than": ", no more than {width}",
    "by more than": ", more than {width}",
    "but no value is within both limits by": (
        "; the limits are too close for {width}, so no result can pass"
    ),
}


@dataclass(frozen=True, order=True)
class Mismatch:
    """A difference of two documents, with a path such as 'points/001_5Hz/load/value'."""

    where: str
    what: str

    def __str__(self) -> str:
        """Return path and difference as one line."""
        return f"{self.where}: {self.what}"


def mismatches(
    recorded: object, derived: object, where: str = "", width: float = 0.0
) -> Iterator[Mismatch]:
    """Yield differences of a derived document from the recorded one.

    Members that only the derived document has come from a newer program, and are ignored. `width`
    is the resolution of a number given by its context.
    """
    if isinstance(recorded, dict) and isinstance(derived, dict):
        for key, value in recorded.items():
            place = f"{where}/{key}" if where else key
            if key not in derived:
                yield Mismatch(place, f"{_words(value)} is recorded, and was not derived")
            else:
                yield from mismatches(value, derived[key], place, _resolution(recorded, key))
    elif isinstance(recorded, list) and isinstance(derived, list):
        yield from _of_lists(recorded, derived, where)
    elif not _same(recorded, derived, width):
        yield Mismatch(where, f"{_words(recorded)} is recorded, {_words(derived)} was derived")


def _of_lists(recorded: Sequence[Any], derived: Sequence[Any], where: str) -> Iterator[Mismatch]:
    if _are([*recorded, *derived], _CHECK):
        yield from _of_checks(recorded, derived, where)
        return
    if recorded and _are(recorded, _RESULT):
        names = {result["name"] for result in recorded}
        derived = [each for each in derived if not _are([each], _RESULT) or each["name"] in names]
    if len(recorded) != len(derived):
        yield Mismatch(where, f"{len(recorded)} are recorded, {len(derived)} were derived")
        return
    rows = (item if isinstance(item, list) else [item] for item in recorded)
    numbers = (abs(number) for row in rows for number in row if _is_number(number))
    width = SIGNIFICANT * max(numbers, default=0.0)
    for index, (one, other) in enumerate(zip(recorded, derived, strict=True)):
        labels = [one.get(key) for key in _NAMES] if isinstance(one, dict) else []
        label = next((text for text in labels if isinstance(text, str) and text), index)
        yield from mismatches(one, other, f"{where}/{label}", width)


def _are(members: Sequence[Any], keys: set[str]) -> bool:
    return bool(members) and all(isinstance(each, dict) and each.keys() >= keys for each in members)


def _of_checks(
    recorded: Sequence[Mapping[str, Any]], derived: Sequence[Mapping[str, Any]], where: str
) -> Iterator[Mismatch]:
    """Compare checks by name, since newer programs make more, in another order.

    A check that was not recorded is a difference only if it fails: it may have been removed.
    """
    recorded_checks = {check["name"]: check for check in recorded}
    derived_checks = {check["name"]: check for check in derived}
    for name, check in recorded_checks.items():
        place = f"{where}/{name}"
        if name in derived_checks:
            yield from mismatches(check, derived_checks[name], place)
        else:
            yield Mismatch(place, "the check is recorded, and was not derived")
    for name in derived_checks.keys() - recorded_checks.keys():
        if not derived_checks[name]["ok"]:
            words = f"the check fails, and is not recorded: {derived_checks[name].get('text', '')}"
            yield Mismatch(f"{where}/{name}", words)


def _same(recorded: object, derived: object, width: float) -> bool:
    if _is_number(recorded) and _is_number(derived):
        largest = max(abs(recorded), abs(derived))
        return abs(recorded - derived) <= max(width or NEGLIGIBLE, SIGNIFICANT * largest)
    if isinstance(recorded, str) and isinstance(derived, str):
        return recorded == derived or _same_text(today(recorded), derived)
    return recorded == derived and type(recorded) is type(derived)


def today(text: str) -> str:
    """Return the reason of a verdict as written since version 0.2; other texts unchanged.

    Meaning and numbers stay, except the value itself, which is beside the reason in each document
    and compared there.
    """
    old = _REASON.fullmatch(text)
    if old is None:
        return text
    of, limit, away = old["of"] or "", old["limit"], old["away"]
    inside, outside = f"Margin to the limit {limit}: {away}", f"Outside the limit {limit} by {away}"
    place = inside if old["side"] == "within" else outside
    if of.startswith(("At ", "The mean: ")):
        place = f"{place[:1].lower()}{place[1:]}"
    unproven = old["why"] == ": conformity is not demonstrated"
    why = "; conformity is not demonstrated" if unproven else ""
    return f"{of}{place}{_BY_HOW[old['how']].format(width=old['width'])}{why}."


def _same_text(recorded: str, derived: str) -> bool:
    """Return whether two texts differ only in the last digit of numbers, by one unit."""
    if _NUMBER.split(recorded) != _NUMBER.split(derived):
        return False
    pairs = zip(_NUMBER.findall(recorded), _NUMBER.findall(derived), strict=True)
    return all(_near(one, other) for one, other in pairs)


def _near(one: str, other: str) -> bool:
    decimals = len(one.partition(".")[2])
    if decimals and len(one.replace(".", "").lstrip("0")) == _OLDER_DIGITS:
        other = f"{float(other):.{decimals}f}"
    if not decimals or decimals != len(other.partition(".")[2]):
        return one == other  # whole numbers count or name something
    return abs(int(one.replace(".", "")) - int(other.replace(".", ""))) <= 1


def _resolution(numbers: Mapping[str, Any], key: str) -> float:
    """Return the resolution of a value beside its uncertainty, or of the uncertainty; else 0."""
    if key in _WIDTHS and _is_number(numbers[key]):
        return SIGNIFICANT * float(abs(numbers[key]))
    if key != "value":
        return 0.0
    width = next((numbers[name] for name in _WIDTHS if _is_number(numbers.get(name))), 0.0)
    return 0.5 * 10.0 ** -places(width) if width > 0 else 0.0


def _is_number(value: object) -> TypeGuard[float]:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and isfinite(value)


def _words(value: object) -> str:
    text = f"{value:.10g}" if isinstance(value, float) else repr(value)
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}…"
