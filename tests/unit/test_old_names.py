"""Names of 0.1.0 that plugins made then use."""

from __future__ import annotations

import importlib
import sys

import pytest

import rigrunner_bearings.api
import rigrunner_testing


def test_the_kit_is_found_by_its_old_name_with_a_warning():
    sys.modules.pop("rigrunner.testing", None)
    with pytest.warns(DeprecationWarning, match="rigrunner_testing"):
        old = importlib.import_module("rigrunner.testing")
    assert old.subject is rigrunner_testing.subject
    with pytest.raises(AttributeError):
        _ = old.nothing_like_that


@pytest.mark.parametrize("module", ["rigrunner.api", "rigrunner.api.hooks"])
def test_what_is_the_bearings_own_is_found_where_it_was_with_a_warning(module):
    with pytest.warns(DeprecationWarning, match="from rigrunner_bearings.api"):
        exec(f"from {module} import CompensationRecord", found := {})  # noqa: S102
    assert found["CompensationRecord"] is rigrunner_bearings.api.CompensationRecord
    with pytest.raises(AttributeError, match="has no attribute 'CompensationRecords'"):
        _ = importlib.import_module(module).CompensationRecords
