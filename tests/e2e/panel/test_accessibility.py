"""Every page in both themes: a picture to look at, and the violations that axe-core reports."""

from __future__ import annotations

import pytest
from playwright.sync_api import expect

from e2e.panel.helpers_screen import (
    ENDLESS,
    LOADED,
    NAME,
    STATION,
    axe_script,
    running_panel,
    settle,
)
from rigrunner_plugins.loopback.chamber import running_chamber

GRAVE = {"serious", "critical"}
DESK = {"width": 1280, "height": 720}
TABLET = {"width": 1024, "height": 768}


COLOUR_RULES = ["color-contrast", "link-in-text-block"]
"""Rules of axe-core for colours; the others give the same in every theme."""


def look(page, pictures, name: str, violations: list[str]) -> None:
    """Take a picture in each theme, and let axe-core judge the page."""
    for theme, rules in (("dark", {"runOnly": COLOUR_RULES}), ("light", {})):
        page.emulate_media(color_scheme=theme)
        expect(page.locator("html")).to_have_attribute("data-theme", theme)
        settle(page)
        page.screenshot(path=pictures / f"{name}-{theme}.png")
        options = {"resultTypes": ["violations"], **rules}
        result = page.evaluate("options => axe.run(document, options)", options)
        violations += [
            f"{name}, {theme}: {item['id']}: {item['nodes'][0]['html'][:120]}"
            for item in result["violations"]
            if item["impact"] in GRAVE
        ]


def assert_on_one_screen(page) -> None:
    """The page fits the window without scrolling."""
    size = "[document.documentElement.scrollWidth, document.documentElement.scrollHeight]"
    width, height = page.evaluate(size)
    assert width <= page.viewport_size["width"]
    assert height <= page.viewport_size["height"]


@pytest.mark.thorough
def test_every_page_is_accessible(  # noqa: PLR0915  (a walk through all pages)
    screen, panel, pictures
):
    page, violations = screen.page, []
    page.add_init_script(path=axe_script())

    def check(name: str, *, on_tablet: bool = False) -> None:
        look(page, pictures, name, violations)
        if on_tablet:
            page.set_viewport_size(TABLET)
            look(page, pictures, f"{name}-tablet", violations)
            assert_on_one_screen(page)
            page.set_viewport_size(DESK)
            assert_on_one_screen(page)

    screen.open()
    page.wait_for_selector(".item")
    check("choose")
    screen.choose(LOADED)
    page.get_by_label("Bearing serial number").fill("DEMO-0001")
    page.locator(".field.warn").wait_for()
    check("tested", on_tablet=True)
    page.get_by_role("link", name="Choose another").click()
    screen.choose(ENDLESS)
    page.locator(".preflight > .button").click()
    page.wait_for_selector("#dialog-text")
    check("name")
    screen.say_name()
    screen.fill_in()
    page.get_by_text("Ready to start.").wait_for()
    check("setup", on_tablet=True)
    page.get_by_role("button", name="Start", exact=True).click()
    page.wait_for_selector(".prompt")
    check("prompt")
    page.locator(".prompt").get_by_role("button", name="Yes").click()
    screen.wait_for_compensation()
    check("run", on_tablet=True)
    page.keyboard.press("F8")
    page.locator(".banner", has_text="Paused").wait_for()
    check("paused")
    page.get_by_role("button", name="STOP").click()
    screen.wait_for_result()
    check("stopped")
    page.get_by_role("link", name="History").click()
    page.wait_for_selector(".runs tbody tr")
    check("history")
    page.locator(".runs tbody tr", has_text="DEMO-0001").get_by_role("link").click()
    page.wait_for_selector(".result-head .verdict.pass")
    page.get_by_text("Issue a certificate").click()
    check("result")
    page.go_back()
    page.wait_for_selector(".runs tbody tr")
    boxes = page.locator(".runs tbody input")
    boxes.nth(0).check()
    boxes.nth(1).check()
    page.get_by_role("button", name="Compare (2 of 2)").click()
    page.locator(".compare .card").first.wait_for()
    check("compare")
    page.get_by_role("link", name="Manual mode").click()
    page.locator(".preflight > .button").click()
    page.get_by_role("button", name="Connect").click()
    page.wait_for_selector(".drive")
    frequency = page.get_by_label("Swing frequency (Hz)")
    frequency.fill("10")
    frequency.press("Enter")
    screen.wait_for_compensation()
    check("manual", on_tablet=True)
    page.get_by_role("button", name="STOP").click()
    panel.wait_for("finished")
    assert violations == []


@pytest.mark.thorough
def test_state_and_stop_are_visible_on_an_upright_tablet(new_screen):
    screen = new_screen(viewport={"width": 820, "height": 1180}, locale="de-DE")
    screen.open()
    page = screen.page
    page.wait_for_selector(".item")
    assert_on_one_screen(page)
    covered = page.evaluate(
        """() => [...document.querySelectorAll('.chip, .bar .button:not([hidden]), .stop')]
            .filter((element) => {
                const box = element.getBoundingClientRect();
                const middle = (box.top + box.bottom) / 2;
                return ![box.left + 8, box.right - 8].every(
                    (x) => element.contains(document.elementFromPoint(x, middle)));
            })
            .map((element) => element.textContent)"""
    )
    assert covered == []


@pytest.mark.thorough
def test_theme_follows_the_system_or_the_choice(new_screen):
    screen = new_screen(color_scheme="dark")
    screen.open()
    page, choice = screen.page, screen.page.get_by_label("Colours")

    def background(theme):
        expect(page.locator("html")).to_have_attribute("data-theme", theme)
        return page.evaluate("getComputedStyle(document.body).backgroundColor")

    dark = background("dark")
    page.emulate_media(color_scheme="light")
    light = background("light")
    assert light != dark
    choice.select_option("dark")
    assert background("dark") == dark
    choice.select_option("auto")
    assert background("light") == light


CUT_OFF = """(selector) => [...document.querySelectorAll(selector)]
    .filter((e) => e.getClientRects().length && e.scrollWidth > e.clientWidth + 1)
    .map((e) => e.textContent.slice(0, 80))"""
"""The texts of selected elements that are wider than their frames."""


@pytest.mark.thorough
def test_plan_and_channels_fit_their_frames(new_screen, lab):
    station = lab / "station.yaml"
    text = station.read_text(encoding="utf-8")
    name = "Temperature chamber and ohmmeter on loopback"
    station.write_text(text.replace(f"title: {STATION}", f"title: {name}"), encoding="utf-8")
    with running_panel(lab) as panel:
        screen = new_screen(panel, locale="de-DE")
        page = screen.page
        screen.open()
        page.wait_for_selector(".item")
        page.locator(".item", has_text=LOADED).click()
        page.locator(".item", has_text=name).first.click()
        page.get_by_role("button", name="Weiter", exact=True).click()
        page.get_by_text("Zu erwartende Messwerte von tester.torque, höchstens").wait_for()
        assert page.evaluate(CUT_OFF, ".setup .card") == []
        page.get_by_role("link", name="Handbetrieb").click()
        page.locator(".preflight > .button").click()
        screen.say_name()
        page.get_by_role("button", name="Verbinden").click()
        page.get_by_role("button", name="Kanäle").click()
        page.set_viewport_size({"width": 820, "height": 1180})
        expect(page.locator(".channels tbody tr").first).to_be_visible()
        assert page.evaluate(CUT_OFF, ".channels") == []
        assert page.locator(".holder").bounding_box()["width"] > 60, "a letter a line"
        page.get_by_role("button", name="STOPP").click()
        panel.wait_for("finished")


@pytest.mark.thorough
def test_figures_beside_an_added_plot_have_room_for_their_axes(new_screen, lab):
    with running_chamber() as bench:
        (lab / "chamber.yaml").write_text(bench.station(), encoding="utf-8")
        with running_panel(lab) as panel:
            screen = new_screen(panel)
            page = screen.page
            screen.open(station="chamber.yaml")
            screen.choose("Resistance of a Pt100", "Temperature chamber")
            page.get_by_label("Serial number of the sensor").fill("PT-1")
            page.get_by_label("Operator").fill(NAME)
            page.locator(".preflight > .button").click()
            page.get_by_text("Ready to start.").wait_for()
            page.get_by_role("button", name="Start", exact=True).click()
            screen.wait_for_result()
            screen.open("#/run", station="chamber.yaml")
            page.get_by_role("button", name="Plots").click()
            page.get_by_role("button", name="Add plot").click()
            hosts = page.locator(".result-plots .plot-host")
            expect(hosts).to_have_count(2)
            heights = hosts.evaluate_all("hosts => hosts.map((host) => host.clientHeight)")
            assert min(heights) > 60
            expect(page.locator(".run-foot")).to_contain_text("This run has ended.")
            expect(page.locator(".now")).to_have_text("Finished")
            drive = page.locator(".readout", has_text="temperature").first
            expect(drive).to_contain_text("read")
            expect(drive).not_to_contain_text("set")
