"""The panel's tutorial works as written: the test presses what is bold in its numbered steps."""

from __future__ import annotations

import re
import shutil

import pytest
from playwright.sync_api import expect

from e2e.panel.helpers_screen import running_panel
from helpers_cli import call
from helpers_docs import ROOT

TUTORIAL = ROOT / "docs/tutorial/panel.md"
STEP = re.compile(
    r"^\d+\. (?P<verb>\w+) (?:`(?P<text>[^`]+)` into )?\*\*(?P<what>[^*]+)\*\*", re.MULTILINE
)


def do(page, verb, what, text):
    """Do a step of the tutorial."""
    match verb:
        case "Choose":
            page.locator(".item", has_text=what).first.click()
        case "Press":
            button = page.get_by_role("button", name=what, exact=True)
            button.or_(page.locator("summary", has_text=what)).last.click()
        case "Write":
            page.get_by_label(what, exact=True).fill(text)
        case "Untick":
            page.get_by_label(what).uncheck()
        case "See":
            expect(page.get_by_text(what).first).to_be_visible()
        case _:
            raise AssertionError(f"unknown verb: {verb}")


@pytest.mark.thorough
def test_tutorial_leads_to_a_certificate(new_screen, demo, tmp_path):
    """The no-load run is that of the demonstration; test_docs.py runs the command of the page."""
    steps = STEP.findall(TUTORIAL.read_text(encoding="utf-8"))
    numbered = re.findall(r"^\d+\. ", TUTORIAL.read_text(encoding="utf-8"), re.MULTILINE)
    assert len(steps) == len(numbered) == 23
    assert call("init", tmp_path).code == 0
    shutil.copytree(demo.no_load, tmp_path / "runs" / demo.no_load.name)
    with running_panel(tmp_path) as panel:
        screen = new_screen(panel)
        screen.open()
        for verb, text, what in steps:
            do(screen.page, verb, what, text)
        run = panel.get("runs")["items"][0]
        assert (run["specimen"], run["operator"]) == ("B-17", "Ann Jones")
