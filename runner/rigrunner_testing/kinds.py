"""The checks of each kind of plugin, and how a plugin is selected."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from rigrunner.api.errors import PluginError
from rigrunner.registry import load_registry, with_drop_ins
from rigrunner_testing import (
    analyses,
    brought,
    decision_rules,
    event_sinks,
    fits,
    importers,
    labs,
    making,
    outlier_rules,
    settings,
    steps,
    units,
)
from rigrunner_testing.device import CHECKS as DEVICE_CHECKS
from rigrunner_testing.device import DeviceSubject
from rigrunner_testing.formats import CHECKS as FORMAT_CHECKS
from rigrunner_testing.formats import FormatSubject
from rigrunner_testing.subjects import Subject

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.registry import Registry
    from rigrunner_testing.check import AnyCheck

OF_KIND: dict[str, tuple[AnyCheck, ...]] = {
    "device": DEVICE_CHECKS,
    "fit": fits.CHECKS,
    "outlier_rule": outlier_rules.CHECKS,
    "decision_rule": decision_rules.CHECKS,
    "analysis": analyses.CHECKS,
    "importer": importers.CHECKS,
    "report_format": FORMAT_CHECKS,
    "certificate_format": FORMAT_CHECKS,
    "study_format": FORMAT_CHECKS,
    "event_sink": event_sinks.CHECKS,
    "step": steps.CHECKS,
    "unit": units.CHECKS,
    "lab": labs.CHECKS,
    "kind": brought.CHECKS,
}
"""The checks of Rigrunner's own kinds. A package that brings a kind brings its checks."""


def checks(kind: str, registry: Registry | None = None) -> tuple[AnyCheck, ...]:
    """Return all checks for plugins of that kind, 'device', 'fit', ..., in order.

    `registry` has the kinds that plugins bring; by default it is that of all installed plugins.
    """
    factory_checks = () if kind == "step" else making.CHECKS  # it makes nothing, but a plan
    if kind in OF_KIND:
        return (*settings.CHECKS, *factory_checks, *OF_KIND[kind])
    module = brought.conformance(registry or load_registry(), kind)
    return (*settings.CHECKS, *factory_checks, *(module.CHECKS if module else ()))


def subject(
    kind: str,
    name: str,
    given: Mapping[str, Any] | None = None,
    *,
    registry: Registry | None = None,
    drop_in: Path | None = None,
    folder: Path | None = None,
) -> Subject:
    """Return a plugin, ready for its checks, with settings in the form of YAML.

    By default they are those under `trial` of its record. `drop_in` is a lab's folder of plugins;
    paths in the settings are relative to `folder`. Raises PluginError for an unknown plugin or
    invalid settings.
    """
    if registry is None:
        registry = load_registry()
    if drop_in is not None:
        registry = with_drop_ins(registry, drop_in)
    plugin = registry.find(kind, name)
    subject_settings = dict(plugin.record.trial if given is None else given)
    try:
        registry.validated(kind, name, subject_settings)
    except PluginError as error:
        hint = "give settings with which it can be tried: --settings FILE, or its record's `trial`"
        raise PluginError(error.message, hint=hint) from error
    if kind == "device":
        return DeviceSubject(plugin, registry, subject_settings, folder=folder or Path())
    if kind in {"report_format", "certificate_format", "study_format"}:
        return FormatSubject(plugin, registry, subject_settings)
    module = None if kind in OF_KIND else brought.conformance(registry, kind)
    return (module.SUBJECT if module else Subject)(plugin, registry, subject_settings)
