"""The pages generated from models and commands match the code."""

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


def test_key_pages_match_the_schemas():
    for name, text in language["pages"]().items():
        command = "python docs/reference/language_pages.py docs/reference"
        assert (REFERENCE / name).read_text(encoding="utf-8") == text, command


def test_help_page_matches_the_commands():
    command = "python docs/reference/help_page.py docs/reference"
    assert (REFERENCE / "help.md").read_text(encoding="utf-8") == helps["page"](), command


def test_requests_page_matches_the_panel():
    command = "python docs/reference/requests_page.py docs/reference"
    assert (REFERENCE / "panel-requests.md").read_text(encoding="utf-8") == requests["page"](), (
        command
    )


@pytest.mark.parametrize("name", language["LANGUAGES"])
def test_every_key_of_every_model_is_on_its_page(name):
    """Found by a separate walk over the schema."""
    schema = json.loads((ROOT / f"procedures/{name}.schema.json").read_text(encoding="utf-8"))

    def keys(node):
        if isinstance(node, dict):
            # a condition that only refines another key is not a key itself
            yield from node.get("properties", {})
            for key, value in node.items():
                if key not in {"if", "then"}:
                    yield from keys(value)
        elif isinstance(node, list):
            for item in node:
                yield from keys(item)

    (page,) = (text for file, text in language["pages"]().items() if file.endswith(name + ".md"))
    assert set(keys(schema)) == set(re.findall(r"^\| `(\w+)` \|", page, re.MULTILINE))


def test_every_command_has_its_section():
    text = (REFERENCE / "help.md").read_text(encoding="utf-8")
    tops = re.findall(r"^## `rigrunner ([\w-]+)", text, re.MULTILINE)
    assert list(dict.fromkeys(tops)) == list(rigrunner.summaries)


def test_value_types_are_described_in_words():
    page = language["Language"]("procedure", "a procedure")
    assert page._value({"type": "integer", "minimum": 1}) == "whole number, at least 1"
    assert page._value({"enum": ["yes", "no", True, False]}) == "`yes`, `no`"
    assert page._value({"$ref": "#/$defs/Step"}) == "[Step](#step)"
    assert page._value({"type": ["array", "string"], "items": {"$ref": "#/$defs/time"}}) == (
        "list of time"
    )
