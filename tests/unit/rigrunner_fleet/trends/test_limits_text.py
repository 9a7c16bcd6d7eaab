"""Limits of a capability study as text."""

from __future__ import annotations

from types import SimpleNamespace

from rigrunner_fleet.cli.monitoring_text import _limits


def test_limits_are_printed_with_all_digits():
    """10 MHz ± 1 Hz was 'lower limit 10 MHz, upper limit 10 MHz'."""
    study = SimpleNamespace(lower=9.999999, upper=10.000001)
    assert _limits(study, "MHz") == ["lower limit 9.999999 MHz", "upper limit 10.000001 MHz"]
