"""When the panel answers slowly, the screen shows that it is working."""

from __future__ import annotations

import pytest
from playwright.sync_api import expect

from e2e.panel.helpers_screen import BENCH, LOADED

SLOW = {"offline": False, "latency": 2500, "downloadThroughput": -1, "uploadThroughput": -1}
"""Milliseconds for each answer: eight times the delay after which a bar is shown."""


@pytest.fixture
def slow(screen):
    """A page with slow answers, with a procedure and a station chosen."""
    screen.open()
    screen.choose(LOADED)
    page = screen.page
    page.context.new_cdp_session(page).send("Network.emulateNetworkConditions", SLOW)
    return page


def expect_progress(page):
    """Expect the bar of progress, and that it disappears."""
    bar = page.locator(".working progress")
    expect(bar.first).to_be_visible()
    expect(bar).to_have_count(0)


@pytest.mark.thorough
def test_every_page_shows_that_it_loads(slow, panel):
    first, *_, last = sorted(run.name for run in panel.runs.iterdir() if run.is_dir())
    for place in (
        *("#/history", "#/procedures", "#/", "#/setup", "#/trends"),
        *(f"#/runs/{last}", f"#/compare/{first}/{last}", f"#/overlay/{first}/{last}"),
        "#/procedures/procedures%2Fquick_torque.yaml",
    ):
        slow.evaluate("place => { location.hash = place; }", place)
        expect_progress(slow)


@pytest.mark.thorough
def test_adding_a_list_shows_progress(slow, panel):
    slow.evaluate("location.hash = '#/queue'")
    slow.locator("#queue-procedure").select_option(label=LOADED)
    slow.locator("#input-type").fill("GE20")
    slow.locator(".queue-add details > summary").click()
    slow.locator("#queue-list").fill("SN-1\nSN-2")
    slow.locator(".queue-add details .primary").click()
    slow.locator("#dialog-text").fill("Ann")
    slow.keyboard.press("Enter")
    expect_progress(slow)
    slow.locator(".queue-table tbody tr").nth(1).wait_for()
    assert len(panel.get("queue", BENCH)["entries"]) >= 2
