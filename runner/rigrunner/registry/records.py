"""The records that a provider's hooks give, looked at when it is loaded."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from rigrunner.api import hooks
from rigrunner.api.errors import PluginError
from rigrunner.api.settings import Settings
from rigrunner.registry.declared import NAME

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterator

    from rigrunner.api.hooks import PluginRecord

_PREFIX = "rigrunner_"
RECORD_OF_KIND: dict[str, type[PluginRecord]] = {
    "device": hooks.DeviceRecord,
    "outlier_rule": hooks.OutlierRuleRecord,
    "fit": hooks.FitRecord,
    "compensation": hooks.CompensationRecord,
    "report_format": hooks.ReportFormatRecord,
    "certificate_format": hooks.CertificateFormatRecord,
    "study_format": hooks.StudyFormatRecord,
    "importer": hooks.ImporterRecord,
    "event_sink": hooks.EventSinkRecord,
}


def check_marked(module: object, implementations: Collection[Callable[..., object]]) -> None:
    """Raise PluginError for a function that is named as a hook and not marked as one."""
    name = getattr(module, "__name__", "")
    for key, value in vars(module).items():
        is_its_own = callable(value) and getattr(value, "__module__", "") == name
        if is_its_own and key.startswith(_PREFIX) and value not in implementations:
            raise PluginError(
                f"its function {key} is not marked as a hook",
                hint="put @hookimpl above it, of rigrunner.api.hooks",
            )


def checked_records(kind: str, hook: str, returned: object) -> Iterator[PluginRecord]:
    """Yield the records that a hook returned; raise PluginError for anything else."""
    needed = RECORD_OF_KIND[kind]
    if returned is None or isinstance(returned, (str, hooks.PluginRecord)):
        raise PluginError(f"{hook} returned {returned!r}, needed is a list of {needed.__name__}")
    for record in returned:  # type: ignore[attr-defined]  # what else is no list says so itself
        if not isinstance(record, hooks.PluginRecord):
            raise PluginError(f"{hook} returned {record!r}, which is not a plugin record")
        if not isinstance(record, needed):
            given = f"a {type(record).__name__}"
            raise PluginError(f"{hook} returned {given}, needed is a {needed.__name__}")
        _check(record, hook)
        yield record


def _check(record: PluginRecord, hook: str) -> None:
    where = f"the record {record.name!r} of {hook}"
    if not isinstance(record.name, str) or not re.fullmatch(NAME, record.name):
        raise PluginError(f"{where}: a name has small letters, digits and '_'")
    if not callable(record.factory):  # type: ignore[attr-defined]  # every kind has one
        raise PluginError(f"{where}: its factory cannot be called")
    settings = record.settings
    if not isinstance(settings, str) and not (
        isinstance(settings, type) and issubclass(settings, Settings)
    ):
        raise PluginError(f"{where}: its settings are {settings!r}, no subclass of Settings")
