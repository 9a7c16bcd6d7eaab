"""A question and an interlock in the middle of a run, answered by mouse and by keyboard."""

from __future__ import annotations

import pytest
from playwright.sync_api import expect

from e2e.panel.helpers_screen import ASKS, NAME, press_keys

RANGE = "is out of range (15 °C to 30 °C)"


@pytest.fixture
def asking(screen):
    """A run that asks for the temperature of the room; its load then trips an interlock."""
    screen.open()
    screen.choose(ASKS)
    screen.fill_in()
    screen.hurry()
    screen.check_rig()
    screen.start()
    screen.page.locator(".prompt", has_text="Temperature of the room").wait_for()
    return screen


def events_with(panel, word: str) -> list[str]:
    """Return the events of the newest run with that word in them."""
    run = panel.get("runs")["items"][0]["run"]
    texts = [event["text"] for event in panel.get(f"runs/{run}")["events"]]
    return [text for text in texts if word in text]


def expect_refusal(screen, *words: str) -> None:
    """Expect these words of refusal at the field, and the question still open."""
    note = screen.page.locator("#prompt-input-note")
    for word in words:
        expect(note).to_contain_text(word)
    expect(screen.page.locator("#prompt-input")).to_be_focused()
    expect(screen.page.locator(".notice")).to_have_count(0)


@pytest.mark.thorough
def test_question_and_interlock_by_mouse(asking, panel):
    page = asking.page
    expect(page.locator("#prompt-input-note")).to_have_text("in °C, 15 °C to 30 °C")
    for wrong, words in (
        ("warm", ("'warm",)),
        ("23 N", ("is a force, not a temperature",)),
        ("22,5", ("decimal comma", "22.5")),
        ("41", ("41 °C", RANGE)),
        ("", ("the answer is empty",)),
    ):
        page.locator("#prompt-input").fill(wrong)
        page.get_by_role("button", name="Enter", exact=True).click()
        expect_refusal(asking, *words)
    page.locator("#prompt-input").fill("296.15 K")
    page.get_by_role("button", name="Enter", exact=True).click()

    banner = page.locator(".banner", has_text="Paused")
    expect(banner).to_contain_text("tester.load is")
    expect(page.locator(".alarms.active")).to_contain_text("above 500 N")
    page.get_by_role("button", name="Resume").click()  # it is still tripped
    expect(banner).to_contain_text("not cleared yet")
    page.get_by_role("button", name="Continue anyway").click()
    page.get_by_role("button", name="Continue anyway").last.click()  # without a reason
    expect(page.locator(".dialog")).to_be_visible()
    page.get_by_label("Reason").fill("the load is meant")
    page.get_by_role("button", name="Continue anyway").last.click()
    asking.wait_for_result()

    expect(page.locator(".result-head .verdict-word")).to_contain_text("Pass")
    (answer,) = events_with(panel, "answered '296.15 K'")
    assert f"({NAME}" in answer
    (tripped,) = events_with(panel, "ALARM interlock heavy")
    assert "above 500 N" in tripped
    (override,) = events_with(panel, "override by")
    assert override.startswith(f"override by {NAME}")
    assert override.endswith("the load is meant")


@pytest.mark.thorough
def test_question_and_interlock_by_keyboard(asking, panel):
    page = asking.page
    press, write = page.keyboard.press, page.keyboard.type
    field = page.locator("#prompt-input")
    expect(field).to_be_focused()
    write("41")
    press("Enter")
    expect(page.locator("#prompt-input-note")).to_contain_text(RANGE)
    expect(field).to_be_focused()  # to be corrected in place
    press("Control+A")
    write("22.5")
    press("Enter")

    page.locator(".banner", has_text="Paused").wait_for()
    asking.focus_on("Continue anyway")
    press("Enter")
    press_keys(page, "the load is meant", 0.2)
    asking.wait_for_result()
    (override,) = events_with(panel, "override by")
    assert override.startswith(f"override by {NAME}")
    assert override.endswith("the load is meant")
    assert events_with(panel, "answered '22.5 °C'")
