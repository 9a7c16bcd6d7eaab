"""Differences of two trees of a YAML file, as text; '1 kN' and '1000 N' are equal."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import dataclass
from difflib import SequenceMatcher
from typing import TYPE_CHECKING, Any

from rigrunner.api.quantity import Quantity, parse_quantity
from rigrunner.api.texts import clip
from rigrunner.api.units import QuantityError

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

_LONGEST = 70
_STEPS = {"setup", "main", "teardown", "steps"}
_SEPARATOR = " > "


@dataclass(frozen=True)
class Change:
    """One difference, as a sentence."""

    section: str
    text: str
    matters: bool = True
    """False for a note: a difference that changes neither actions nor results."""


def changes(section: str, before: Any, after: Any, path: tuple[str, ...] = ()) -> Iterator[Change]:
    """Yield the differences of two trees of mappings, lists and scalars.

    None stands for an absent value.
    """
    if same(before, after):
        return
    if isinstance(before, dict) and isinstance(after, dict):
        for key in dict.fromkeys([*before, *after]):
            yield from changes(section, before.get(key), after.get(key), (*path, str(key)))
    elif isinstance(before, list) and isinstance(after, list):
        yield from _list_changes(section, before, after, path)
    else:
        subject = _SEPARATOR.join(path) or section
        yield Change(section, f"{subject} {_verb(before, after)}")


def same(before: Any, after: Any) -> bool:
    """Return whether two trees are equal: quantities are compared by their SI value."""
    return bool(_normal(before) == _normal(after))


def _list_changes(
    section: str, before: list[Any], after: list[Any], path: tuple[str, ...]
) -> Iterator[Change]:
    first, second = _by_name(before), _by_name(after)
    nested = any(isinstance(item, (dict, list)) for item in (*before, *after))
    if (path or (section,))[-1] in _STEPS or (nested and not (first and second)):
        yield from _sequence_changes(section, before, after, path)
    elif nested:
        yield from changes(section, first, second, path)
        # the order counts: the first fit, for example, is the one that others build on
        order = [name for name in second if name in first]
        if order != [name for name in first if name in second]:
            subject = _SEPARATOR.join(path) or section
            yield Change(section, f"{subject}: now in the order {', '.join(order)}")
    else:  # plain values, such as set-points
        groups = ((_surplus(after, before), "added"), (_surplus(before, after), "removed"))
        phrases = [f"{', '.join(map(shown, items))} {verb}" for items, verb in groups if items]
        subject = _SEPARATOR.join(path) or section
        text = "; ".join(phrases) or "the same values in another order"
        yield Change(section, f"{subject}: {text}")


def _surplus(items: list[Any], others: list[Any]) -> list[Any]:
    """Return the items that the others lack, each as often as it is missing there."""
    remaining, surplus = Counter(map(_normal, others)), []
    for item in items:
        if remaining[_normal(item)]:
            remaining[_normal(item)] -= 1
        else:
            surplus.append(item)
    return surplus


def _sequence_changes(
    section: str, before: list[Any], after: list[Any], path: tuple[str, ...]
) -> Iterator[Change]:
    """Report the entries of a list that were added, removed or changed, numbered from 1."""
    first, second = ([json.dumps(_normal(item)) for item in items] for items in (before, after))
    for kind, a, b, c, d in SequenceMatcher(None, first, second, autojunk=False).get_opcodes():
        if kind == "equal":
            continue
        if b - a == d - c and all(map(_alike, before[a:b], after[c:d])):
            entry = path[-1] if path and path[-1] not in _STEPS else "step"
            for index in range(b - a):
                at = (*path[:-1], f"{entry} {c + index + 1}")
                yield from changes(section, before[a + index], after[c + index], at)
            continue
        what = _SEPARATOR.join(path) or section
        for index, item in enumerate(before[a:b], a + 1):
            yield Change(section, f"{what}: number {index} was removed: {shown(item)}")
        for index, item in enumerate(after[c:d], c + 1):
            yield Change(section, f"{what}: number {index} was added: {shown(item)}")


def _alike(before: Any, after: Any) -> bool:
    """Return whether an entry is the other one changed: mappings that begin with the same key."""
    are_mappings = isinstance(before, dict) and isinstance(after, dict) and before and after
    return bool(are_mappings and next(iter(before)) == next(iter(after)))


def _by_name(items: Sequence[Any]) -> dict[str, Any]:
    """Return entries by their names (instruments, plugins with settings); none without names."""
    named = dict(filter(None, map(_name_and_content, items)))
    return named if len(named) == len(items) else {}


def _name_and_content(item: Any) -> tuple[str, Any] | None:
    if isinstance(item, str):
        return (item, {}) if _quantity(item) is None else None
    if not isinstance(item, dict) or not item:
        return None
    if "channel" in item:
        return str(item["channel"]), item
    name, *more = [key for key in item if key != "as"] or [""]
    if more:
        return None
    settings = item[name] if isinstance(item.get(name), dict) else {}
    return (str(item["as"]), {"plugin": name, **settings}) if "as" in item else (name, settings)


def _verb(before: Any, after: Any) -> str:
    if before is None or after is None:
        verb, value = ("was added", after) if before is None else ("was removed", before)
        return f"{verb}: {shown(value)}" if value not in ({}, []) else verb
    first, second = _quantity(before), _quantity(after)
    if first and second and first.dimension == second.dimension:
        how = "raised" if second.si > first.si else "lowered"
        return f"was {how} from {first} to {second}"
    return f"was changed from {shown(before)} to {shown(after)}"


def shown(value: Any) -> str:
    """Return a value in YAML, on one line, shortened if it is long."""
    if isinstance(value, str):
        text = value if _quantity(value) else f"'{value}'"
    elif isinstance(value, dict):
        text = "{" + ", ".join(f"{key}: {_bare(item)}" for key, item in value.items()) + "}"
    elif isinstance(value, list):
        text = "[" + ", ".join(map(_bare, value)) + "]"
    else:
        text = json.dumps(value)
    return clip(text, _LONGEST)


def _bare(value: Any) -> str:
    return value if isinstance(value, str) else shown(value)


def _quantity(value: Any) -> Quantity | None:
    if not isinstance(value, str):
        return None
    try:
        return parse_quantity(value)
    except QuantityError:
        return None


def _normal(value: Any) -> Any:
    """Return one form for all ways to write the same value."""
    if isinstance(value, dict):
        return tuple(sorted((str(key), _normal(item)) for key, item in value.items()))
    if isinstance(value, list):
        return tuple(map(_normal, value))
    quantity = _quantity(value)
    if quantity is not None:
        return (quantity.dimension, f"{quantity.si:.9e}")
    return (type(value).__name__, str(value))
