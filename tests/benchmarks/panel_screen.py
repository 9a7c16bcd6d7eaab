"""Frame rate and delay of the panel in a real browser: see docs/evidence/panel.md.

    python tests/benchmarks/panel_screen.py [PICTURE]

Not a test: it takes three minutes, of real time. It serves a panel, runs the shipped procedure on
the simulated station in real time in a headless Chromium, and records in the page when the curve
of each swing is drawn, and when STOP is clicked at the end. The clocks of the rig and of the
browser are both the machine's monotonic one; the offset between them is measured. PICTURE is the
file of a screenshot.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections import defaultdict
from datetime import datetime
from pathlib import Path

import numpy as np
from playwright.sync_api import sync_playwright

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from benchmarks.panel import tell
from e2e.panel.helpers_screen import Screen, browser_path, running_panel
from helpers_cli import call

# uPlot clears the canvas before it draws, with the swing that arrived last
PROBE = """
(() => {
  const drawings = [];
  let newest = null;
  let clicked = 0;
  window.probe = { drawings, clicked: () => clicked };
  const Real = window.WebSocket;
  window.WebSocket = class extends Real {
    constructor(...words) {
      super(...words);
      this.addEventListener('message', ({ data }) => {
        if (typeof data === 'string') return;
        const n = new DataView(data).getUint32(0, true);
        const header = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, n)));
        if (header.kind === "curve") newest = header;
      });
    }
  };
  const clear = CanvasRenderingContext2D.prototype.clearRect;
  CanvasRenderingContext2D.prototype.clearRect = function (...box) {
    if (newest && this.canvas.closest('.plot-curve')) {
      const { recording, monotonic_s } = newest;
      drawings.push([recording, monotonic_s, performance.now()]);
      newest = null;
    }
    return clear.apply(this, box);
  };
  document.addEventListener('click', ({ target }) => {
    if (target.closest('.stop')) clicked = Date.now();
  }, true);
})();
"""
RIG = "simulated"
SCREENSHOT_AT = "at 5 Hz"
LAST = "at 35 Hz"


def offset_s(page):
    """Return the offset of the rig's clock to the page's, the best of ten tries."""
    tries = []
    for _ in range(10):
        before = time.monotonic()
        now = page.evaluate("() => performance.now()") / 1000
        after = time.monotonic()
        tries.append((after - before, (before + after) / 2 - now))
    return min(tries)[1]


def run(folder, picture):
    """Do a run and print the rate and the delays."""
    call("run", "no_load_inertia_sweep", "--station", RIG, "--unattended",
         "--runs", folder / "runs")  # fmt: skip
    served = running_panel(folder, options=("--station", RIG))
    with served as panel, sync_playwright() as playwright:
        flags = ["--no-sandbox", "--disable-gpu"]
        browser = playwright.chromium.launch(executable_path=browser_path(), args=flags)
        page = browser.new_page(viewport={"width": 1280, "height": 720}, locale="en-GB")
        page.add_init_script(PROBE)
        screen = Screen(page, panel)
        screen.open(station=RIG)
        screen.choose("SSPB-STT-1000", "Simulated swing friction tester")
        screen.fill_in()
        screen.check_rig()
        screen.start()
        step = page.locator(".step.running")
        step.filter(has_text=f"cycles {SCREENSHOT_AT}").wait_for(timeout=400_000)
        page.wait_for_timeout(5200)
        if picture:
            page.screenshot(path=picture)
        step.filter(has_text=f"cycles {LAST}").wait_for(timeout=400_000)
        page.wait_for_timeout(800)
        offset = offset_s(page)
        drawings = page.evaluate("() => probe.drawings")
        page.locator(".stop").click()
        screen.wait_for_result()
        clicked = page.evaluate("() => probe.clicked()") / 1000
        events = [item["event"] for item in panel.get("events", RIG)["items"]]
        browser.close()
    drawn = defaultdict(list)
    for recording, ended_s, now_ms in drawings:
        drawn[recording].append((now_ms / 1000 + offset, now_ms / 1000 + offset - ended_s))
    for recording, times in drawn.items():
        drawn_s, ages = np.array(times).T
        rate = (len(drawn_s) - 1) / np.ptp(drawn_s) if len(drawn_s) > 1 else float("nan")
        tell(f"{recording:10} {rate:5.1f} curves/s drawn; age when drawn: median"
             f" {1e3 * np.median(ages):6.1f} ms, greatest {1e3 * ages.max():6.1f} ms")  # fmt: skip
    interrupted = next(event["utc"] for event in events if event.get("action") == "abort")
    stop_s = datetime.fromisoformat(interrupted).timestamp() - clicked
    tell(f"from the click on STOP until the run is interrupted: {1e3 * stop_s:.0f} ms")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as name:
        run(Path(name), sys.argv[1] if len(sys.argv) > 1 else "")
