"""The program that makes the numbers of a document again."""

from __future__ import annotations

import pytest

from rigrunner.api.hooks import AnalysisRecord
from rigrunner.documents.verifying.revisions import made_with
from rigrunner.registry import Plugin, Provider, Registry
from rigrunner.run.provenance import PROVIDERS

RECORD = AnalysisRecord(
    name="wear", help="Made up.", factory=lambda _: None, yields=lambda _: (), measurand=""
)
REGISTRY = Registry([Plugin("analysis", RECORD, Provider("lab-wear", "2.0"))])
THEN = {"Rigrunner": "0.1.0", PROVIDERS: "lab-other 3.0, lab-wear 1.2, rigrunner-plugins 0.1.0"}


@pytest.mark.parametrize(
    ("software", "name", "words"),
    [
        (THEN, "wear", "version 1.2 of lab-wear"),
        (THEN, "", "version 0.1.0"),  # a method of Rigrunner itself
        (THEN, "unknown", f"what was installed then ({THEN[PROVIDERS]})"),
        ({"Rigrunner": "0.1.0"}, "wear", "what was installed then (version 0.1.0)"),
    ],
)
def test_method_is_made_again_by_what_was_installed(software, name, words):
    assert made_with(software, "analysis", name, REGISTRY) == words
