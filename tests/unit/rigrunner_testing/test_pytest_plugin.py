"""The kit in pytest, as the tests of another package use it."""

from __future__ import annotations

import pytest

from rigrunner_testing import checks

pytest_plugins = ["pytester"]

PLUGIN = ("-p", "rigrunner_testing.pytest_plugin", "-p", "no:cacheprovider", "--strict-markers")
PACKAGE = """
from pathlib import Path

import pytest

@pytest.mark.conformance("device", "hollow", drop_in=Path("plugins"))
def test_it_conforms(conformance):
    conformance()
"""
GOOD = """
import pytest

@pytest.mark.conformance("outlier_rule", "mad", {"threshold": 4.0})
def test_it_conforms(conformance):
    conformance()

class TestSettingsOfAFixture:
    @pytest.fixture
    def conformance_settings(self):
        return {"threshold": 5.0}

    @pytest.mark.conformance("outlier_rule", "mad", {"threshold": "no number"})
    def test_it_conforms(self, conformance):
        conformance()
"""
HOLLOW = """
from rigrunner.api.hooks import DeviceRecord, hookimpl

api_version = 1

@hookimpl
def rigrunner_devices():
    return [DeviceRecord(name="hollow", help="", factory=lambda settings, context: None)]
"""


@pytest.mark.thorough
def test_inapplicable_checks_are_skipped(pytester):
    pytester.makepyfile(test_good=GOOD)
    result = pytester.runpytest_subprocess(*PLUGIN, "-rs")
    result.assert_outcomes(passed=2 * (len(checks("outlier_rule")) - 2), skipped=2 * 2)
    result.stdout.fnmatch_lines(["*it has no settings with units*", "*its record states no ex*"])


@pytest.mark.thorough
def test_failed_check_states_a_fix(pytester):
    pytester.makepyfile(test_hollow=PACKAGE)
    pytester.mkdir("plugins").joinpath("hollow.py").write_text(HOLLOW)
    result = pytester.runpytest_subprocess(*PLUGIN, "-k", "help_line or name_fits")
    result.assert_outcomes(passed=1, failed=1)
    result.stdout.fnmatch_lines(["*found: the record's help is empty*", "*fix: write one line*"])


@pytest.mark.thorough
def test_missing_marker_is_explained(pytester):
    pytester.makepyfile("def test_it_conforms(conformance): conformance()")
    result = pytester.runpytest_subprocess(*PLUGIN)
    assert "needs a marker, such as @pytest.mark.conformance('device'" in result.stdout.str()
