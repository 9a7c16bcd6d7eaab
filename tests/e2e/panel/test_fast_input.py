"""Clicks and typing that are faster than the answers of the panel."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import expect

from e2e.panel.helpers_screen import LOADED, NO_LOAD, running_panel

TWO_QUESTIONS = "Torque after two questions"


class HeldRequests:
    """Requests to an address, which wait for their answers until they are released."""

    def __init__(self, page, address):
        self.page, self.address = page, re.compile(address)
        self.routes = []
        page.route(self.address, self._hold)

    def _hold(self, route):
        self.routes.append(route)

    def wait_for(self, count):
        """Wait until there are so many of them."""
        while len(self.routes) < count:
            self.page.wait_for_timeout(20)

    def release(self, index):
        """Release one of them, and wait until the page has shown its answer."""
        with self.page.expect_response(self.address) as response:
            self.routes[index].continue_()
        response.value.finished()
        self.page.evaluate("new Promise((done) => setTimeout(done, 200))")


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("place", "label", "selector"),
    [
        ("#/", "Search procedures", ".card:first-child .item"),
        ("#/procedures", "Search procedures", ".runs tbody tr"),
        ("#/history", "Search specimen", ".runs tbody tr"),
    ],
)
def test_late_answer_does_not_replace_a_newer_one(screen, place, label, selector):
    page = screen.page
    screen.open(place)
    rows = page.locator(selector)
    expect(rows.nth(1)).to_be_visible()
    requests = HeldRequests(page, "search=torque")
    field = page.get_by_label(re.compile(label))
    field.fill("torque")
    requests.wait_for(1)
    field.fill("no such thing")
    expect(rows).to_have_count(0)
    requests.release(0)
    expect(rows).to_have_count(0)


@pytest.mark.thorough
def test_focus_stays_when_the_list_is_reloaded(screen):
    page = screen.page
    screen.open()
    chosen = page.locator(".item", has_text=LOADED).locator("input")
    expect(page.locator(".item", has_text=NO_LOAD)).to_be_visible()
    requests = HeldRequests(page, "search=Quick")
    page.get_by_label("Search procedures").fill("Quick starting")
    requests.wait_for(1)
    chosen.focus()
    requests.release(0)
    expect(page.locator(".item", has_text=NO_LOAD)).to_have_count(0)
    expect(chosen).to_be_focused()


@pytest.mark.thorough
def test_double_click_on_start_starts_one_run(screen, panel):
    screen.open()
    screen.choose()
    screen.fill_in()
    screen.check_rig()
    screen.page.get_by_role("button", name="Start", exact=True).dblclick()
    panel.wait_for("asking")
    screen.page.locator(".prompt").wait_for()
    assert panel.get("queue")["entries"] == []


@pytest.mark.thorough
def test_earlier_answer_does_not_replace_fields_of_newest_choice(screen):
    screen.open("#/queue")
    page = screen.page
    page.locator("#queue-procedure").select_option(label=LOADED)
    lot = page.get_by_label("Lot")
    lot.wait_for()
    requests = HeldRequests(page, r"/plan\?rig=")
    for procedure in (NO_LOAD, LOADED, NO_LOAD, LOADED):
        page.locator("#queue-procedure").select_option(label=procedure)
    requests.wait_for(4)
    requests.release(3)
    lot.focus()
    requests.release(1)
    expect(lot).to_be_focused()


@pytest.mark.thorough
def test_double_click_and_scan_do_not_answer_a_question(new_screen, lab):
    text = (lab / "procedures/quick_torque.yaml").read_text(encoding="utf-8")
    text = text.replace(LOADED, TWO_QUESTIONS).replace("id: QUICK-ST", "id: QUICK-TWO")
    second = "main:\n  - confirm: {text: Hands out?, unattended: yes}\n"
    two = text.replace("main:\n", second, 1)
    (lab / "procedures/two.yaml").write_text(two, encoding="utf-8")
    with running_panel(lab) as panel:
        screen = new_screen(panel)
        page = screen.page
        screen.open()
        screen.choose(TWO_QUESTIONS)
        screen.fill_in()
        screen.hurry()
        screen.check_rig()
        page.get_by_role("button", name="Start", exact=True).click()
        first = page.locator(".prompt-text").inner_text()
        page.keyboard.type("SN-17")  # a scanner is a keyboard
        page.keyboard.press("Enter")
        page.wait_for_timeout(500)
        assert page.locator(".prompt-text").inner_text() == first
        page.locator(".prompt").get_by_role("button", name="Yes").click()
        expect(page.locator(".prompt-text")).to_have_text("Hands out?")
        yes = page.locator(".prompt").get_by_role("button", name="Yes")
        yes.dispatch_event("click", {"detail": 2})  # the second click, on the new question
        page.wait_for_timeout(500)
        expect(page.locator(".prompt-text")).to_have_text("Hands out?")
        yes.click()
        screen.wait_for_result()
