"""The analysis of one stored run, wherever it is done."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from rigrunner.analysis.document import document
from rigrunner.analysis.verdict.document import verdict_in
from rigrunner.procedure import parse_procedure
from rigrunner.run.lab_plugins import lab_registry
from rigrunner.run.provenance import refuse_other_software
from rigrunner.run.set_points import named_place, other_results
from rigrunner.run.stored import analyse_stored
from rigrunner.runfile import read, read_info

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

    from rigrunner.registry import Registry
    from rigrunner.runfile import RunInfo
    from rigrunner_fleet.reanalysis.changes import Changes


@dataclass(frozen=True, kw_only=True)
class Row:
    """A line of the summary: the outcome of one run; torque in N·m."""

    run: str = ""
    """Its name among the results."""
    run_id: str = ""
    procedure: str = ""
    revision: str = ""
    station: str = ""
    specimen: str = ""
    started_utc: str = ""
    method: str = ""
    torque_nm: float | None = None
    u_nm: float | None = None
    expanded_nm: float | None = None
    verdict: str = ""
    method_before: str = ""
    torque_before_nm: float | None = None
    """Of the first analysis, which is in the run's own file."""
    verdict_before: str = ""
    failed_checks: int = 0
    results: list[Mapping[str, Any]] = field(default_factory=list)
    """Of each named result but the torque: name and place, value and U now and before, unit."""
    skipped: str = ""
    """Why there is nothing to analyse, if so."""
    problem: str = ""
    """Why there is no result although there should be one."""


@dataclass(frozen=True)
class Reanalysed:
    """The outcome of one run: a line of the summary and the text of its result, if there is one."""

    row: Mapping[str, Any]
    result: str = ""


@dataclass(frozen=True)
class Reanalysis:
    """Analyses a stored run with these changes, by this version of the software only."""

    changes: Changes
    station: str | None = None
    """A station whose folder has plugins of its own."""
    software: Mapping[str, str] = field(default_factory=dict)
    """The version of the caller; another may give other numbers. Empty for any."""

    def __call__(self, path: Path) -> Reanalysed:
        """Return the outcome of a run; raise DataError if it cannot be read or analysed."""
        registry = _registry(self.station)
        refuse_other_software(self.software, registry)
        info = read_info(path)
        if not info.sealed or info.outcome != "completed":
            reason = f"it ended as {info.outcome}" if info.sealed else "it is not sealed"
            return Reanalysed(asdict(_row(info, None, None, skipped=reason)))
        stored = read(path)
        header = stored.header
        procedure = parse_procedure(header.procedure_text, header.procedure_id, stored=True).model
        if not self.changes.applied(procedure, registry).analysis:
            reason = "its procedure asks for no analysis"
            return Reanalysed(asdict(_row(info, None, None, skipped=reason)))
        result = analyse_stored(
            stored, registry, changes=lambda procedure: self.changes.applied(procedure, registry)
        )
        result_document = document(result)
        text = json.dumps(result_document, ensure_ascii=False, indent=2, allow_nan=False)
        return Reanalysed(asdict(_row(info, result_document, stored.result_document)), f"{text}\n")


@lru_cache(maxsize=1)
def _registry(station: str | None) -> Registry:
    return lab_registry(station)


def _row(
    info: RunInfo,
    now: Mapping[str, Any] | None,
    before: Mapping[str, Any] | None,
    *,
    skipped: str = "",
) -> Row:
    header = info.header
    torque, earlier = _torque(now), _torque(before)
    return Row(
        run_id=header.run_id,
        procedure=header.procedure_id,
        revision=header.procedure_revision,
        station=header.station_id,
        specimen=header.inputs.get("specimen", ""),
        started_utc=header.started_utc,
        method=_method(now),
        torque_nm=torque.get("value"),
        u_nm=torque.get("standard_uncertainty"),
        expanded_nm=torque.get("expanded_uncertainty_95"),
        verdict=verdict_in(now),
        method_before=_method(before),
        torque_before_nm=earlier.get("value"),
        verdict_before=verdict_in(before),
        failed_checks=_failed_checks(now),
        results=list(_results(now, before)),
        skipped=skipped,
    )


def _results(
    now: Mapping[str, Any] | None, before: Mapping[str, Any] | None
) -> Iterator[Mapping[str, Any]]:
    current, earlier = _named(now), _named(before)
    for name in {**earlier, **current}:
        old, new = earlier.get(name, {}), current.get(name, {})
        yield {
            "result": name,
            "value": new.get("value"),
            "expanded": new.get("expanded_uncertainty_95"),
            "value_before": old.get("value"),
            "expanded_before": old.get("expanded_uncertainty_95"),
            "unit": new.get("unit") or old.get("unit"),
        }


def _named(content: Mapping[str, Any] | None) -> Mapping[str, Mapping[str, Any]]:
    results = other_results(content or {})
    return {named_place(result): result["estimate"] for result in results}


def _torque(content: Mapping[str, Any] | None) -> Mapping[str, Any]:
    return (((content or {}).get("headline") or {}).get("compensated")) or {}


def _method(content: Mapping[str, Any] | None) -> str:
    return ((content or {}).get("headline") or {}).get("method") or ""


def _failed_checks(content: Mapping[str, Any] | None) -> int:
    if content is None:
        return 0
    methods = content["compensations"].values()
    checks = [*content["checks"], *(check for method in methods for check in method["checks"])]
    return sum(not check["ok"] for check in checks)
