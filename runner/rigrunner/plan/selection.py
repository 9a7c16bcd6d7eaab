"""Which recordings and rows an analysis is of: those with the coordinates of its `where`."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from rigrunner.api.coordinates import coordinate_text, in_si, matches, mixed_labels
from rigrunner.plan.needs import analyses, chosen
from rigrunner.yamlfile.problems import suggestion

if TYPE_CHECKING:
    from rigrunner.plan.actions import Plan
    from rigrunner.plan.draft import Draft
    from rigrunner.procedure import LoadedProcedure
    from rigrunner.yamlfile.problems import Problems


def analysed(plan: Plan, procedure: LoadedProcedure) -> Plan:
    """Return of a plan what the analysis looks at."""
    where = procedure.model.torque_analysis.where
    if not where:
        return plan
    steps = tuple(each for each in plan.steps if matches(each.coordinates, where))
    return replace(plan, steps=steps, recordings=tuple(chosen(plan.recordings, procedure)))


def check_selection(procedure: LoadedProcedure, draft: Draft, problems: Problems) -> None:
    """Add a problem for a `where` that chooses nothing, and for labels that would be averaged."""
    if not analyses(procedure):
        return
    where = procedure.model.torque_analysis.where
    at = procedure.model.torque_analysis_at
    for name, written in where.items():
        value, unit = in_si(written)
        steps = [each for each in draft.steps if each.action.recording or each.action.rows]
        there = {each.coordinates[name] for each in steps if name in each.coordinates}
        if not there:
            hint = suggestion(name, draft.coordinates, "counters and labels")
            message = f"nothing that is recorded or measured has '{name}'"
            problems.add(procedure.document, (*at, "where", name), message, hint, key=True)
        elif not any(matches({name: each}, {name: written}) for each in there):
            known = ", ".join(sorted(coordinate_text(each, unit) for each in there))
            message = f"nothing has {name} {coordinate_text(value, unit)}"
            problems.add(procedure.document, (*at, "where", name), message, f"there are: {known}")
    mixed = mixed_labels(
        (each.record.setpoints, each.coordinates, each.coordinate_units)
        for each in chosen(draft.recordings, procedure)
    )
    if mixed:
        hint = "say which ones it is of, such as 'where: {phase: final}' in the analysis"
        message = f"recordings with the same set-points would be averaged: {mixed}"
        problems.add(procedure.document, at, message, hint, key=True)
