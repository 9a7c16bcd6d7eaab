from __future__ import annotations

from helpers_docs import ROOT
from rigrunner.registry import load_registry
from rigrunner_testing import checks
from rigrunner_testing.page import page


def test_page_of_checks_equals_the_code():
    written = (ROOT / "docs/reference/conformance.md").read_text(encoding="utf-8")
    assert written == page(), "'python -m rigrunner_testing.page > docs/reference/conformance.md'"


def test_every_kind_has_checks_with_demand_and_fix():
    for kind in (record.name for record in load_registry().kinds):
        assert len(checks(kind)) > len(checks("no such kind")) > 0
        assert all(check.holds.endswith(".") and check.fix for check in checks(kind))
        names = [check.name for check in checks(kind)]
        assert len(set(names)) == len(names)
