"""A day at two rigs: twelve specimens, a real Chromium, and several mishaps."""

from __future__ import annotations

import os
import signal
from collections import Counter

import pytest
from playwright.sync_api import expect

from e2e.helpers_panel import started_by
from e2e.panel.helpers_screen import (
    BENCH,
    LOADED,
    NAME,
    NO_LOAD,
    STATION,
    axe_script,
    running_panel,
    wait_until,
)

OTHER = "other.yaml"
OTHER_TITLE = "The other bench"
ALONE = "Runs that follow each other"
PROCEDURE = f"""\
rigrunner: procedure/2
id: ALONE
revision: "A"
title: {ALONE}
automatic_start: yes

inputs:
  specimen: {{ask: Bearing serial number, unattended: X}}

uses: {{tester: swing_tester}}

main:
  - set: {{tester.frequency: 20 Hz}}
  - settle: {{cycles: 2}}
  - record: {{channels: [tester.angle, tester.torque], cycles: 5}}

teardown:
  - set: {{tester.frequency: 0 Hz}}
"""
SPECIMENS = [f"SN-{n}" for n in range(1, 7)]
OTHER_SPECIMENS = [f"SN-{n}" for n in range(7, 13)]
SIZES = {"desk": (1280, 720), "tablet": (820, 1180)}
GRAVE = {"serious", "critical"}


@pytest.fixture
def two_rigs(lab):
    """A lab with two benches that are in order."""
    (lab / "overdue.yaml").unlink()
    text = (lab / BENCH).read_text(encoding="utf-8")
    station = text.replace("id: bench-1", "id: bench-2").replace(STATION, OTHER_TITLE)
    (lab / OTHER).write_text(station, encoding="utf-8")
    (lab / "procedures/alone.yaml").write_text(PROCEDURE, encoding="utf-8")
    return lab


def card(page, title):
    return page.locator(".rig", has=page.get_by_role("link", name=title))


def row(page, specimen, nth=0):
    strong = page.locator("strong", has_text=specimen)
    return page.locator(".queue-table tbody tr", has=strong).nth(nth)


def answer(page, text):
    page.locator("#dialog-text").fill(text)
    page.keyboard.press("Enter")


def scan(page, specimens, *, named):
    """Scan as a scanner does: each word with Enter, into the field that keeps the focus."""
    page.locator("#queue-scan").focus()
    for specimen in specimens:
        page.keyboard.type(specimen)
        page.keyboard.press("Enter")
        if specimen == specimens[0] and not named:
            answer(page, NAME)  # who has control
        row(page, specimen).wait_for()
        expect(page.locator("#queue-scan")).to_have_value("")


def open_queue(screen, station, procedure):
    screen.open("#/queue", station)
    page = screen.page
    page.locator("#queue-procedure").select_option(label=procedure)
    page.get_by_label("Real time").uncheck()
    return page


def statuses(panel, station):
    return Counter(entry["status"] for entry in panel.get("queue", station)["entries"])


def rig_processes(panel):
    """Return the numbers of the processes of the panel that have a rig."""
    commands = started_by(panel.process.pid).items()
    return [pid for pid, command in commands if "panel.jobs.main" in command]


@pytest.mark.thorough
def test_day_with_two_rigs_and_twelve_specimens(new_screen, two_rigs):  # noqa: PLR0915  (a day)
    with running_panel(two_rigs) as panel:
        other_page = open_queue(new_screen(panel), OTHER, ALONE)
        scan(other_page, OTHER_SPECIMENS, named=False)

        screen = new_screen(panel)
        screen.page.goto(panel.url)
        expect(card(screen.page, OTHER_TITLE).locator(".rig-foot")).to_contain_text("6 waiting")
        card(screen.page, STATION).get_by_role("link").click()
        screen.page.get_by_role("link", name="Queue").click()
        page = open_queue(screen, BENCH, LOADED)
        page.get_by_label("Bearing type").fill("GE20")
        page.get_by_label("Lot").fill("L-7")
        page.get_by_label("Your name").fill(NAME)
        scan(page, SPECIMENS, named=True)

        # the scanner beeps twice, and a specimen of the other rig is scanned here
        for procedure, specimen, message in (
            (LOADED, "SN-3", "SN-3 is already in the queue: entry 9"),
            (ALONE, "SN-8", f"SN-8 is already in the queue of {OTHER}: entry 2"),
        ):
            page.locator("#queue-procedure").select_option(label=procedure)
            page.locator("#queue-scan").fill(specimen)
            page.keyboard.press("Enter")
            expect(page.locator("#queue-scan-note")).to_contain_text(message)
        page.locator("#queue-scan").fill("")
        assert statuses(panel, BENCH) == {"waiting": 6}

        # a question is open at the first rig, and the run is paused; it is asked again afterwards
        page.get_by_role("button", name="Start SN-1").click()
        page.locator(".prompt").wait_for()
        page.keyboard.press("F8")
        page.locator(".banner", has_text="Paused").wait_for()

        # meanwhile the other rig runs its six by itself, once a person has allowed it
        other_page.get_by_label("Start automatically").click()
        expect(other_page.get_by_label("Start automatically")).to_be_checked()
        wait_until(lambda: panel.get("queue", OTHER)["entries"][0]["status"] != "waiting")
        page.keyboard.press("F8")
        page.locator(".prompt").get_by_role("button", name="Yes").click()
        screen.wait_for_result()
        expect(page.locator(".result-head .verdict")).to_contain_text("Pass")

        # the process of the second run is killed while it asks
        page.get_by_role("link", name="Queue").click()
        page.get_by_role("button", name="Start SN-2").click()
        page.locator(".prompt").wait_for()
        wait_until(lambda: statuses(panel, OTHER) == {"done": 6})
        wait_until(lambda: len(rig_processes(panel)) == 1)
        (doomed,) = rig_processes(panel)
        os.kill(doomed, signal.SIGKILL)
        panel.wait_for("finished")
        assert panel.process.poll() is None
        page.goto(panel.url)
        expect(card(page, STATION).locator(".rig-word")).to_have_text("Error")
        expect(card(page, OTHER_TITLE).locator(".rig-word")).to_have_text("Completed")
        assert statuses(panel, OTHER) == {"done": 6}, "untouched"

        # nothing starts before a person has decided about the interrupted entry
        card(page, STATION).get_by_role("link").click()
        page.get_by_role("link", name="Queue").click()
        expect(row(page, "SN-2").locator(".mark")).to_have_text("interrupted")
        expect(page.get_by_role("button", name="Start next")).to_be_disabled()
        row(page, "SN-2").get_by_role("button", name="Repeat").click()
        answer(page, "its process was killed")
        for specimen in SPECIMENS[1:]:
            page.get_by_role("button", name=f"Start {specimen}").click()
            page.locator(".prompt").get_by_role("button", name="Yes").click()
            screen.wait_for_result()
            page.get_by_role("link", name="Queue").click()
        wait_until(lambda: statuses(panel, BENCH)["done"] == 6)
        done = [entry for entry in panel.get("queue")["entries"] if entry["status"] == "done"]
        assert [entry["specimen"] for entry in done] == SPECIMENS
        assert {entry["verdict"] for entry in done} == {"pass"}

        # each specimen has one completed run, and the killed run is listed besides
        items = panel.get("runs")["items"]
        completed = Counter(item["specimen"] for item in items if item["outcome"] == "completed")
        assert {name: completed[name] for name in SPECIMENS + OTHER_SPECIMENS} == dict.fromkeys(
            SPECIMENS + OTHER_SPECIMENS, 1
        )
        assert sum(item["specimen"] == "SN-2" for item in items) == 2

        # the certificate of the first
        row(page, "SN-1").get_by_role("link", name="SN-1").click()
        page.wait_for_selector(".result-head .verdict.pass")
        page.get_by_text("Issue a certificate").click()
        order = {"customer": "C", "customer_contact": "Street 1", "item": "bearing"}
        for name, text in {**order, "item_condition": "new", "by": "B. Boss"}.items():
            page.locator(f"#certificate-{name}").fill(text)
        page.locator("#certificate-received").fill("2026-11-20")
        page.get_by_role("button", name="Issue", exact=True).click()
        expect(page.locator("form.inputs .told")).to_contain_text("was issued")
        certified = next(item["run"] for item in items if item["specimen"] == "SN-1")
        assert len(panel.get(f"runs/{certified}/certificates")["items"]) == 1


def begin(new_screen, panel, station, title, procedure):
    """Start a run that waits for the answer to its first question."""
    screen = new_screen(panel)
    screen.open(station=station)
    screen.choose(procedure, title)
    if procedure == LOADED:
        screen.fill_in(specimen="B-17")
    else:
        screen.page.get_by_label("Your name").fill(NAME)
    screen.check_rig()
    screen.page.get_by_role("button", name="Start", exact=True).click()
    panel.wait_for("asking", station=station)
    return screen


@pytest.mark.thorough
def test_stop_on_the_overview_stops_only_its_rig(new_screen, two_rigs):
    with running_panel(two_rigs) as panel:
        first = begin(new_screen, panel, BENCH, STATION, LOADED)
        begin(new_screen, panel, OTHER, OTHER_TITLE, NO_LOAD)
        page = new_screen(panel).page
        page.goto(panel.url)
        expect(page.locator(".rig-word")).to_have_text(["Waits for an answer"] * 2)
        expect(first.page.get_by_label("1 other rig needs attention")).to_be_visible()
        card(page, STATION).get_by_role("button", name="STOP").click()
        panel.wait_for("finished")
        expect(card(page, STATION).locator(".rig-word")).to_have_text("Aborted")
        assert panel.phase(OTHER) == "asking"
        page.keyboard.press("F9")
        panel.wait_for("finished", station=OTHER)
        expect(page.locator(".rig-word")).to_have_text(["Aborted"] * 2)


@pytest.mark.thorough
def test_overview_fits_the_screen_and_is_accessible(new_screen, two_rigs, pictures):
    with running_panel(two_rigs) as panel:
        begin(new_screen, panel, BENCH, STATION, LOADED)
        for locale in ("en-GB", "de-DE"):
            page, violations = new_screen(panel, locale=locale).page, []
            page.add_init_script(path=axe_script())
            for size, (width, height) in SIZES.items():
                page.set_viewport_size({"width": width, "height": height})
                for name, place in (
                    ("rigs", ""),
                    ("rig", f"?rig={BENCH}#/run"),
                    ("queue", f"?rig={OTHER}#/queue"),
                ):
                    page.goto(f"{panel.url}{place}")
                    page.locator(".rig, .page.run, .queue-card").first.wait_for()
                    page.wait_for_timeout(800)
                    page.screenshot(path=pictures / f"{name}-{size}-{locale}.png")
                    assert page.evaluate("document.documentElement.scrollWidth") <= width
                    if name == "rigs" and width > height:  # read across the room, without scrolling
                        state = page.locator(".rig-word").first
                        points = state.evaluate("e => parseFloat(getComputedStyle(e).fontSize)")
                        assert points > 0.085 * height
                        assert page.evaluate("document.documentElement.scrollHeight") <= height
                    result = page.evaluate("axe.run(document, {resultTypes: ['violations']})")
                    violations += [
                        f"{name}: {item['id']}: {item['nodes'][0]['html'][:120]}"
                        for item in result["violations"]
                        if item["impact"] in GRAVE
                    ]
            assert violations == []
