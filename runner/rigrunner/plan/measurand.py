"""Whether the procedure's `measurand` is there for the analysis that gives it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from rigrunner.api.errors import PluginError
from rigrunner.api.hooks import AnalysisRecord
from rigrunner.api.units import unit, units_of

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.api.hooks import PluginRecord
    from rigrunner.procedure import LoadedProcedure, Procedure
    from rigrunner.yamlfile.document import Path
    from rigrunner.yamlfile.problems import Problems


class RecordLookup(Protocol):
    """Knows what every plugin declares."""

    def record(self, kind: str, name: str) -> PluginRecord:
        """Return it; raise PluginError if there is no such plugin."""
        ...


def check_measurand(procedure: LoadedProcedure, lookup: RecordLookup, problems: Problems) -> None:
    """Add a problem where the measurand is missing, has another unit, or is given twice."""
    document, measurand = procedure.document, procedure.model.measurand
    giving = list(_giving(procedure.model, lookup))
    for path, record in giving[1:]:
        message = f"'{record.name}' is a second analysis of {record.measurand}"
        problems.add(document, path[:-1], message, "a procedure has one of them")
    if not giving:
        return
    dimension = giving[0][1].measurand
    if measurand is None:
        hint = f"the analysis of {dimension} names it"
        problems.add(document, ("measurand",), "the key 'measurand' is missing", hint, key=True)
    elif measurand.unit is not None and (known := unit(measurand.unit)).dimension != dimension:
        message = f"'{known.symbol}' is a unit of {known.dimension}, not of {dimension}"
        hint = f"units of {dimension}: {', '.join(units_of(dimension))}"
        problems.add(document, ("measurand", "unit"), message, hint)


def _giving(procedure: Procedure, lookup: RecordLookup) -> Iterator[tuple[Path, AnalysisRecord]]:
    """Yield the analyses that give the measurand, each with its place."""
    for path, plugin in procedure.analyses_at:
        try:
            record = lookup.record(plugin.kind, plugin.name)
        except PluginError:
            continue  # told by the check of the plugins
        if isinstance(record, AnalysisRecord) and record.measurand:
            yield path, record
