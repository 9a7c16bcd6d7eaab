"""What ships with Rigrunner as plugins. Nothing here loads numpy."""

from __future__ import annotations

from rigrunner_plugins.analyses.records import rigrunner_analyses
from rigrunner_plugins.decision_rules import rigrunner_decision_rules
from rigrunner_plugins.devices.records import rigrunner_devices
from rigrunner_plugins.fits.records import rigrunner_fits
from rigrunner_plugins.importers.records import rigrunner_importers
from rigrunner_plugins.listeners.records import rigrunner_event_sinks
from rigrunner_plugins.outlier_rules.records import rigrunner_outlier_rules

__all__ = [
    "api_version",
    "rigrunner_analyses",
    "rigrunner_decision_rules",
    "rigrunner_devices",
    "rigrunner_event_sinks",
    "rigrunner_fits",
    "rigrunner_importers",
    "rigrunner_outlier_rules",
]

api_version = 1
