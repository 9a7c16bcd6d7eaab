"""The run continues without its browser, and hostile text stays text."""

from __future__ import annotations

from contextlib import suppress

import psutil
import pytest
from playwright.sync_api import Error, expect

from e2e.panel.helpers_screen import (
    ENDLESS,
    NAME,
    NO_LOAD,
    OVERDUE,
    STATION,
    Screen,
    browser_path,
    free_port,
    running_panel,
    wait_until,
)

LOST = "Bench whose connection breaks"
HOSTILE = "<img src=x onerror=window.hacked=1>\u05d0 \U0001f525" + "x" * 60


@pytest.mark.thorough
def test_reload_shows_the_true_state_at_once(screen):
    page = screen.page
    screen.begin(ENDLESS)
    page.locator(".step.running", has_text="at 20 Hz").wait_for()
    page.reload()
    first = page.wait_for_selector("header .chip:not(.disconnected)")
    assert "running" in first.get_attribute("class").split()
    expect(page.locator(".step.done").first).to_be_visible()
    expect(page.locator(".holder")).to_contain_text("you")  # the tab keeps its control
    page.get_by_role("button", name="STOP").click()
    screen.wait_for_result()


@pytest.mark.thorough
def test_second_browser_watches_and_takes_over_on_record(new_screen, panel):
    first, second = new_screen(), new_screen()
    first.open()
    first.choose()
    first.fill_in()
    first.hurry()
    first.check_rig()
    first.page.get_by_role("button", name="Start", exact=True).click()
    panel.wait_for("asking")
    second.open()
    second.page.wait_for_selector(".page.run")
    assert NAME in second.page.locator(".holder").inner_text()
    second.page.get_by_role("button", name="Take control").click()
    second.say_name("Bob Moss")
    second.page.get_by_role("button", name="Take over").click()
    first.page.locator(".holder", has_text="Bob Moss").wait_for()
    second.page.locator(".holder", has_text="you").wait_for()
    second.page.locator(".prompt").get_by_role("button", name="Yes").click()
    second.wait_for_result()
    run = panel.get("runs")["items"][0]["run"]
    assert "Bob Moss" in str(panel.get(f"runs/{run}")["events"])


@pytest.mark.thorough
def test_same_person_in_another_tab_needs_no_take_over(new_screen, panel):
    first, second, third = new_screen(), new_screen(), new_screen()

    def take_control(screen, name):
        screen.open()
        screen.page.get_by_role("button", name="Take control").click()
        screen.say_name(name)

    take_control(first, NAME)
    first.page.locator(".holder", has_text="you").wait_for()
    first.page.close()
    wait_until(lambda: not panel.get("state")["control"]["connected"])
    take_control(second, NAME)
    second.page.locator(".holder", has_text="you").wait_for()
    take_control(third, "Bob Moss")
    expect(third.page.locator(".dialog")).to_contain_text(f"Take over from {NAME}?")


@pytest.mark.thorough
def test_run_continues_when_the_browser_is_killed(chromium, panel, tmp_path):
    context = chromium.browser_type.launch_persistent_context(
        tmp_path / "profile", executable_path=browser_path(), args=["--no-sandbox", "--disable-gpu"]
    )
    screen = Screen(context.pages[0], panel)
    screen.begin(specimen="KILLED-1")
    panel.wait_for("running")
    for process in psutil.process_iter(["cmdline"]):
        if str(tmp_path / "profile") in " ".join(process.info["cmdline"] or ()):
            with suppress(psutil.NoSuchProcess):
                process.kill()
    panel.wait_for("finished")
    newest = panel.get("runs")["items"][0]
    assert (newest["specimen"], newest["outcome"]) == ("KILLED-1", "completed")
    with suppress(Error):
        context.close()


@pytest.mark.thorough
def test_run_continues_without_any_browser(new_screen, panel):
    screen = new_screen()
    screen.begin(specimen="ALONE-1", real_time=False)
    screen.page.close()
    panel.wait_for("finished")
    newest = panel.get("runs")["items"][0]
    assert (newest["specimen"], newest["outcome"], newest["verdict"]) == (
        "ALONE-1",
        "completed",
        "pass",
    )


@pytest.mark.thorough
def test_hostile_specimen_is_only_text(screen):
    page = screen.page
    screen.begin(specimen=HOSTILE, real_time=False)
    screen.wait_for_result()
    page.get_by_role("link", name="History").click()
    page.wait_for_selector(".runs tbody tr")
    assert page.locator(".runs tbody tr").first.inner_text().count("<img src=x") == 1
    assert page.evaluate("window.hacked") is None
    assert page.locator("img[src=x]").count() == 0


@pytest.mark.thorough
def test_lost_server_is_reported_and_screen_reconnects(new_screen, lab):
    port = free_port()
    with running_panel(lab, port=port) as panel:
        window = new_screen(panel)
        window.open()
        page = window.page
        page.wait_for_selector(".chip.idle")
    page.wait_for_selector(".chip.disconnected")
    expect(page.locator(".banner.lost")).to_contain_text("emergency stop")
    with running_panel(lab, port=port):
        page.wait_for_selector(".chip.idle")
        expect(page.locator(".banner.lost")).to_be_hidden()


@pytest.mark.thorough
def test_start_requires_all_inputs(screen):
    page = screen.page
    screen.open()
    screen.choose()
    screen.fill_in(specimen="")
    screen.check_rig(ready=False)
    for empty in ("   ", ""):
        page.get_by_label("Bearing serial number").fill(empty)
        page.get_by_text("Inputs are missing or not valid: Bearing serial number.").wait_for()
        assert page.get_by_role("button", name="Start", exact=True).is_disabled()


@pytest.mark.thorough
def test_failed_preflight_is_overridden_only_with_name_and_reason(screen, panel):
    page = screen.page
    screen.open()
    screen.choose(NO_LOAD, OVERDUE)
    page.get_by_label("Your name").fill(NAME)
    screen.check_rig(ready=False)
    failed = page.locator(".light.fail")
    expect(failed).to_have_count(1)
    count = page.locator(".light").count()
    page.get_by_text(f"1 of {count} checks failed.", exact=True).wait_for()
    expect(failed).to_contain_text("was due on 2021-01-01")
    expect(failed.locator(".fix")).not_to_be_empty()
    start = page.get_by_role("button", name="Start", exact=True)
    expect(start).to_be_disabled()
    failed.get_by_role("checkbox").check()
    page.get_by_label("Name", exact=True).fill("Chief")
    expect(start).to_be_disabled()  # a reason is missing
    page.get_by_label("Reason").fill("new one ordered")
    start.click()
    panel.wait_for("asking", station="overdue.yaml")
    assert "new one ordered" in str(panel.get("events", "overdue.yaml")["items"])


@pytest.mark.thorough
def test_unsafe_rig_is_reported_in_a_separate_alert(new_screen, lab):
    station = (lab / "station.yaml").read_text(encoding="utf-8")
    faults = (
        "{plugin: swing_tester_sim, faults: [{kind: lost, on: stream, at: {frequency: 20 Hz}}]}"
    )
    lost = station.replace("plugin: swing_tester_sim ", "plugin: fault ")
    lost = lost.replace("settings: {seed: 1}", f"settings: {faults}").replace(STATION, LOST)
    (lab / "lost.yaml").write_text(lost, encoding="utf-8")
    with running_panel(lab) as panel:
        screen = new_screen(panel)
        page = screen.page
        screen.open()
        screen.choose(NO_LOAD, LOST)
        page.get_by_label("Your name").fill(NAME)
        screen.hurry()
        screen.check_rig()
        screen.start()
        screen.wait_for_result()
        alert = page.get_by_role("alert").filter(has_text="THE RIG IS NOT SAFE.")
        expect(alert).to_contain_text("make safe failed")
        reason = page.locator(".banner.warn")
        expect(reason).to_contain_text("the connection broke")
        expect(reason).not_to_contain_text("safe")


@pytest.mark.thorough
def test_german_browser_gets_a_german_screen(new_screen):
    screen = new_screen(locale="de-DE")
    screen.open()
    page = screen.page
    assert page.locator("html").get_attribute("lang") == "de"
    expect(page.locator("h1")).to_have_text("Prüfung wählen")
    page.get_by_label("Sprache").select_option("en")
    expect(page.locator("h1")).to_have_text("Choose a test")


@pytest.mark.thorough
def test_texts_of_the_server_are_german_too(new_screen):
    screen = new_screen(locale="de-DE")
    page = screen.page
    screen.open()
    page.locator(".item", has_text=NO_LOAD).click()
    page.locator(".item", has_text=OVERDUE).first.click()
    page.get_by_role("button", name="Weiter", exact=True).click()
    page.locator(".preflight > .button").click()
    screen.say_name()
    red = page.locator(".light.fail")
    expect(red).to_contain_text("war am 2021-01-01 fällig")
    expect(red.locator(".fix")).to_have_text(
        "kalibrieren lassen und den neuen Kalibrierschein eintragen"
    )
    expect(page.locator(".light", has_text="Nullpunkt")).to_contain_text("Grenze: ±0,05 N·m")
    page.get_by_text("Alle Schritte").click()
    steps = page.locator(".step-texts")
    expect(steps).to_contain_text("Nullpunkt von tester.torque, innerhalb 0,05 N·m")
    expect(steps).to_contain_text("Lager auf dem Dorn")  # of a procedure that ships
    box = red.get_by_role("checkbox")
    box.check()
    checked, reason = box.bounding_box(), page.locator(".preflight .override").bounding_box()
    assert checked["y"] + checked["height"] <= reason["y"]  # the fields do not cover it
