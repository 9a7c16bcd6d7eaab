"""One study of each group of runs; what cannot be studied is named, with the reason."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

from rigrunner.api.errors import DataError
from rigrunner_fleet.monitoring.observing import of_one_kind

if TYPE_CHECKING:
    from collections.abc import Callable

    from rigrunner_fleet.monitoring.observing import Group, Observations

_Series = TypeVar("_Series")


def each_group(
    found: Observations, made: Callable[[str, Group], _Series], nothing: str
) -> tuple[tuple[_Series, ...], dict[str, str]]:
    """Return what is made of each group, by its name, and why nothing was of the others.

    Raises DataError that begins with `nothing` where nothing can be made at all.
    """
    series, refused, hint = [], {}, ""
    for name, group in sorted(found.groups.items()):
        try:
            of_one_kind(group, found.quantity)
            series.append(made(name, group))
        except DataError as error:
            refused[name], hint = error.message, error.hint
    if not series:
        told = "; ".join(f"{name}: {reason}" for name, reason in refused.items())
        raise DataError(f"{nothing}. {told}", hint=hint)
    return tuple(series), refused
