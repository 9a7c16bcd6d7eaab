"""The page of the queue: scanned, pasted, refused, started, repeated, and kept after a kill."""

from __future__ import annotations

import json
import re
from itertools import product

import pytest
from playwright.sync_api import expect

from e2e.panel.helpers_screen import LOADED, NAME, STATION, press_keys, running_panel
from helpers_cli import call

SIZES = {"desk": (1280, 720), "tablet": (820, 1180)}
AT_ONCE = """(field, specimens) => specimens.forEach((specimen) => {
  field.value = specimen;
  field.form.requestSubmit();
})"""


@pytest.fixture
def open_queue(new_screen):
    """Opens the page of the queue with a procedure and a station chosen."""

    def open_page(panel, **options):
        screen = new_screen(panel, **options)
        screen.open("#/queue")
        page = screen.page
        page.locator("#queue-procedure").select_option(label=LOADED)
        page.locator("#queue-station").select_option(label=STATION)
        page.get_by_label("Real time").uncheck()
        page.get_by_label("Bearing type").fill("GE20")
        page.get_by_label("Lot").fill("L-7")
        page.get_by_label("Your name").fill(NAME)
        return screen

    return open_page


LATE_ANSWERS = """
const atOnce = window.fetch;
window.fetch = async (...request) => {
  const answer = await atOnce(...request);
  await new Promise((done) => setTimeout(done, 500));
  return answer;
};
"""
"""As on a busy machine: a request has its effect on the screen before its answer arrives."""


def scan(page, *specimens):
    """Scan as a scanner does: a word and Enter, and the next one without waiting."""
    page.locator("#queue-scan").focus()
    for specimen in specimens:
        page.keyboard.type(specimen)
        page.keyboard.press("Enter")
    for specimen in specimens:
        row(page, specimen).wait_for()


def row(page, text):
    return page.locator(".queue-table tbody tr", has_text=text)


@pytest.mark.thorough
def test_rapid_scans_are_all_added_in_order(open_queue, lab):
    """A scanner sends the next specimen while the panel still adds the last one."""
    with running_panel(lab) as panel:
        page = open_queue(panel).page
        scan(page, "SN-1")
        # By the page itself: keys may come slower than the answers.
        page.locator("#queue-scan").evaluate(AT_ONCE, ["SN-2", "SN-1", "SN-3"])
        expect(page.locator(".queue-table tbody tr strong")).to_have_text(["SN-1", "SN-2", "SN-3"])
        note = page.locator("#queue-scan-note")
        expect(note).to_contain_text("SN-1 is already in the queue: entry 1")
        expect(note).to_contain_text("Added: entry 3")
        expect(page.locator("#queue-scan")).to_have_value("SN-1")
        page.keyboard.type("SN-4\n")
        row(page, "SN-4").wait_for()
        expect(note).not_to_contain_text("already")


@pytest.mark.thorough
def test_tested_specimen_is_added_only_with_a_reason(open_queue, lab):
    """It need not be in the queue: the runs of the lab have tested DEMO-0001."""
    with running_panel(lab) as panel:
        page = open_queue(panel).page
        title = "Starting torque under 1000 N"
        options = page.locator("#queue-procedure option", has_text=re.compile(f"^{title}"))
        expect(options).to_have_text([title, f"{title} · shipped with Rigrunner"])
        scan_note = page.locator("#queue-scan-note")
        page.locator("#queue-scan").fill("DEMO-0001")
        page.keyboard.press("Enter")
        expect(scan_note).to_contain_text("DEMO-0001 has already been tested: run ")
        scan_note.get_by_role("button", name="Test again").click()
        page.locator("#dialog-text").fill("customer asks")
        page.keyboard.press("Enter")
        expect(row(page, "DEMO-0001")).to_contain_text("customer asks")
        expect(scan_note).to_have_text("Added: entry 1")
        expect(page.locator("#queue-scan")).to_have_value("")


@pytest.mark.thorough
def test_list_with_tested_specimen_is_added_only_with_a_reason(open_queue, lab):
    with running_panel(lab) as panel:
        screen = open_queue(panel)
        page, note = screen.page, screen.page.locator("#queue-list-note")
        scan(page, "SN-1")
        page.locator(".queue-add details > summary").click()
        for specimens in ("DEMO-0001\nSN-1\nSN-2\u202e\nSN-3", "DEMO-0001\nSN-3"):
            page.locator("#queue-list").fill(specimens)
            page.get_by_role("button", name="Add the list").click()
            expect(note.locator("li")).to_have_count(3 if "SN-1" in specimens else 1)
            test_again = note.get_by_role("button", name="Test again")
            expect(test_again).to_have_count(0 if "SN-1" in specimens else 1)
        test_again.click()
        page.locator("#dialog-text").fill("customer asks")
        page.keyboard.press("Enter")
        expect(row(page, "DEMO-0001")).to_contain_text("customer asks")
        expect(row(page, "SN-3")).not_to_contain_text("customer asks")
        row(page, "DEMO-0001").get_by_role("button", name="Skip").click()
        page.locator("#dialog-text").fill("later")
        page.keyboard.press("Enter")

        page.get_by_role("link", name="Test", exact=True).click()
        screen.choose()
        screen.fill_in(specimen="demo-0001")
        warning = page.locator(".field.warn .field-note")
        expect(warning).to_contain_text("demo-0001 has already been tested: run ")
        page.get_by_role("button", name="Add to the queue").click()
        page.locator("#dialog-text").fill("second opinion")
        page.keyboard.press("Enter")
        expect(row(page, "second opinion")).to_contain_text("demo-0001")


@pytest.mark.thorough
def test_focus_follows_the_moved_row(open_queue, lab):
    with running_panel(lab) as panel:
        page = open_queue(panel).page
        page.evaluate(LATE_ANSWERS)
        scan(page, "SN-1", "SN-2")
        specimens = page.locator(".queue-table tbody tr strong")
        page.get_by_role("button", name="Move SN-2 up").focus()
        page.keyboard.press("Enter")
        expect(specimens).to_have_text(["SN-2", "SN-1"])
        expect(
            page.get_by_role("button", name="Move SN-2 down")
        ).to_be_focused()  # it is at the top
        page.keyboard.press("Enter")
        expect(specimens).to_have_text(["SN-1", "SN-2"])
        expect(page.locator("#queue-scan-note")).to_have_text("Added: entry 2")
        expect(page.get_by_role("button", name="Move SN-2 up")).to_be_focused()


@pytest.mark.thorough
def test_scan_during_the_reason_dialog_goes_to_the_queue(open_queue, lab):
    with running_panel(lab) as panel:
        page = open_queue(panel).page
        scan(page, "SN-1")
        row(page, "SN-1").get_by_role("button", name="Hold").click()
        reason = page.locator("#dialog-text")
        reason.fill("no ")
        reason.focus()
        press_keys(page, "SN-2", 0.01)
        row(page, "SN-2").wait_for()
        expect(reason).to_have_value("no ")
        expect(reason).to_be_focused()
        press_keys(page, "grease", 0.2)
        expect(page.locator(".dialog")).to_have_count(0)
        expect(row(page, "SN-1")).to_contain_text("no grease")
        assert [entry["specimen"] for entry in panel.get("queue")["entries"]] == ["SN-1", "SN-2"]


@pytest.mark.thorough
def test_scan_without_focused_field_goes_to_the_queue(open_queue, lab):
    with running_panel(lab) as panel:
        page = open_queue(panel).page
        page.evaluate(LATE_ANSWERS)
        scan(page, "SN-1")
        page.get_by_role("button", name="Start SN-1").focus()
        press_keys(page, "SN 2", 0.01)
        row(page, "SN 2").wait_for()
        page.locator("#queue-procedure").select_option(label=LOADED)
        page.locator("#queue-procedure").focus()
        press_keys(page, "temp-3", 0.01)  # the first letters of another procedure
        row(page, "temp-3").wait_for()
        expect(page.locator("#queue-procedure option:checked")).to_have_text(LOADED)
        page.evaluate("document.activeElement.blur()")
        press_keys(page, "7", 0.01)
        expect(page.locator(".queue-table tbody tr")).to_have_count(4)
        press_keys(page, "7", 0.01)  # the scan field has the focus now
        expect(page.locator("#queue-scan-note")).to_contain_text("7 is already in the queue")
        page.get_by_label("Lot").focus()
        press_keys(page, "X", 0.01)  # a label of the lot
        expect(page.get_by_label("Lot")).to_have_value("L-7X")
        page.get_by_role("link", name="History").click()
        page.get_by_role("link", name="History").focus()
        press_keys(page, "SN-5", 0.01)
        expect(page.locator(".notice")).to_contain_text("Scanned, but not taken: SN-5")
        entries = panel.get("queue")["entries"]
        assert [entry["specimen"] for entry in entries] == ["SN-1", "SN 2", "temp-3", "7"]
        assert [entry["inputs"].get("lot") for entry in entries] == ["L-7"] * 4
        assert panel.phase() == "idle"


@pytest.mark.thorough
def test_list_opens_in_spreadsheet_encodings_and_workbook_is_refused(open_queue, lab):
    with running_panel(lab) as panel:
        page = open_queue(panel).page
        page.locator(".queue-add details > summary").click()
        file_input, pasted = page.locator("#queue-file"), page.locator("#queue-list")

        def open_file(name, content):
            file_input.set_input_files({"name": name, "mimeType": "text/csv", "buffer": content})

        open_file("today.xlsx", b"PK\x03\x04\x00\x00\xff")
        expect(page.locator("#queue-list-note")).to_have_text(
            "today.xlsx is not a text file: save the table as CSV."
        )
        for encoding in ("cp1252", "utf-16", "utf-8-sig"):
            content = f"specimen;lot\r\nÄ-1;{encoding} µ\r\n".encode(encoding)
            open_file(f"{encoding}.csv", content)
            expect(pasted).to_have_value(f"specimen;lot\nÄ-1;{encoding} µ\n")
            expect(page.locator("#queue-list-note")).to_contain_text("makes it a CSV")


@pytest.mark.thorough
def test_german_list_with_decimal_commas_is_added(new_screen, lab):
    text = (lab / "procedures/quick_torque.yaml").read_text(encoding="utf-8")
    title = "Quick torque at a room temperature"
    asks = "inputs:\n  room: {ask: Temperature of the room, unit: °C, min: 15 °C, max: 30 °C}\n"
    text = text.replace(LOADED, title).replace("id: QUICK-ST", "id: QUICK-ROOM")
    procedure = lab / "procedures/quick_room.yaml"
    procedure.write_text(text.replace("inputs:\n", asks, 1), encoding="utf-8")
    with running_panel(lab) as panel:
        screen = new_screen(panel, locale="de-DE")
        screen.open("#/queue")
        page = screen.page
        page.locator("#queue-procedure").select_option(label=title)
        page.locator("#input-type").fill("GE20")
        page.locator("#input-operator").fill(NAME)
        page.locator(".queue-add details > summary").click()
        page.locator("#queue-list").fill("specimen;room;lot\nSN-1;22,5 °C;L 1,2\nSN-2;50,5 °C;L-2")
        page.locator(".queue-add details .primary").click()
        expect(page.locator("#queue-list-note li")).to_have_count(1)  # the one that is too hot
        expect(page.locator("#queue-list-note li")).to_contain_text("50,5 °C")
        page.locator("#queue-list").fill("specimen;room;lot\nSN-1;22,5 °C;L 1,2\nSN-2;23 °C;L-2")
        page.locator(".queue-add details .primary").click()
        row(page, "SN-2").wait_for()
        inputs = [entry["inputs"] for entry in panel.get("queue")["entries"]]
        common = {"type": "GE20", "operator": NAME}
        assert inputs == [
            {**common, "specimen": "SN-1", "room": "22.5 °C", "lot": "L 1,2"},
            {**common, "specimen": "SN-2", "room": "23 °C", "lot": "L-2"},
        ]


@pytest.mark.thorough
def test_queue_is_scanned_ordered_run_and_survives_a_kill(open_queue, lab):
    with running_panel(lab) as panel:
        page = open_queue(panel).page
        page.locator("#queue-scan").focus()
        page.keyboard.type("SN-1")
        page.keyboard.press("Enter")  # the name is in the form: it is not asked again
        row(page, "SN-1").wait_for()
        scan(page, "SN-2", "SN-3")
        page.locator("#queue-scan").fill("SN-2")
        page.keyboard.press("Enter")
        expect(page.locator("#queue-scan-note")).to_contain_text("is already in the queue: entry 2")
        page.get_by_role("button", name="Move SN-3 up").click()
        expect(page.locator(".queue-table tbody tr strong")).to_have_text(["SN-1", "SN-3", "SN-2"])
        row(page, "SN-2").get_by_role("button", name="Hold").click()
        page.locator("#dialog-text").fill("dirty")
        page.keyboard.press("Enter")
        expect(row(page, "SN-2").locator(".mark")).to_have_text("held")
        page.get_by_text("From a list").click()
        page.get_by_label("One specimen per line").fill("specimen;lot\nSN-4;L-8\nSN-5")
        page.get_by_role("button", name="Add the list").click()
        expect(page.locator("#queue-list-note")).to_contain_text("got 1 cell, expected 2")
        page.get_by_label("One specimen per line").fill("specimen;lot\nSN-4;L-8\nSN-5;L-8")
        page.get_by_role("button", name="Add the list").click()
        row(page, "SN-5").wait_for()
        page.get_by_role("button", name="Start SN-1").click()
        page.locator(".prompt").get_by_role("button", name="Yes").click()
        page.wait_for_url("**#/runs/*")
        assert panel.get("runs")["items"][0]["specimen"] == "SN-1"
        page.get_by_role("link", name="Queue").click()
        expect(row(page, "SN-1").locator(".mark")).to_have_text("Pass")
        page.get_by_role("button", name="Start SN-3").click()
        panel.wait_for("asking")
        panel.process.kill()
        panel.process.wait()
    with running_panel(lab) as panel:
        page = open_queue(panel).page
        status = {entry["specimen"]: entry["status"] for entry in panel.get("queue")["entries"]}
        assert (status["SN-1"], status["SN-2"], status["SN-4"]) == ("done", "held", "waiting")
        assert status["SN-3"] in ("interrupted", "done"), "aborted by the loss of the panel"
        assert panel.phase() == "idle", "nothing starts by itself"
        row(page, "SN-3").get_by_role("button", name="Repeat").click()
        page.locator("#dialog-text").fill("the panel was killed")
        page.keyboard.press("Enter")
        expect(row(page, "SN-3")).to_have_count(2)
        entries = json.loads(call("queue", "list", "--json", "--runs", lab / "runs").out)
        repeat = next(entry for entry in entries if entry["repeats"])
        assert (repeat["inputs"]["specimen"], repeat["reason"]) == ("SN-3", "the panel was killed")


@pytest.mark.thorough
def test_queue_page_fits_the_screen(new_screen, lab, pictures, monkeypatch):
    monkeypatch.chdir(lab)
    runs = ("--runs", lab / "runs")
    pair = ("procedures/quick_torque.yaml", "--station", "station.yaml")
    more = ("--set", "type=GE20", "--set", "lot=L-7", "--by", "Ann Jones")
    assert call("queue", "add", *pair, "B-100", "B-101", "B-102", "B-103", *more, *runs).code == 0
    assert call("queue", "add", *pair, "B-104", "--propose", "--by", "LIMS", *runs).code == 0
    call("queue", "hold", "3", "--reason", "inner ring is dirty", "--by", "Ann Jones", *runs)
    call("queue", "skip", "1", "--reason", "lost", "--by", "Ann Jones", *runs)
    with running_panel(lab) as panel:
        for (size, (width, height)), locale in product(SIZES.items(), ("en-GB", "de-DE")):
            screen = new_screen(panel, viewport={"width": width, "height": height}, locale=locale)
            screen.open("#/queue")
            page = screen.page
            expect(page.locator(".queue-table tbody tr")).to_have_count(5)
            page.wait_for_timeout(300)
            page.screenshot(path=pictures / f"queue-{size}-{locale}.png")
            assert page.evaluate("document.documentElement.scrollWidth") <= width
            first = page.locator(".queue-table tbody tr").first.bounding_box()
            is_seen = first["y"] + first["height"] <= height
            assert is_seen, "the first entry is seen without scrolling"


@pytest.mark.thorough
def test_second_start_is_queued_and_hostile_specimens_are_text(open_queue, lab):
    hostile = "<img src=x onerror=window.hacked=1>"
    with running_panel(lab) as panel:
        screen = open_queue(panel)
        page = screen.page
        page.locator("#queue-scan").focus()
        page.keyboard.type(hostile)
        page.keyboard.press("Enter")  # the name is in the form: it is not asked again
        row(page, "<img").wait_for()
        assert page.evaluate("window.hacked") is None
        page.get_by_role("button", name="Start <img").click()
        panel.wait_for("asking")
        page.get_by_role("link", name="Test", exact=True).click()
        screen.choose()
        screen.fill_in(specimen="SECOND")
        page.get_by_text("The rig is in use").wait_for()
        expect(page.get_by_role("button", name="Start", exact=True)).to_be_disabled()
        page.get_by_role("button", name="Add to the queue").click()
        expect(row(page, "SECOND").locator(".mark")).to_have_text("waiting")
        page.get_by_role("button", name="STOP").click()
        panel.wait_for("finished")
