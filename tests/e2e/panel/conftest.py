"""A panel, a browser and screens for the tests of this folder."""

from __future__ import annotations

import os
import shutil
from contextlib import ExitStack
from pathlib import Path

import pytest
from playwright.sync_api import expect, sync_playwright

from e2e.panel.helpers_screen import (
    WITHIN_S,
    Screen,
    browser_path,
    quick_lab,
    require_driver,
    running_panel,
)

FLAGS = (
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
)  # fmt: skip


expect.set_options(timeout=1000 * WITHIN_S)


@pytest.fixture(scope="session")
def made_lab(made_once):
    """A lab with quick procedures, which is only copied."""
    return made_once("panel_lab", lambda folder: quick_lab(folder / "lab")) / "lab"


@pytest.fixture
def lab(made_lab, tmp_path):
    """A lab of the test's own, with its own runs and queue."""
    return shutil.copytree(made_lab, tmp_path / "quick_lab")


@pytest.fixture(autouse=True)
def own_markers(tmp_path, monkeypatch):
    """Locks and markers of rigs in a folder of the test: others leave rigs energised on purpose."""
    monkeypatch.setenv("RIGRUNNER_LOCKS", str(tmp_path / "rigs"))


@pytest.fixture(scope="session")
def new_chromium():
    """Starts a real Chromium with more flags; a process has only one driver."""
    require_driver()
    with sync_playwright() as playwright, ExitStack() as browsers:

        def new(*flags):
            browser = playwright.chromium.launch(
                executable_path=browser_path(), args=[*FLAGS, *flags]
            )
            browsers.callback(browser.close)
            return browser

        yield new


@pytest.fixture(scope="session")
def chromium(new_chromium):
    """A real Chromium."""
    return new_chromium()


@pytest.fixture
def panel(lab):
    """A panel of the test's own."""
    with running_panel(lab) as running:
        yield running


@pytest.fixture
def new_screen(chromium, request):
    """Opens windows with a browser profile each; none may contact another host or fail.

    Without a given panel they are at that of the test, which only then has to start.
    """
    windows = []
    if "panel" in request.fixturenames:
        request.getfixturevalue("panel")  # ends after its windows are closed

    def new(panel=None, **options):
        panel = panel or request.getfixturevalue("panel")
        defaults = {"viewport": {"width": 1280, "height": 720}, "locale": "en-GB"}
        context = chromium.new_context(**{**defaults, **options})
        context.set_default_timeout(1000 * WITHIN_S)
        screen = Screen(context.new_page(), panel)
        windows.append((context, screen))
        return screen

    yield new
    for context, screen in windows:
        assert screen.strangers == []
        assert screen.errors == []
        context.close()


@pytest.fixture
def screen(panel, new_screen):
    """One window."""
    return new_screen(panel)


@pytest.fixture(scope="session")
def pictures(tmp_path_factory):
    """The folder of screenshots, which CI keeps."""
    path = os.environ.get("RIGRUNNER_SCREENSHOTS")
    folder = Path(path) if path else tmp_path_factory.mktemp("screenshots")
    folder.mkdir(parents=True, exist_ok=True)
    return folder
