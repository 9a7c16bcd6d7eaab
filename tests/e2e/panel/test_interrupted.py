"""A run whose process was killed: resumed, or closed as it is, at the screen."""

from __future__ import annotations

import os
import signal

import pytest
from playwright.sync_api import expect

from e2e.helpers_panel import started_by
from e2e.panel.helpers_screen import ENDLESS, NAME


def kill_the_run(panel):
    """Kill the process that has the rig as soon as it records; return the run's name."""
    (pid,) = (
        number
        for number, command in started_by(panel.process.pid).items()
        if "panel.jobs.main" in command
    )
    run = panel.get("state")["job"]["run"]
    os.kill(pid, signal.SIGKILL)
    panel.wait_for("finished")
    return run


def answer_yes(page):
    page.locator(".prompt").get_by_role("button", name="Yes").click()


@pytest.mark.thorough
def test_killed_run_is_resumed_from_the_panel_and_ends_sealed(screen, panel):
    page = screen.page
    screen.begin()
    panel.wait_for("running")
    run = kill_the_run(panel)
    page.wait_for_url(f"**#/runs/{run}")
    expect(page.locator(".banner.warn")).to_contain_text("ended with code -9")
    assert "rigrunner" not in page.locator("main").inner_text().replace("Rigrunner", "")

    page.get_by_role("link", name="History").click()
    row = page.locator(".runs tbody tr").first
    expect(row.locator(".mark")).to_have_text("Interrupted")
    row.locator("td").nth(3).click()
    page.get_by_role("button", name="Resume").click()
    page.keyboard.type("SN-17")  # a scanner is a keyboard: a scan here decides nothing
    page.keyboard.press("Enter")
    page.wait_for_timeout(300)
    assert panel.phase() == "finished"
    page.get_by_role("button", name="The rig is clear: resume").dblclick()
    page.wait_for_url("**#/run")
    answer_yes(page)
    screen.wait_for_result()
    expect(page.locator(".result-head .verdict")).to_contain_text("Pass")
    assert page.get_by_role("button", name="Resume").count() == 0
    stored = panel.get(f"runs/{run}")
    assert (stored["sealed"], stored["item"]["outcome"]) == (True, "completed")
    assert f"resume run by {NAME}" in " ".join(event["text"] for event in stored["events"])
    assert sum(item["run"] == run for item in panel.get("runs")["items"]) == 1


@pytest.mark.thorough
def test_killed_run_is_closed_as_it_is_with_a_reason(screen, panel):
    page = screen.page
    screen.begin(ENDLESS)
    panel.wait_for("running")
    run = kill_the_run(panel)
    page.wait_for_url(f"**#/runs/{run}")
    page.get_by_role("button", name="Close as it is").click()
    page.locator("#dialog-text").fill("the specimen broke")
    page.keyboard.press("Enter")
    expect(page.locator(".result-head .verdict-word")).to_have_text("Aborted")
    expect(page.get_by_role("button", name="Close as it is")).to_have_count(0)
    stored = panel.get(f"runs/{run}")
    assert (stored["sealed"], stored["item"]["interrupted"]) == (True, False)
    assert stored["reason"] == f"interrupted, and closed as it was by {NAME}: the specimen broke"
