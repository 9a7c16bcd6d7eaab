"""Phrases that the glossary replaces stay out of every text that people see."""

from __future__ import annotations

import re
from functools import cache

import pytest

from helpers_docs import ROOT

REPLACED = {
    ", allowed is": "expected; or '45 °C is out of range (15 to 30 °C)'",
    "how surely": "with its measurement uncertainty",
    "broken off": "interrupted",
    "go on with a run": "resume a run",
    "taken up again": "resumed",
    "so-manieth": "n-th",
    "befall": "affect",
    "mend it": "fix it",
    "is mended": "is fixed",
    "what each can be told": "its settings",
    "at the pace of the signal": "real time",
    "No run is like that": "No matches",
    "Nothing is called so": "No matches",
    "is called so": "has this name",
    "none of its own": "excluded",
    "for who took it": "where it was copied from",
    "Take the rig": "Connect",
    "The rig's part": "No-load (tare) torque",
    "what checks and uncertainties are worth": "validate uncertainty coverage",
    "is going on": "is running",
    "told of": "reported",
    "held     ": "OK",
}
"""A phrase, in any case, and its replacement."""

FOLDERS = ("runner", "plugins", "reports", "procedures", "docs")
SUFFIXES = {".py", ".md", ".json", ".yaml", ".js", ".jinja", ".j2", ".html", ".css"}


@cache
def texts():
    """Return each text by its path, in lower case and with plain apostrophes."""
    return {
        str(path.relative_to(ROOT)): path.read_text(encoding="utf-8").replace("\u2019", "'").lower()
        for path in paths()
    }


def paths():
    for folder in FOLDERS:
        for path in sorted((ROOT / folder).rglob("*")):
            excluded = {"vendor", "decisions"} & set(path.parts)
            if path.suffix in SUFFIXES and not excluded:
                yield path
    yield ROOT / "README.md"


@pytest.mark.parametrize("phrase", REPLACED)
def test_no_text_has_a_replaced_phrase(phrase):
    first, *_ = phrase.lower().split()
    words = re.sub(r"(?<=\w)\\ (?=\w)", r"\\s+", re.escape(phrase.lower()))  # a line may end there
    pattern = re.compile(rf"(?<!\w){words}(?!\w)")
    places = [
        f"{path}:{text[: match.start()].count(chr(10)) + 1}"
        for path, text in texts().items()
        if first in text
        for match in pattern.finditer(text)
    ]
    assert places == [], f"say instead: {REPLACED[phrase]}"


@pytest.mark.parametrize("name", ["told", "found", "said"])
def test_variables_are_named_by_nouns(name):
    """A participle does not say what a value is; see CONTRIBUTING."""
    bound = re.compile(rf"^\s*{name} = |\bfor {name} in\b|\b{name} := ", re.MULTILINE)
    files = [path for path, text in texts().items() if path.endswith(".py") and bound.search(text)]
    assert not files
