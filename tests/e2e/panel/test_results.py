"""A run without a swing on the screen: its results by coordinates, with their limits."""

from __future__ import annotations

import pytest
from playwright.sync_api import expect

from e2e.panel.helpers_screen import running_panel
from helpers_any_quantity import PROCEDURE, STATION


@pytest.fixture
def supply(tmp_path):
    """A panel of a supply with manual readings, and a question before each measurement."""
    folder = tmp_path / "lab"
    folder.mkdir()
    station = STATION.replace("id: bench\n", "id: bench-1\n")
    (folder / "station.yaml").write_text(station, encoding="utf-8")
    step = "        - measure: {channels: [bench.voltage, bench.ripple]}\n"
    assert step in PROCEDURE
    procedure = PROCEDURE.replace(
        step, f"{step}        - confirm: {{text: Is the load at its place?, unattended: yes}}\n"
    )
    (folder / "supply.yaml").write_text(procedure, encoding="utf-8")
    (folder / "runs").mkdir()
    with running_panel(folder) as running:
        yield running


@pytest.mark.thorough
def test_results_are_listed_with_limits_and_no_empty_plot(new_screen, supply):
    screen = new_screen(supply)
    page = screen.page
    screen.open()
    screen.choose("Load regulation", "Power supply")
    page.get_by_label("Serial number").fill("PSU-1")
    screen.check_rig()
    page.get_by_role("button", name="Start", exact=True).click()
    yes = page.locator(".prompt").get_by_role("button", name="Yes")
    for count in range(1, 4):
        yes.wait_for()
        expect(page.locator(".live-results tbody th")).to_have_count(count)
        prompt = page.locator(".prompt-text").text_content()
        assert prompt == "Is the load at its place?"
        expect(page.locator(".plot-curve")).to_be_hidden()
        yes.click()
    expect(page.locator(".live-results tbody th")).to_have_count(4)
    voltages = page.locator(".results").first
    expect(voltages.locator("caption")).to_have_text("output voltage, U, in V")
    expect(voltages.locator("tbody tr").first).to_contain_text("11.98 … 12.1")
    expect(page.locator(".result-plots .plot")).to_have_count(1)
    expect(page.locator(".readouts")).to_contain_text("Voltage")
    yes.click()
    screen.wait_for_result()
    rows = page.locator(".result-body .results").first.locator("tbody tr")
    expect(rows).to_have_count(4)
    expect(rows.first.get_by_role("img", name="Pass")).to_be_visible()
    expect(page.locator(".verdict-value").first).to_contain_text("V")
