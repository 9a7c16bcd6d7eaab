"""Whether the limits of a procedure are limits of the torque that its compensation yields."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from rigrunner.api.errors import PluginError
from rigrunner.yamlfile.problems import Problems

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator

    from rigrunner.api.measurand import MeasurandKind
    from rigrunner.procedure.loading import LoadedProcedure
    from rigrunner.procedure.result_limits import Limit
    from rigrunner.yamlfile.document import Path


class MeasurandLookup(Protocol):
    """Knows which torque each compensation yields."""

    def yields(self, compensation: str) -> MeasurandKind | None:
        """Return it, or None where the plugin does not say; raise PluginError for an unknown."""
        ...


def check_measurands(procedure: LoadedProcedure, lookup: MeasurandLookup) -> None:
    """Raise InvalidFileError with every limit of another torque than the one that is measured.

    The loads are those of a plan, and not known here.
    """
    problems = Problems()
    add_other_measurands(problems, procedure, lookup, loads_n=())
    problems.stop_if_any()


def add_other_measurands(
    problems: Problems,
    procedure: LoadedProcedure,
    lookup: MeasurandLookup,
    loads_n: Collection[float],
) -> None:
    """Add every limit of another torque than the one that is measured under these loads."""
    spec = procedure.model.torque_analysis
    primary = spec.primary_plugin
    if primary is None:
        return
    try:
        kind = lookup.yields(primary.name)
    except PluginError:
        return
    for path, limit in torque_limits(procedure):
        place: Path = (*path, "measurand")
        if limit.measurand is None:
            message = f"'{limit.of}' is a torque, and the key 'measurand' is missing"
            hint = "say of which one: 'measurand: {nature: ..., condition: ...}'"
            problems.add(procedure.document, path, message, hint)
            continue
        if kind is None:
            message = f"'{primary.name}' does not say which torque it yields"
            hint = "its plugin must declare it ('yields'), or the limit be left out"
            problems.add(procedure.document, place, message, hint)
            continue
        objection = limit.measurand.objection(spec.measured(kind), loads_n)
        if objection:
            hint = "limits and results of two measurands have nothing to say to each other"
            problems.add(procedure.document, place, objection, hint)


def torque_limits(procedure: LoadedProcedure) -> Iterator[tuple[Path, Limit]]:
    """Yield every limit of the compensated torque and where it stands."""
    acceptance, name = procedure.model.acceptance, procedure.model.torque_analysis.name
    for index, limit in enumerate(acceptance.limits if acceptance else ()):
        if limit.of == name:
            yield ("acceptance", "limits", index), limit
