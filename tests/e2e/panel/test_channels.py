"""Live channels in every phase, with their age; old values look old."""

from __future__ import annotations

import pytest
from playwright.sync_api import expect

from e2e.panel.helpers_screen import ASKS, ENDLESS, running_panel, wait_until

LAG = """async () => {
    const { listen, store } = await import("/js/store.js");
    const lags = [];
    let forget;
    await new Promise((done) => {
        forget = listen((changed) => {
            if (!changed.has("channels")) return;
            const times = store.state.channels.map((channel) => channel.utc).filter(Boolean);
            const newest = times.sort().at(-1);
            if (newest && lags.push(Date.now() - Date.parse(newest)) >= 10) done();
        });
        setTimeout(done, 60000);  // a busy machine
    });
    forget();
    return lags.sort((a, b) => a - b);
}"""


OLD = """async () => {
    const { isOld } = await import("/js/parts/channels.js");
    const { store } = await import("/js/store.js");
    return store.state.channels.filter(({ utc }) => utc).map(({ utc }) => isOld(utc));
}"""


LANGUAGES = {"en": "Channels", "de": "Kanäle"}
"""The name of the button of the channels."""


def show_channels(page, language: str) -> None:
    """Open the channels in a language; choosing another one loads the page again."""
    if page.locator("html").get_attribute("lang") != language:
        page.locator(".choices select").first.select_option(language)
        expect(page.locator("html")).to_have_attribute("lang", language)
        page.wait_for_selector("header .chip:not(.disconnected)")
    page.get_by_role("button", name=LANGUAGES[language]).click()


@pytest.mark.thorough
def test_channels_are_live_while_nothing_is_recorded_and_old_afterwards(screen, panel, pictures):
    page = screen.page
    screen.begin(ENDLESS, specimen="LIVE")
    page.locator(".step.running", has_text="at 20 Hz").wait_for()
    page.keyboard.press("F8")
    panel.wait_for("paused")
    rows = page.locator(".channels tbody tr")
    for language in LANGUAGES:
        page.set_viewport_size({"width": 1280, "height": 720})
        show_channels(page, language)
        expect(rows).to_have_count(len(panel.get("state")["channels"]))
        expect(page.locator(".channels tbody tr.old")).to_have_count(0)
        expect(rows.filter(has_text="tester.temperature")).to_contain_text("°C")
        lags = page.evaluate(LAG)
        summary = f"{len(lags)} updates: median {lags[len(lags) // 2]} ms, worst {lags[-1]} ms"
        (pictures / f"lag-{language}.txt").write_text(summary, encoding="utf-8")
        assert len(lags) >= 10
        assert lags[len(lags) // 2] < 2500, "a tenth of it is the aim on a quiet machine"
        page.screenshot(path=pictures / f"channels-desk-{language}.png")
        page.set_viewport_size({"width": 820, "height": 1180})
        page.wait_for_timeout(500)
        page.screenshot(path=pictures / f"channels-tablet-{language}.png")
        assert page.evaluate("document.documentElement.scrollWidth") <= 820
    page.get_by_role("button", name="STOP").click()
    screen.wait_for_result()
    page.goto(f"{panel.url}?rig=station.yaml#/run")
    page.reload()  # as a person who opens it now
    page.wait_for_selector("header .chip:not(.disconnected)")
    assert set(page.evaluate(OLD)) == {True}, "from the first moment"
    for language in reversed(LANGUAGES):
        show_channels(page, language)
        expect(rows.first).to_be_visible()
        expect(page.locator(".channels tbody tr:not(.old)")).to_have_count(0)
    channels = {channel["name"]: channel for channel in panel.get("state")["channels"]}
    (made_safe,) = [
        event
        for event in (item["event"] for item in panel.get("events")["items"])
        if event["event"] == "MadeSafe" and event["read_back"].get("tester.load") is not None
    ]
    safe = channels["tester.load"]
    assert abs(safe["value"] - made_safe["read_back"]["tester.load"]) < 1e-6
    assert safe["utc"] == made_safe["utc"]
    load = page.locator(".readout.old").first
    expect(load).to_contain_text(made_safe["utc"][17:19])  # the time of the value


POINTS = """async ([y, x]) => {
    const { pastOf, paired } = await import("/js/past.js");
    return paired(pastOf(x), pastOf(y)).length;
}"""


LATE = """async () => {
    const { store, takeFrame } = await import("/js/store.js");
    takeFrame({ ...store.lastCurve, late_s: 8 });
    const plot = document.querySelector(".plot-curve .plot");
    return [plot.className, plot.querySelector(".plot-of").textContent];
}"""
"""A late curve of the present recording."""


@pytest.mark.thorough
def test_chosen_plots_are_kept_for_the_procedure(new_screen, panel, pictures):
    screen = new_screen()
    page = screen.page
    screen.begin(ENDLESS, specimen="PLOTS")
    expect(page.locator(".step.running", has_text="at 20 Hz")).to_contain_text("Record")
    lags = page.evaluate(LAG)  # of recorded channels
    assert len(lags) >= 10
    summary = f"{len(lags)} updates: median {lags[len(lags) // 2]} ms, worst {lags[-1]} ms"
    (pictures / "lag-recording.txt").write_text(summary, encoding="utf-8")
    assert lags[len(lags) // 2] < 2500, "a tenth of it is the aim on a quiet machine"
    page.locator(".plot-curve .plot:not(.past)").wait_for()
    kind, age = page.evaluate(LATE)
    assert "past" in kind.split()
    assert age.endswith(": 8 s old")
    page.locator(".plot-curve .plot:not(.past)").wait_for()  # the next one is current
    page.get_by_role("button", name="Plots").click()
    for over in ("Time", "tester.angle"):
        page.get_by_label("Channel", exact=True).select_option("tester.torque")
        page.get_by_label("over", exact=True).select_option(label=over)
        page.get_by_role("button", name="Add plot").click()
    page.get_by_role("checkbox", name="Figures of results").uncheck()
    plots = page.locator(".chosen-plots figure")
    expect(plots).to_have_count(2)
    expect(plots.nth(1)).to_contain_text("tester.torque over tester.angle")
    wait_until(lambda: page.evaluate(POINTS, ["tester.torque", "tester.angle"]) > 3)
    page.screenshot(path=pictures / "plots-desk.png")
    page.get_by_role("button", name="Plots").click()
    page.screenshot(path=pictures / "plots-closed.png")
    page.reload()
    expect(plots).to_have_count(2)
    expect(page.get_by_role("group", name="Torque over frequency")).to_be_hidden()
    page.get_by_role("button", name="Plots").click()
    page.get_by_role("button", name="Remove: tester.torque over time").click()
    expect(plots).to_have_count(1)
    page.get_by_role("button", name="STOP").click()
    panel.wait_for("finished")


PAST = """async () => {
    const { store } = await import("/js/store.js");
    const { pastOf } = await import("/js/past.js");
    const names = store.state.channels.map(({ name }) => name);
    return names.filter((name) => pastOf(name).length < 2);
}"""


def expect_live_channels(page, phase: str) -> None:
    """Expect a row, an age and a strip of every channel, and none that is old."""
    rows = page.locator(".channels tbody tr")
    expect(rows.first).to_be_visible()
    expect(page.locator(".channels tbody tr.old")).to_have_count(0)
    count = page.evaluate("import('/js/store.js').then(({ store }) => store.state.channels.length)")
    assert count >= 8
    expect(rows).to_have_count(count)
    expect(page.locator(".channels canvas.strip:visible")).to_have_count(count)
    page.wait_for_function(f"({PAST})().then((without) => without.length === 0)")
    assert page.evaluate("import('/js/store.js').then(({ store }) => store.state.phase)") == phase


@pytest.mark.thorough
def test_channels_are_live_while_the_run_waits_settles_or_pauses(new_screen, lab):
    path = lab / "procedures/quick_asks.yaml"
    text = path.read_text(encoding="utf-8")
    assert "- settle: {cycles: 1}" in text
    path.write_text(text.replace("- settle: {cycles: 1}", "- settle: {cycles: 120}"), "utf-8")
    with running_panel(lab) as panel:
        screen = new_screen(panel)
        page = screen.page
        screen.open()
        screen.choose(ASKS)
        screen.fill_in()
        screen.check_rig()
        page.get_by_role("button", name="Start", exact=True).click()
        page.locator(".prompt").wait_for()
        page.evaluate("document.querySelectorAll('.run-buttons .button')[4].click()")
        expect_live_channels(page, "asking")
        page.locator(".prompt").get_by_role("button", name="Yes").click()
        panel.wait_for("running")
        expect(page.locator(".step.running")).to_contain_text("Settle for 120 cycles")
        expect_live_channels(page, "running")
        page.locator("#prompt-input").fill("22.5")
        page.keyboard.press("Enter")
        panel.wait_for("paused")
        expect_live_channels(page, "paused")
        page.get_by_role("button", name="STOP").click()
        screen.wait_for_result()
