"""Make one study for each group of runs; groups without one are named, with the reason."""

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
    """Return the study of each group, by its name, and the reasons of groups without one.

    Raises DataError that begins with `nothing` if no group has a study.
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
