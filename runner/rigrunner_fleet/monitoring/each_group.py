"""Make one study for each group of runs; groups without one are named, with the reason."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

from rigrunner.api.errors import DataError
from rigrunner_fleet.monitoring.observing import of_one_kind

if TYPE_CHECKING:
    from collections.abc import Callable

    from rigrunner_fleet.monitoring.observing import Group, Observations

_Series = TypeVar("_Series")


class NoStudyError(DataError):
    """No group has a study; `refused` has the reason of each, by its name."""

    def __init__(self, nothing: str, refused: dict[str, str], hint: str) -> None:
        told = "; ".join(f"{name}: {reason}" for name, reason in refused.items())
        super().__init__(f"{nothing}. {told}", hint=hint)
        self.refused = refused


def each_group(
    found: Observations, made: Callable[[str, Group], _Series], nothing: str
) -> tuple[tuple[_Series, ...], dict[str, str]]:
    """Return the study of each group, by its name, and the reasons of groups without one.

    Raises NoStudyError that begins with `nothing` if no group has a study.
    """
    series, refused, hint = [], {}, ""
    for name, group in sorted(found.groups.items()):
        try:
            of_one_kind(group, found.quantity)
            series.append(made(name, group))
        except DataError as error:
            refused[name], hint = error.message, error.hint
    if not series:
        raise NoStudyError(nothing, refused, hint)
    return tuple(series), refused
