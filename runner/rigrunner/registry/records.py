"""Checks of the records that the hooks of a provider return."""

from __future__ import annotations

import difflib
import re
from typing import TYPE_CHECKING

from rigrunner.api import hooks
from rigrunner.api.errors import PluginError
from rigrunner.api.hooks import KindRecord
from rigrunner.api.settings import Settings
from rigrunner.registry.methods import call_problem, parameters, place_of

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterator

    from rigrunner.api.hooks import PluginRecord

_PREFIX = "rigrunner_"
PLUGIN_NAME = "[a-z][a-z0-9_]*"


def _kind(name: str, record: type[PluginRecord], *takes: str, hook: str = "") -> KindRecord:
    summary = " ".join((record.__doc__ or "").split()).partition(".")[0].partition(":")[0]
    return KindRecord(
        name=name, help=summary, hook=hook or f"{_PREFIX}{name}s", record=record, takes=takes
    )


OWN_KINDS = (
    _kind("step", hooks.StepRecord),
    _kind("device", hooks.DeviceRecord),
    _kind("outlier_rule", hooks.OutlierRuleRecord, "values"),
    _kind("fit", hooks.FitRecord, "points"),
    _kind("decision_rule", hooks.DecisionRuleRecord, "limits", "estimate"),
    _kind("analysis", hooks.AnalysisRecord, "run", hook="rigrunner_analyses"),
    _kind("report_format", hooks.ReportFormatRecord),
    _kind("certificate_format", hooks.CertificateFormatRecord),
    _kind("study_format", hooks.StudyFormatRecord),
    _kind("importer", hooks.ImporterRecord),
    _kind("event_sink", hooks.EventSinkRecord, "event"),
    _kind("unit", hooks.UnitRecord),
    _kind("lab", hooks.LabRecord),
    _kind("kind", hooks.KindRecord),
)
"""The kinds of plugins of Rigrunner, in the order in which a procedure uses them."""

_ARGUMENTS = {"device": ("context",), "step": ("planning",)}
"""Arguments of the factory of a kind besides the settings."""


def check_hook_names(module: object, hook_names: Collection[str]) -> None:
    """Raise PluginError for a function that is marked as a hook that does not exist."""
    for key, value in vars(module).items():
        if key in hook_names or getattr(value, f"{hooks.PROJECT}_impl", None) is None:
            continue
        matches = difflib.get_close_matches(key, hook_names, n=1)
        hint = f"call it {matches[0]}" if matches else f"there are: {', '.join(sorted(hook_names))}"
        raise PluginError(f"{key} ({place_of(value)}) is not the name of a hook", hint=hint)


def check_marked(module: object, implementations: Collection[Callable[..., object]]) -> None:
    """Raise PluginError for a function with the name of a hook but without its mark."""
    name = getattr(module, "__name__", "")
    for key, value in vars(module).items():
        is_defined_here = callable(value) and getattr(value, "__module__", "") == name
        if is_defined_here and key.startswith(_PREFIX) and value not in implementations:
            raise PluginError(
                f"its function {key} is not marked as a hook",
                hint=f"put @hookimpl, of rigrunner.api.hooks, above it ({place_of(value)})",
            )


def checked_records(
    kind: KindRecord, returned: object, kinds: Collection[KindRecord]
) -> Iterator[PluginRecord]:
    """Yield the records that the hook of a kind returned; raise PluginError for anything else."""
    needed, hook = kind.record, kind.hook
    if returned is None or isinstance(returned, (str, hooks.PluginRecord)):
        is_record = isinstance(returned, hooks.PluginRecord)
        got = f"one {type(returned).__name__}" if is_record else repr(returned)
        hint = "is there a `return`?" if returned is None else "put it into a list: [...]"
        raise PluginError(f"{hook} returned {got}, expected a list of {needed.__name__}", hint=hint)
    for record in returned:  # type: ignore[attr-defined]  # any other value raises
        if not isinstance(record, hooks.PluginRecord):
            raise PluginError(f"{hook} returned {record!r}, which is not a plugin record")
        if not isinstance(record, needed):
            matching = [other.name for other in kinds if type(record) is other.record]
            raise PluginError(
                f"{hook} returned a {type(record).__name__}, expected a {needed.__name__}",
                hint=f"return it from the hook for a {matching[0]}" if matching else "",
            )
        _check(record, hook)
        _check_factory(kind.name, record, hook)
        yield record


def _check(record: PluginRecord, hook: str) -> None:
    where = f"the record {record.name!r} of {hook}"
    if not isinstance(record.name, str) or not re.fullmatch(PLUGIN_NAME, record.name):
        raise PluginError(
            f"{where}: a name has small letters, digits and '_'",
            hint="give it a name such as 'spring_scale'",
        )
    if not callable(record.factory):  # type: ignore[attr-defined]  # every kind has one
        raise PluginError(f"{where}: its factory cannot be called")
    if type(record.revision) is not int or record.revision < 1:  # True is an int too
        raise PluginError(f"{where}: its revision is {record.revision!r}, expected 1, 2, ...")
    if isinstance(record, KindRecord) and not (
        isinstance(record.hook, str)
        and isinstance(record.record, type)
        and issubclass(record.record, hooks.PluginRecord)
    ):
        raise PluginError(
            f"{where}: got the hook {record.hook!r} and the record {record.record!r}, expected the"
            " name of a function and a subclass of PluginRecord"
        )
    settings = record.settings
    if not isinstance(settings, str) and not (
        isinstance(settings, type) and issubclass(settings, Settings)
    ):
        raise PluginError(
            f"{where}: its settings are {settings!r}, no subclass of Settings",
            hint="name the class itself, without brackets, derived from rigrunner.api.settings",
        )


def _check_factory(kind: str, record: PluginRecord, hook: str) -> None:
    """Raise PluginError unless the factory accepts its arguments."""
    factory = record.factory  # type: ignore[attr-defined]  # every kind has one
    fits = parameters(factory)[1:] if kind == "analysis" else ()  # named by fields of the settings
    args = ("settings", *_ARGUMENTS.get(kind, ()), *fits)
    name = getattr(factory, "__name__", type(factory).__name__)
    problem = call_problem(factory, f"its factory {name}", args)
    if not problem and args[1:] and parameters(factory)[:2] == args[::-1]:
        place = place_of(factory)
        problem = f"its factory {name} takes {args[1]} and settings in the wrong order ({place})"
    if problem:
        hint = f"write `def __init__(self, {', '.join(args)})`, or a function of these"
        raise PluginError(f"the record {record.name!r} of {hook}: {problem}", hint=hint)
