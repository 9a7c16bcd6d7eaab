"""The pages that are made from models and commands are those of the code."""

from __future__ import annotations

import json
import re
import runpy

import pytest

from helpers_docs import ROOT
from rigrunner.cli.main import rigrunner

REFERENCE = ROOT / "docs/reference"
language = runpy.run_path(str(REFERENCE / "language_pages.py"))
helps = runpy.run_path(str(REFERENCE / "help_page.py"))
requests = runpy.run_path(str(REFERENCE / "requests_page.py"))


def test_the_pages_of_keys_are_those_of_the_schemas():
    for name, text in language["pages"]().items():
        again = "python docs/reference/language_pages.py docs/reference"
        assert (REFERENCE / name).read_text(encoding="utf-8") == text, again


def test_the_page_of_helps_is_that_of_the_commands():
    again = "python docs/reference/help_page.py docs/reference"
    assert (REFERENCE / "help.md").read_text(encoding="utf-8") == helps["page"](), again


def test_the_page_of_requests_is_that_of_the_panel():
    again = "python docs/reference/requests_page.py docs/reference"
    assert (REFERENCE / "panel-requests.md").read_text(encoding="utf-8") == requests["page"](), (
        again
    )


@pytest.mark.parametrize("name", language["LANGUAGES"])
def test_every_key_of_every_model_is_on_its_page(name):
    """Found by a walk of its own over the schema."""
    schema = json.loads((ROOT / f"procedures/{name}.schema.json").read_text(encoding="utf-8"))

    def keys(node):
        if isinstance(node, dict):
            # what only refines another key by a condition is no key of its own
            yield from node.get("properties", {})
            for key, each in node.items():
                if key not in {"if", "then"}:
                    yield from keys(each)
        elif isinstance(node, list):
            for each in node:
                yield from keys(each)

    (page,) = (text for file, text in language["pages"]().items() if file.endswith(name + ".md"))
    assert set(keys(schema)) == set(re.findall(r"^\| `(\w+)` \|", page, re.MULTILINE))


def test_every_command_has_its_section():
    text = (REFERENCE / "help.md").read_text(encoding="utf-8")
    tops = re.findall(r"^## `rigrunner ([\w-]+)", text, re.MULTILINE)
    assert list(dict.fromkeys(tops)) == list(rigrunner.summaries)


def test_a_value_is_told_in_words():
    page = language["Language"]("procedure", "a procedure")
    assert page._value({"type": "integer", "minimum": 1}) == "whole number, at least 1"
    assert page._value({"enum": ["yes", "no", True, False]}) == "`yes`, `no`"
    assert page._value({"$ref": "#/$defs/Step"}) == "[Step](#step)"
    assert page._value({"type": ["array", "string"], "items": {"$ref": "#/$defs/time"}}) == (
        "list of time"
    )
