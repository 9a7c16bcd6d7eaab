"""Every page and form in two sizes, languages and themes: readable and accessible."""

from __future__ import annotations

import shutil

import pytest
from playwright.sync_api import expect

from e2e.panel.helpers_screen import (
    ASKS,
    BENCH,
    ENDLESS,
    LOADED,
    NAME,
    OVERDUE,
    STATION,
    axe_script,
    running_panel,
    settle,
)
from e2e.panel.helpers_whole import UNREADABLE, WORDS, english_of
from helpers_cli import call

SIZES = {"desk": (1280, 720), "tablet": (768, 1024)}
WAYS = ["desk de-DE light", "tablet en-GB dark"]
"""A size in which a person acts, a language and a theme; each page is looked at in both sizes."""
LEVELS = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa"]
RUNS = 4
REASON = "inner ring is dirty"
ORDER = {
    "customer": "C",
    "customer_contact": "Street 1",
    "item": "bearing",
    "item_condition": "new",
}


def add_bench(lab):
    """Add a second bench that is in order."""
    station = (lab / BENCH).read_text(encoding="utf-8")
    station = station.replace("id: bench-1", "id: bench-2").replace(STATION, "The other bench")
    (lab / "other.yaml").write_text(station, encoding="utf-8")


@pytest.fixture(scope="session")
def studied(made_once, made_lab):
    """A lab with two benches in order and some runs of one lot, which is only copied."""

    def fill(folder) -> None:
        lab = shutil.copytree(made_lab, folder / "lab")
        add_bench(lab)
        pair = (lab / "procedures/quick_torque.yaml", "--station", lab / BENCH)
        for number in range(RUNS):
            inputs = (f"specimen=SN-{number}", "type=GE20", "lot=L-1")
            options = [word for text in inputs for word in ("--set", text)]
            result = call("run", *pair, "--runs", lab / "runs", "--unattended", *options)
            assert result.code == 0, result.err

    return made_once("studied_lab", fill) / "lab"


@pytest.fixture
def studied_lab(studied, tmp_path, monkeypatch):
    """A copy of that lab, as the working directory."""
    folder = shutil.copytree(studied, tmp_path / "lab")
    monkeypatch.chdir(folder)
    return folder


def fill_queue(folder) -> None:
    """Queue specimens of each status."""
    runs, by = ("--runs", folder / "runs"), ("--by", NAME)
    pair = ("procedures/quick_torque.yaml", "--station", BENCH)
    more = ("--set", "type=GE20", "--set", "lot=L-7")
    for words in (
        ("add", *pair, "B-100", "B-101", "B-102", *more, *by),
        ("add", *pair, "B-104", "--propose", "--by", "LIMS"),
        ("hold", "2", "--reason", REASON, *by),
        ("skip", "1", "--reason", "lost", *by),
    ):
        assert call("queue", *words, *runs).code == 0


class Walk:
    """A window that looks at each page it visits, and keeps its problems."""

    def __init__(self, screen, pictures, size: str, way: str) -> None:
        self.screen, self.page, self.pictures, self.way = screen, screen.page, pictures, way
        self.size = size
        self.problems: list[str] = []
        lab = screen.panel.folder
        files = "\n".join(path.read_text("utf-8") for path in lab.rglob("*.yaml"))
        self.lab_texts = f"{files}\n{REASON}\n{lab}"
        self.page.add_init_script(path=axe_script())

    def look(self, name: str) -> None:
        """Take pictures, and keep the problems of reading and using the page, in each size."""
        self.page.wait_for_timeout(400)
        expect(self.page.locator(".working")).to_have_count(0)  # it comes after 300 ms
        for frame in self.page.frames[1:]:
            frame.wait_for_load_state()
        self._look_in(self.size, name)
        (other,) = SIZES.keys() - {self.size}
        self._resize(other)
        self.page.evaluate("scrollTo(0, 0)")  # where it was scrolled to, a line may be half covered
        self._look_in(other, name)
        self._resize(self.size)

    def _resize(self, size: str) -> None:
        width, height = SIZES[size]
        self.page.set_viewport_size({"width": width, "height": height})
        settle(self.page)  # plots follow

    def _look_in(self, size: str, name: str) -> None:
        name = f"{name}-{size}"
        self.page.screenshot(path=self.pictures / f"whole-{name}-{self.way}.png")
        self.problems += [f"{name}: {text}" for text in self.page.evaluate(UNREADABLE)]
        if "de-DE" in self.way:
            english = english_of(self.page.evaluate(WORDS), self.lab_texts)
            self.problems += [f"{name}: English: {text[:200]}" for text in english]
        options = {"resultTypes": ["violations"], "runOnly": LEVELS}
        result = self.page.evaluate("options => axe.run(document, options)", options)
        self.problems += [
            f"{name}: {violation['id']}: {violation['nodes'][0]['html'][:120]}"
            for violation in result["violations"]
        ]

    def choose(self, procedure: str, station: str = STATION) -> None:
        """Choose a procedure and a station without texts of one language."""
        self.page.locator(".item", has_text=procedure).first.click()
        self.page.locator(".item", has_text=station).first.click()
        self.page.locator(".actions .button").click()
        self.page.wait_for_selector(".preflight")

    def check(self) -> None:
        """Do the preflight."""
        self.page.locator(".preflight > .button").click()
        self.page.locator(".light .sign").first.wait_for()
        expect(self.page.locator(".preflight > .button")).to_be_enabled()


@pytest.fixture
def walk(new_screen, studied_lab, pictures):
    """Opens a window of a size, a language and a theme at a panel of its own."""
    panels = []

    def open_walk(size, locale, theme) -> Walk:
        fill_queue(studied_lab)
        panel = running_panel(studied_lab)
        panels.append(panel)
        width, height = SIZES[size]
        screen = new_screen(
            panel.__enter__(), viewport={"width": width, "height": height}, locale=locale,
            color_scheme=theme,
        )  # fmt: skip
        return Walk(screen, pictures, size, f"{locale}-{theme}")

    yield open_walk
    for panel in panels:
        panel.__exit__(None, None, None)


@pytest.mark.thorough
@pytest.mark.parametrize("way", WAYS)
def test_pages_before_during_and_after_a_run(walk, way):  # noqa: PLR0915  (a walk)
    window = walk(*way.split())
    page = window.page
    page.goto(window.screen.panel.url)
    expect(page.locator(".rig")).to_have_count(3)
    window.look("rigs")
    window.screen.open()
    page.wait_for_selector(".item")
    window.look("choose")
    window.choose(LOADED, OVERDUE)
    page.wait_for_url("**overdue.yaml**")
    page.locator("#input-operator").fill(NAME)
    window.check()
    box = page.locator(".light.fail input").first
    box.evaluate("box => box.scrollIntoView({block: 'nearest'})")
    window.look("red")
    box.check()
    expect(page.locator("#override-by")).to_have_value(NAME)  # it was typed above already
    window.look("let-pass")
    window.screen.open()
    window.choose(ASKS)
    window.look("setup")
    for name, text in (("specimen", "B-17"), ("type", "GE20"), ("lot", "L-7"), ("operator", NAME)):
        page.locator(f"#input-{name}").fill(text)
    window.check()
    page.locator("#realtime").uncheck()
    window.look("ready")
    page.locator(".start-card .primary").click()
    page.locator(".prompt").wait_for()
    window.look("question")
    page.locator(".prompt button").first.click()
    page.locator("#prompt-input").fill("41")
    page.keyboard.press("Enter")
    expect(page.locator("#prompt-input-note")).to_contain_text("41 °C")
    window.look("question-refused")
    page.locator("#prompt-input").fill("22,5" if "de-DE" in way else "22.5")
    page.keyboard.press("Enter")
    page.locator(".run-foot .banner.warn").wait_for()
    window.look("tripped")
    widths = [
        page.locator(part).bounding_box()["width"] for part in (".run-plots", ".live-results")
    ]
    assert widths[0] == widths[1], "half of the space is empty until there is a figure"
    buttons = page.locator(".run-buttons .button:visible")
    buttons.nth(2).click()
    page.locator(".dialog .primary").click()  # without a reason
    expect(page.locator("#dialog-text-note")).not_to_be_empty()
    window.look("dialog")
    page.keyboard.press("Escape")
    page.goto(window.screen.panel.url)
    page.locator(".rig.alarm, .rig.paused").wait_for()
    window.look("rigs-busy")
    window.screen.open("#/manual")
    page.locator(".manual-open").wait_for()
    window.look("manual-in-use")
    window.screen.open("#/run")
    page.locator(".run-buttons").wait_for()
    page.keyboard.press("F9")
    window.screen.wait_for_result()
    window.look("stopped")
    page.goto(f"{window.screen.panel.url}?rig={BENCH}#/")
    window.choose(ENDLESS)  # it must still run when a slow machine pauses it
    for name, text in (("specimen", "B-18"), ("type", "GE20"), ("lot", "L-7")):
        page.locator(f"#input-{name}").fill(text)
    window.check()
    page.locator("#realtime").check()
    page.locator(".start-card .primary").click()
    page.locator(".prompt-picture").wait_for()
    window.look("picture")
    page.locator(".prompt button").first.click()
    window.screen.panel.wait_for("running")
    window.look("settling")
    window.screen.wait_for_compensation()
    window.look("recording")
    page.keyboard.press("F8")
    page.locator(".run-foot .banner.warn").wait_for()
    window.look("paused")
    buttons.nth(3).click()
    window.look("channels")
    buttons.nth(3).click()
    buttons.nth(4).click()
    for over in ("", "tester.angle"):
        page.locator(".plot-add select").first.select_option("tester.torque")
        page.locator(".plot-add select").last.select_option(over)
        page.locator(".plot-add .button").click()
    window.look("plots")
    page.keyboard.press("F9")
    window.screen.wait_for_result()
    assert window.problems == []


@pytest.mark.thorough
@pytest.mark.parametrize("way", WAYS)
def test_pages_of_stored_runs(walk, way):  # noqa: PLR0915  (a walk)
    window = walk(*way.split())
    page = window.page
    window.screen.open("#/history")
    expect(page.locator(".runs tbody tr")).to_have_count(RUNS + 2)
    window.look("history")
    page.locator("#history-search").fill("zzz")
    page.locator(".nothing").wait_for()
    window.look("history-nothing")
    folder = window.screen.panel.runs
    names = sorted(run.name for run in folder.iterdir() if "QUICK-ST_SN" in run.name)
    window.screen.open(f"#/runs/{names[0]}")
    page.locator(".result-head .verdict.pass").wait_for()
    window.look("result")
    page.locator("summary h2").last.click()
    submit = page.locator("form.inputs button[type=submit]")
    submit.click()
    expect(page.locator("#certificate-customer")).to_be_focused()
    window.look("certificate-empty")
    for name, text in {**ORDER, "by": NAME, "received": "2026-01-01"}.items():
        page.locator(f"#certificate-{name}").fill(text)
    submit.click()
    page.locator(".issued").wait_for()
    submit.click()
    expect(page.locator("#certificate-copy")).to_be_focused()
    window.look("certificate-refused")
    page.locator(".issued .button").first.click()
    page.locator(".issued .good-text, .issued .bad-text").first.wait_for()
    page.locator(".issued details summary").click()
    page.evaluate("scrollTo(0, document.body.scrollHeight)")  # no button half below the bar
    window.look("verified")
    page.locator(".issued .button").nth(1).click()
    page.locator(".dialog").wait_for()
    window.look("amend")
    page.keyboard.press("Escape")
    window.screen.open(f"#/compare/{names[0]}/{names[-1]}")
    page.locator(".compare .banner").wait_for()
    window.look("compare")
    window.screen.open(f"#/overlay/{'/'.join(names)}")
    curves = page.locator(".overlay-columns .card").last
    expect(curves.locator(".plot canvas")).to_be_visible()
    expect(curves.locator(".key.later")).to_have_count(1)  # four colours are too many for some
    window.look("overlay")
    window.screen.open("#/trends")
    page.locator("#trend-baseline").wait_for()
    expect(page.locator("#trend-quantity option").first).to_be_attached()
    page.locator("#trend-baseline").fill("x")
    page.keyboard.press("Tab")
    expect(page.locator("#trend-baseline-note")).to_contain_text("x")
    window.look("trends-refused")
    page.locator("#trend-baseline").fill("10")
    page.keyboard.press("Tab")
    page.locator(".trends .nothing").wait_for()  # too few runs for a chart
    expect(page.locator("#trend-baseline-note")).to_have_text("")
    window.look("trends")
    window.screen.open("#/runs/none")
    page.locator(".result-body .banner").wait_for()
    window.look("gone")
    assert window.problems == []


@pytest.mark.thorough
@pytest.mark.parametrize("way", WAYS)
def test_pages_of_queue_manual_mode_and_procedures(walk, way):
    window = walk(*way.split())
    page = window.page
    window.screen.open("#/queue")
    expect(page.locator(".queue-table tbody tr")).to_have_count(4)
    page.locator("#queue-procedure").select_option("procedures/quick_torque.yaml")
    page.locator("#input-operator").fill(NAME)
    window.look("queue")
    page.locator("#queue-scan").fill("B-101")
    page.keyboard.press("Enter")
    expect(page.locator("#queue-scan-note")).to_contain_text("B-101")
    window.look("queue-refused")
    page.locator(".queue-add details > summary").click()
    page.locator("#queue-list").fill("specimen;lot\nSN-4;L-8\nSN-5")
    page.locator(".queue-add details .primary").click()
    expect(page.locator("#queue-list-note li")).to_have_count(1)
    window.look("queue-list-refused")
    window.screen.open("#/manual")
    page.locator(".manual-open").wait_for()
    window.look("manual")
    window.check()
    page.locator(".manual-open .primary").click()
    page.locator(".drive").first.wait_for()
    for place, text in ((0, "99"), (1, "abc")):
        page.locator(".drive input").nth(place).fill(text)
        page.locator(".drive input").nth(place).press("Enter")
    page.locator("#cycles").fill("2")
    page.locator(".manual-record .primary").click()
    expect(page.locator(".manual .field.bad")).to_have_count(3)
    window.look("manual-refused")
    page.locator(".manual .head .button:not([aria-pressed])").click()
    window.screen.panel.wait_for("finished")
    window.look("manual-ended")
    window.screen.open("#/procedures")
    page.locator(".runs tbody tr").first.wait_for()
    window.look("procedures")
    page.locator(".runs tbody tr", has_text="quick_torque").first.click()
    page.locator(".problems-box .good-text").wait_for()
    window.look("procedure")
    page.locator(".cm-content").click()
    page.keyboard.press("Control+Home")
    page.keyboard.type("nonsense: 3\n")
    page.locator(".problems-box li").first.wait_for()
    window.look("procedure-wrong")
    window.screen.open("#/procedures/starting_torque_1000n")
    page.locator(".problems-box .good-text").wait_for()
    window.look("procedure-shipped")
    assert window.problems == []


@pytest.mark.thorough
@pytest.mark.parametrize("locale", ["de-DE", "en-GB"])
def test_header_bar_fits_every_width(new_screen, lab, locale):
    add_bench(lab)
    with running_panel(lab) as panel:
        screen = new_screen(panel, locale=locale)
        page = screen.page
        page.set_viewport_size({"width": 1280, "height": 720})
        screen.open()
        page.locator(".control .button").first.click()
        screen.say_name(NAME)
        page.locator(".control .quiet:visible").wait_for()
        for width in (768, 820, 1024, 1150, 1280, 1366, 1440, 1600, 1720, 1920):
            page.set_viewport_size({"width": width, "height": 900})
            settle(page)
            problems = page.evaluate(UNREADABLE)
            assert (width, [text for text in problems if "cut off" not in text]) == (width, [])
            name = "getComputedStyle(document.querySelector('.holder')).overflow && "
            size = "document.querySelector('.holder')"
            fits = f"{name} {size}.scrollWidth <= {size}.clientWidth + 1"
            assert page.evaluate(fits), f"who has control is cut off at {width}"
