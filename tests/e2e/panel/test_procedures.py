"""Procedures edited on the screen: checked as they are typed, completed, saved by two at once."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import expect

from e2e.panel.helpers_screen import STATION, axe_script
from e2e.panel.test_accessibility import DESK, assert_on_one_screen, look

QUICK = "procedures/quick_torque.yaml"
ADDRESS = "#/procedures/procedures%2Fquick_torque.yaml"
UPRIGHT = {"width": 820, "height": 1180}


def open_text(screen):
    screen.open(ADDRESS)
    page = screen.page
    page.wait_for_selector(".problems-box .good-text")
    page.wait_for_load_state("networkidle")  # the schema is there
    return page


def go_to_the_end(page):
    """Scroll to the end: of a long text, only the visible part is on the page."""
    page.locator(".cm-content").click()
    page.keyboard.press("Control+End")


def type_at_the_end(page, text):
    go_to_the_end(page)
    page.keyboard.type(text, delay=20)


@pytest.mark.thorough
def test_mistake_is_shown_at_its_line_and_keys_are_completed(new_screen, panel):
    page = open_text(new_screen(panel))
    type_at_the_end(page, "# a remark\nint")
    options = page.locator(".cm-tooltip-autocomplete li")
    expect(options).to_have_count(1)
    expect(options).to_contain_text("interlocks")
    expect(page.locator(".cm-completionInfo")).not_to_be_empty()
    page.wait_for_timeout(100)  # within 75 ms of its opening, Enter is a new line
    page.keyboard.press("Enter")
    page.keyboard.type("1 N")
    # Not the problem of the half-typed key, which is at another line.
    expect(page.locator(".problems")).to_contain_text("'1 N'")
    line = page.locator(".problems button").first
    number = re.search(r"\d+", line.text_content())[0]
    expect(page.locator(".cm-lint-marker-error")).to_have_count(1)
    page.keyboard.press("Control+Home")
    line.click()
    gutter = page.locator(".cm-gutterElement.cm-activeLineGutter").first
    expect(gutter).to_have_text(number)
    for _ in range(5):
        page.keyboard.press("Control+z")
    page.keyboard.press("Control+Home")
    page.locator(".cm-content").get_by_text("procedure/2").wait_for()
    word = page.locator(".cm-content").get_by_text("measurand").first
    word.hover()
    expect(page.locator(".cm-help")).to_contain_text("measurand")


@pytest.mark.thorough
def test_procedure_is_saved_and_approved_and_shows_its_changes(new_screen, panel):
    screen = new_screen(panel)
    page = open_text(screen)
    file = panel.folder / QUICK
    before = file.read_text(encoding="utf-8")
    page.get_by_text("cycles: 15").first.wait_for()
    type_at_the_end(page, "description: Slower\n")
    expect(page.locator(".editor-side .changes")).to_contain_text("Slower")
    page.locator("#procedure-station").select_option(label=STATION)
    preview = page.locator(".editor-side details", has_text="Duration")
    preview.locator("summary").first.click()  # the plan of the text as it is typed
    expect(preview).to_contain_text("QUICK-ST")
    go_to_the_end(page)
    page.keyboard.press("Control+s")
    screen.say_name("Ann")
    expect(page.get_by_role("button", name="Save", exact=True)).to_be_disabled()
    assert file.read_text(encoding="utf-8") == f"{before}description: Slower\n"
    other_page = open_text(new_screen(panel))  # another person sees the approval
    page.get_by_role("button", name="Approve").click()
    name = page.locator("#dialog-text")
    expect(name).to_have_value("Ann")  # the editor is not always the approver
    page.keyboard.type("Bob")
    page.keyboard.press("Enter")
    for view in (page, other_page):
        expect(view.locator(".procedure .head")).to_contain_text("approved by Bob")
        expect(view.get_by_role("button", name="Approve")).to_be_disabled()
    assert file.with_suffix(".approval.json").is_file()


@pytest.mark.thorough
def test_concurrent_editors_are_warned_and_lose_nothing(new_screen, panel):
    ann, bob = new_screen(panel), new_screen(panel)
    first, second = open_text(ann), open_text(bob)
    expect(first.locator(".editor-notes")).to_contain_text("Somebody at another screen has this")
    type_at_the_end(second, "# Bob\n")
    type_at_the_end(first, "# Ann\n")
    first.keyboard.press("Control+s")
    ann.say_name("Ann")
    expect(first.get_by_role("button", name="Save", exact=True)).to_be_disabled()
    warning = second.locator(".editor-notes .warn")
    expect(warning).to_contain_text("changed by Ann")
    second.keyboard.press("Control+s")
    bob.say_name("Bob")
    expect(warning).to_contain_text("has not been saved")
    file = panel.folder / QUICK
    assert file.read_text(encoding="utf-8").endswith("# Ann\n")
    second.reload()
    second.wait_for_selector(".problems-box .good-text")
    go_to_the_end(second)
    expect(second.locator(".cm-content")).to_contain_text("# Bob")
    expect(warning).to_contain_text("changed by Ann")
    second.get_by_role("button", name="Overwrite the file").click()
    expect(second.get_by_role("button", name="Save", exact=True)).to_be_disabled()
    assert file.read_text(encoding="utf-8").endswith("# Bob\n")
    expect(first.locator(".editor-notes")).to_contain_text("Bob has this procedure open")
    expect(first.locator(".notice")).to_contain_text("changed by Bob")  # nothing was typed here
    go_to_the_end(first)
    expect(first.locator(".cm-content")).to_contain_text("# Bob")
    expect(first.locator(".editor-notes .warn")).to_have_count(0)
    type_at_the_end(first, "# Ann, again\n")
    file.write_text(file.read_text(encoding="utf-8") + "# an editor\n", encoding="utf-8")
    expect(first.locator(".editor-notes .warn")).to_contain_text("changed by another program")
    first.get_by_role("button", name="Discard mine").click()
    go_to_the_end(first)
    expect(first.locator(".cm-content")).to_contain_text("# an editor")
    expect(first.locator(".editor-notes .warn")).to_have_count(0)


@pytest.mark.thorough
def test_problems_are_listed_in_the_order_of_their_lines(new_screen, panel):
    page = open_text(new_screen(panel))
    go_to_the_end(page)
    page.keyboard.press("Control+a")
    page.keyboard.insert_text("rigrunner: procedure/2\nid: 'A B'\nmain:\n  - setle: {}\nuse: {}\n")
    lines = page.locator(".problems .link")
    expect(lines.last).to_have_text("Line 5")
    numbers = [int(text.removeprefix("Line ")) for text in lines.all_inner_texts()]
    assert numbers == sorted(numbers)
    assert len(numbers) > 3


@pytest.mark.thorough
def test_shipped_procedure_is_changed_in_a_copy(new_screen, panel):
    screen = new_screen(panel)
    screen.open("#/procedures/gauge_rr")
    page = screen.page
    expect(page.locator(".procedure .head")).to_contain_text("Shipped")
    expect(page.get_by_role("button", name="Approve")).to_be_hidden()
    page.get_by_role("button", name="Save a copy").click()
    page.locator("#dialog-text").fill("procedures/mine.yaml")
    page.keyboard.press("Enter")
    screen.say_name()
    page.wait_for_url("**/procedures/procedures%2Fmine.yaml")
    expect(page.get_by_role("button", name="Approve")).to_be_visible()
    assert (panel.folder / "procedures/mine.yaml").is_file()


@pytest.mark.thorough
def test_procedure_pages_are_accessible(new_screen, panel, pictures):
    for locale in ("en-GB", "de-DE"):
        screen = new_screen(panel, locale=locale)
        page, violations = screen.page, []
        page.add_init_script(path=axe_script())
        screen.open("#/procedures")
        page.wait_for_selector(".runs tbody tr")
        check(page, pictures, f"procedures-{locale}", violations)
        open_text(screen)
        type_at_the_end(page, "xx: 1")
        page.locator(".problems").wait_for()
        check(page, pictures, f"procedure-{locale}", violations)
        assert violations == []


def check(page, pictures, name, violations):
    for size, label in ((DESK, "desk"), (UPRIGHT, "upright")):
        page.set_viewport_size(size)
        look(page, pictures, f"{name}-{label}", violations)
        assert_on_one_screen(page)
