"""What no single field of a procedure can see: parts that do not fit together."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from rigrunner.api.errors import Problem
from rigrunner.api.units import unit, units_of
from rigrunner.procedure.walk import steps_of
from rigrunner.yamlfile.document import dotted

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigrunner.procedure.analysis_spec import PluginRef
    from rigrunner.procedure.model import Procedure
    from rigrunner.yamlfile import Document
    from rigrunner.yamlfile.document import Path


def inconsistencies(procedure: Procedure, document: Document) -> list[Problem]:
    """Return every contradiction within a procedure, with its place."""
    return [
        Problem(message, document.where(path, key=document.part(path) is None), dotted(path), hint)
        for check in (
            _analyses,
            _compensation,
            _validation,
            _repeated_plugins,
            _answers,
            _tries,
        )
        for path, message, hint in check(procedure)
    ]


def analysis_contradictions(procedure: Procedure) -> list[Problem]:
    """Return the contradictions of an analysis that was put together otherwise than from a file."""
    return [
        Problem(message, None, dotted(path), hint)
        for check in (_compensation, _validation, _repeated_plugins)
        for path, message, hint in check(procedure)
    ]


Complaint = tuple["Path", str, str]


def _analyses(procedure: Procedure) -> Iterator[Complaint]:
    of_torque = [(i, each) for i, each in enumerate(procedure.analysis) if each.plugin is None]
    for index, each in of_torque[1:]:
        message = f"'{each.name}' is a second analysis of torque"
        yield ("analysis", index), message, "a procedure has one of them"
    if of_torque and procedure.measurand is None:
        yield ("measurand",), "the key 'measurand' is missing", "the analysis of torque names it"
    if of_torque and procedure.measurand is not None and procedure.measurand.unit is not None:
        known = unit(procedure.measurand.unit)
        if known.dimension != "torque":
            message = f"'{known.symbol}' is a unit of {known.dimension}, not of torque"
            yield (
                ("measurand", "unit"),
                message,
                f"units of torque: {', '.join(units_of('torque'))}",
            )


def _compensation(procedure: Procedure) -> Iterator[Complaint]:
    spec, at = procedure.torque_analysis, procedure.torque_analysis_at
    names = [each.label for each in spec.compensations]
    allowed = ", ".join(names) or "none, as there are no compensations"
    if spec.primary_ and spec.primary_ not in names:
        message = f"got '{spec.primary_}', which is not among the compensations"
        yield (*at, "primary"), message, f"allowed: {allowed}"
    if names and not spec.primary:
        hint = f"say which one counts: {allowed}"
        yield (*at, "primary"), "the key 'primary' is missing", hint
    if names and spec.no_load is None and spec.starts is None:
        hint = "compensations need it: 'no_load: {from: latest, procedure: ID}'"
        yield (*at, "no_load"), "the key 'no_load' is missing", hint


def _validation(procedure: Procedure) -> Iterator[Complaint]:
    spec = procedure.torque_analysis
    if spec.validate_ is not None and not spec.compensations:
        hint = "add 'compensations' to the analysis, or leave 'validate' out"
        at = (*procedure.torque_analysis_at, "validate")
        yield at, "there is no compensated torque to validate", hint


def _repeated_plugins(procedure: Procedure) -> Iterator[Complaint]:
    spec, at = procedure.torque_analysis, procedure.torque_analysis_at
    for section, plugins in (("fits", spec.fits), ("compensations", spec.compensations)):
        for index in _repeated(plugins):
            label = plugins[index].label
            hint = "name it once, or give this one a name of its own: 'as: NAME'"
            yield (*at, section, index), f"'{label}' stands twice", hint


def _repeated(plugins: Sequence[PluginRef]) -> list[int]:
    seen = Counter[str]()
    found = []
    for index, plugin in enumerate(plugins):
        if seen[plugin.label]:
            found.append(index)
        seen[plugin.label] += 1
    return found


def _answers(procedure: Procedure) -> Iterator[Complaint]:
    for path, step in steps_of(procedure):
        name = step.settings.answered()
        if name in procedure.inputs:
            message = f"the input '{name}' is asked at the start already"
            yield (*path, step.kind, "into"), message, "choose another name, or drop the input"


def _tries(procedure: Procedure) -> Iterator[Complaint]:
    for path, step in steps_of(procedure):
        retries = getattr(step.settings, "retries", 0)
        if retries and not getattr(step.settings, "repeatable", True):
            message = "the step is tried again, but is not repeatable"
            yield (*path, step.kind, "retries"), message, "leave one of them out"
