"""What a technician does at the panel, with the mouse and with only the keyboard."""

from __future__ import annotations

import json

import pytest
from playwright.sync_api import expect

from e2e.panel.helpers_screen import ENDLESS, LOADED, NAME, STATION, press_keys

CERTIFICATE = {  # in the order of Tab
    "Customer": "A customer",
    "Customer's address": "1 Street, Town",
    "Item tested": "Spherical plain bearing",
    "Condition when received": "as new",
    "Received on": "2026-01-01",
    "Authorised by": "Q. Lead",
}
TRUTH_NM = 0.7262  # Ts of the simulated rig: the default of its settings, from the paper


@pytest.mark.thorough
def test_run_and_certificate_by_mouse(screen, panel):
    page = screen.page
    screen.begin(specimen="B-17")
    screen.wait_for_compensation()
    assert page.locator(".plot-curve canvas").count() == 1
    screen.wait_for_result()
    assert "Pass" in page.locator(".result-head .verdict-word").inner_text()
    value = float(page.locator(".result-head .verdict-value").inner_text().split(" ")[0])
    assert abs(value - TRUTH_NM) < 0.01
    report = page.frame_locator(".report")
    expect(report.get_by_text("Rigrunner test report")).to_be_visible()
    page.get_by_text("Issue a certificate").click()
    for label, answer in CERTIFICATE.items():
        page.get_by_label(label, exact=True).fill(answer)
    page.get_by_role("button", name="Issue", exact=True).click()
    page.locator(".told .good-text").wait_for()
    link = page.locator(".told a").first
    assert link.get_attribute("href").startswith("/api/v1/runs/")
    assert any(
        path.suffix == ".html"
        for path in (panel.runs).glob("*B-17*/*")
        if "report" not in path.name
    )


@pytest.mark.thorough
def test_result_shows_its_points_and_checks_of_every_method(screen, panel):
    page = screen.page
    run = next(item for item in panel.get("runs")["items"] if item["verdict"] == "pass")
    result = panel.get(f"runs/{run['run']}")["result"]
    methods = result["compensations"].items()
    checks = [(check["name"], check) for check in result["checks"]]
    for method, content in methods:
        checks += [(f"{check['name']} ({method})", check) for check in content["checks"]]
    skipped = [name for name, check in checks if check["text"].startswith("not checked")]
    failed = [name for name, check in checks if not check["ok"]]
    assert "coupling (template_inverse)" in skipped, "the lab's station does not state it"
    screen.open(f"#/runs/{run['run']}")
    page.get_by_text(f"Not evaluated: {', '.join(skipped)}.").wait_for()
    assert page.locator("ul.lights .light.warn:visible strong").all_inner_texts() == failed
    all_ok = page.get_by_text(f"All {len(checks) - len(skipped)} checks are OK.")
    assert all_ok.is_visible() == (not failed)
    rows = page.locator("table.results", has_text="torque").locator("tbody tr").all_inner_texts()
    assert [row.split("\t")[0] for row in rows] == ["10 Hz", "20 Hz", "30 Hz", "35 Hz"]
    assert all("±" in row for row in rows)


@pytest.mark.thorough
def test_next_specimen_is_two_clicks_away(screen, panel):
    page = screen.page
    run = next(item for item in panel.get("runs")["items"] if item["verdict"] == "pass")
    screen.open(f"#/runs/{run['run']}")
    page.get_by_role("button", name="Next specimen").click()
    screen.hurry()
    screen.open(f"#/runs/{run['run']}")
    page.get_by_role("button", name="Next specimen").click()
    page.wait_for_selector(".preflight")
    expect(page.get_by_label("Bearing serial number")).to_be_focused()  # it may be scanned at once
    expect(page.get_by_label("Real time")).not_to_be_checked()
    assert page.get_by_label("Bearing serial number").input_value() == ""
    assert page.get_by_label("Bearing type").input_value().endswith("GE20")
    assert page.get_by_label("Lot").input_value()
    assert page.get_by_label("Your name").input_value() == run["operator"]
    page.get_by_label("Bearing serial number").fill("SECOND-2")
    screen.check_rig()
    page.get_by_role("button", name="Start", exact=True).click()
    panel.wait_for("asking")
    assert panel.get("state")["job"]["inputs"]["specimen"] == "SECOND-2"
    for place in ("h1", ".prompt"):
        expect(page.locator(place)).to_contain_text("SECOND-2")  # the one to be clamped


@pytest.mark.thorough
def test_run_and_certificate_by_keyboard(screen):
    page = screen.page
    press, write, focus_on = page.keyboard.press, page.keyboard.type, screen.focus_on
    screen.open()
    page.wait_for_selector(".item")
    focus_on("Search procedures")
    write(LOADED)
    expect(page.locator(".card:first-child .item")).to_have_count(1)
    focus_on(LOADED)
    press("Space")
    focus_on("Search stations")
    write(STATION)
    expect(page.locator(".card:last-child .item")).to_have_count(1)
    focus_on(STATION)
    press("Space")
    focus_on("Next")
    press("Enter")
    page.wait_for_selector(".preflight")
    focus_on("Bearing serial number")
    write("KEYS-1")
    for text in ("GE20", "L-7", NAME):
        press("Enter")  # as a barcode scanner ends; the next field has the focus
        write(text)
    focus_on("Real time")
    press("Space")
    focus_on("Check the rig")
    press("Enter")  # the name was typed above, and is not asked again
    page.get_by_text("Ready to start.").wait_for()
    focus_on("Start")
    press("Enter")
    page.wait_for_selector(".prompt")
    focus_on("Yes")
    press("Enter")
    screen.wait_for_result()
    focus_on("Issue a certificate", most=200)
    press("Enter")
    for label, answer in CERTIFICATE.items():
        focus_on(f"{label}$")
        write("01012026" if label == "Received on" else answer)
    focus_on("Issue$")
    press("Enter")
    page.locator(".told .good-text").wait_for()


@pytest.mark.thorough
def test_pause_repeat_skip_and_abort(screen, panel):
    page = screen.page
    screen.begin(ENDLESS)
    page.locator(".step.running", has_text="at 20 Hz").wait_for()
    page.keyboard.press("F8")
    panel.wait_for("paused")
    page.locator(".banner", has_text="the rig is at a standstill").wait_for()
    frequency = page.locator(".readout.old", has_text="Swing frequency")
    expect(frequency).to_contain_text("read ")  # the time of its last reading
    expect(page.locator(".step.failed")).to_have_count(0)  # it was interrupted, and comes again
    page.get_by_role("button", name="Repeat point").click()
    page.locator("#dialog-text").focus()
    press_keys(page, "SN-42", 0.01)  # a scan is no reason, and there is no queue here
    expect(page.locator(".notice")).to_contain_text("Scanned, but not taken: SN-42")
    expect(page.locator("#dialog-text")).to_have_value("")
    page.locator("#dialog-text").fill("a bump")
    page.keyboard.press("Enter")
    page.locator(".step.running", has_text="at 20 Hz").wait_for()
    page.get_by_role("button", name="Skip point").click()
    page.locator("#dialog-text").fill("worn out")
    page.keyboard.press("Enter")
    page.locator(".step.running", has_text="at 30 Hz").wait_for()
    page.get_by_role("button", name="Abort", exact=True).click()
    page.locator("#dialog-text").fill("wrong bearing")
    page.keyboard.press("Enter")
    screen.wait_for_result()
    assert "Aborted" in page.locator(".result-head .verdict-word").inner_text()
    run = panel.get("runs")["items"][0]["run"]
    events = json.dumps(panel.get(f"runs/{run}")["events"])
    assert "a bump" in events
    assert "worn out" in events
    assert "wrong bearing" in events


@pytest.mark.thorough
def test_stop_works_while_a_question_is_open(screen, panel):
    page = screen.page
    screen.open()
    screen.choose()
    screen.fill_in()
    screen.check_rig()
    page.get_by_role("button", name="Start", exact=True).click()
    picture = page.get_by_role("img", name="Picture for this step")
    expect(picture).to_have_js_property("complete", True)  # noqa: FBT003  (of Playwright)
    assert picture.evaluate("image => image.naturalWidth") > 0
    page.get_by_role("button", name="STOP").click()
    panel.wait_for("finished", "ending", "analysing")
    screen.wait_for_result()
    assert "Aborted" in page.locator(".result-head .verdict-word").inner_text()


@pytest.mark.thorough
def test_manual_mode(screen, panel):
    page = screen.page
    screen.open()
    screen.choose()
    page.get_by_role("link", name="Manual mode").click()
    page.locator(".preflight > .button").click()
    screen.say_name()
    page.get_by_role("button", name="Connect").click()
    load, frequency = (
        page.get_by_label("Radial load (N)"),
        page.get_by_label("Swing frequency (Hz)"),
    )
    load.fill("1000")
    load.press("Enter")
    expect(page.locator(".readout", has_text="Radial load")).to_contain_text("set 1000 N")
    frequency.fill("50")
    frequency.press("Enter")
    expect(page.locator(".field.bad .field-note")).to_contain_text("out of range (0 to 35 Hz)")
    frequency.fill("10")
    frequency.press("Enter")
    screen.wait_for_compensation()
    page.get_by_role("button", name="Channels").click()
    rows = page.locator(".channels tbody tr")
    expect(rows).to_have_count(len(panel.get("state")["channels"]))
    fresh = page.locator(".channels tbody tr:not(.old)")
    expect(fresh).to_have_count(rows.count())  # between the readings of the recorded ones too
    boxes = [canvas.bounding_box() for canvas in page.locator(".channels canvas").all()]
    edge = page.locator(".channels").bounding_box()
    assert all(box["x"] + box["width"] <= edge["x"] + edge["width"] for box in boxes)
    page.get_by_role("button", name="Channels").click()
    cycles = page.get_by_label("Cycles")
    cycles.fill("2")
    page.get_by_role("button", name="Record a point").click()
    expect(page.locator("#cycles-note")).to_have_text("out of range (3 to 1000)")
    cycles.fill("10")
    page.get_by_role("button", name="Record a point").click()
    expect(page.locator("#cycles-note")).to_be_empty()
    page.locator(".manual-record .results", has_text="10 Hz").wait_for()
    frequency.fill("12.5")
    frequency.press("Enter")
    reason = page.locator(".readout.compensated .readout-small")
    expect(reason).to_contain_text("no no-load recording within")  # and lists those there are
    boxes = [readout.bounding_box() for readout in page.locator(".readout").all()]
    assert all(box["width"] > 150 and box["x"] + box["width"] <= 1280 for box in boxes)
    page.get_by_role("button", name="Make safe and end").click()
    expect(page.locator(".drives button:enabled")).to_have_count(0)
    panel.wait_for("finished")
    page.get_by_role("link", name="See its points").click()
    page.wait_for_selector(".result-head")
    events = json.dumps(panel.get(f"runs/{panel.get('runs')['items'][0]['run']}")["events"])
    assert "tester is safe: read back tester.frequency 0 Hz, tester.load 0 N" in events


@pytest.mark.thorough
def test_runs_are_searched_and_compared(screen):
    page = screen.page
    screen.open("#/history")
    expect(page.locator(".runs tbody tr").nth(1)).to_be_visible()
    page.get_by_label("Search specimen").fill("DEMO-0001")
    expect(page.locator(".runs tbody tr")).to_have_count(1)
    assert "Pass" in page.locator(".runs tbody tr").inner_text()
    page.locator(".runs tbody input").check()
    page.get_by_label("Search specimen").fill("")
    expect(page.locator(".runs tbody tr").nth(1)).to_be_visible()
    page.locator(".runs tbody input:not(:checked)").first.check()
    page.get_by_role("button", name="Compare (2 of 2)").click()
    cards = page.locator(".compare .card")
    cards.first.wait_for()
    expect(cards.first.locator("h2")).to_have_text("results")  # differences of results come first
    expect(cards.first.locator("li").first).to_contain_text("verdict was changed from")
    relevant = [card.locator("li.matters").count() > 0 for card in cards.all()[1:]]
    assert relevant == sorted(relevant, reverse=True), "then relevant changes before others"
    assert any(relevant)


@pytest.mark.thorough
def test_history_row_opens_by_a_click_anywhere(screen, panel):
    page = screen.page
    run = panel.get("runs")["items"][0]["run"]
    for number in range(7):
        screen.open("#/history")
        cell = page.locator(".runs tbody tr").first.locator("td").nth(number)
        box = cell.bounding_box()  # at its left edge: beside the tick, the words and the number
        cell.click(position={"x": 2, "y": box["height"] - 3})
        page.wait_for_url(f"**#/runs/{run}")
    screen.open("#/history")
    page.locator(".runs tbody input").first.check()
    assert page.url.endswith("#/history"), "a tick is no click on the row"
