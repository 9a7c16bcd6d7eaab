"""Overlays and control charts of many stored runs, as they are drawn."""

from __future__ import annotations

import numpy as np
import pytest
from playwright.sync_api import expect

from e2e.helpers_trends import store_results
from e2e.panel.helpers_screen import running_panel, wait_until

SHIFTED_FROM = 34
COLOURS = """canvas => {
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    const colours = new Set();
    for (let at = 0; at < data.length; at += 4) {
        if (data[at + 3] > 250) colours.add(`${data[at]},${data[at + 1]},${data[at + 2]}`);
    }
    return [...colours];
}"""
RGB = """name => {
    const hex = getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
    return [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16)).join(',');
}"""


def drawn_in(page, plot, name: str) -> bool:
    """Return whether a plot has something in one of the screen's colours."""
    return page.evaluate(RGB, name) in plot.locator("canvas").evaluate(COLOURS)


@pytest.fixture
def shifted(tmp_path):
    """A lab with forty runs, of which the last ones are shifted."""
    rng = np.random.default_rng(5)
    torques = 0.72 + 0.01 * rng.normal(size=40)
    torques[SHIFTED_FROM:] += 0.05
    folder = tmp_path / "lab"
    store_results(folder / "runs", torques, frequencies=400 + 0.1 * rng.normal(size=40))
    return folder


@pytest.mark.thorough
def test_control_chart_shows_limits_and_runs_beyond_them(new_screen, shifted, pictures):
    with running_panel(shifted) as panel:
        screen = new_screen(panel, locale="de-DE")
        page = screen.page
        page.goto(f"{panel.url}#/trends")
        page.locator("#trend-quantity option[value=torque]").wait_for(state="attached")
        page.locator("#trend-quantity").select_option("torque")
        chart = page.locator(".trend-card")
        expect(chart.locator("canvas")).to_be_visible()
        wait_until(lambda: drawn_in(page, chart, "compensated"), "the values")
        wait_until(lambda: drawn_in(page, chart, "raw"), "the limits, and the runs beyond them")
        alarms = chart.locator(".changes li")
        assert 1 <= alarms.count() <= 40 - SHIFTED_FROM + 9  # a rule may need nine in a row
        expect(alarms.first).to_contain_text("außerhalb von 3 Standardabweichungen")
        page.screenshot(path=pictures / "control-chart.png", full_page=True)
        baseline, note = page.locator("#trend-baseline"), page.locator("#trend-baseline-note")
        for wrong, words in (
            ("gestern", "„gestern“ ist keine Grundlage"),
            ("2", "eine Grundlage von 2 Werten ist zu kurz"),
        ):
            baseline.fill(wrong)
            baseline.press("Tab")
            expect(note).to_contain_text(words)
            expect(baseline).to_have_attribute("aria-invalid", "true")
        baseline.fill("41")
        baseline.press("Tab")
        expect(page.locator(".trends")).to_contain_text("es gibt 40 Werte")
        expect(note).to_have_text("")
        baseline.fill("20")
        baseline.press("Tab")
        expect(chart.locator("canvas")).to_be_visible()


@pytest.mark.thorough
def test_overlay_draws_results_and_curves_of_two_runs(new_screen, panel, pictures):
    runs = sorted(run.name for run in panel.runs.iterdir() if "QUICK" in run.name)[:2]
    screen = new_screen()
    page = screen.page
    screen.open(f"#/overlay/{'/'.join(runs)}")
    curve = page.locator(".overlay-columns .card").last
    expect(curve.locator("canvas")).to_be_visible()
    page.locator("#overlay-channel").select_option("tester.torque")
    expect(curve.locator(".plot-title")).to_contain_text("tester.torque")
    for number, name in enumerate(("compensated", "raw")):
        wait_until(lambda name=name: drawn_in(page, curve, name), f"the curve of {runs[number]}")
        expect(curve.locator(".legend").first).to_contain_text(runs[number])
    page.screenshot(path=pictures / "overlay-drawn.png")


@pytest.mark.thorough
def test_comparison_of_equal_runs_says_that_no_result_differs(new_screen, panel):
    run = next(run.name for run in panel.runs.iterdir() if "QUICK-ST" in run.name)
    screen = new_screen()
    screen.open(f"#/compare/{run}/{run}")
    expect(screen.page.locator(".compare .good-text")).to_have_text("No result differs.")
