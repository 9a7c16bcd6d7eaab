#!/usr/bin/env python3
"""Makes the picture of a report that README shows, from the loaded run on the simulated rig.

    rigrunner demo --dir RUNS
    python docs/images/report_picture.py RUNS docs/images

It needs Chromium. The PNG has the result that it shows as a text, which a test compares with the
demonstration of today.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from PIL import Image, PngImagePlugin

WIDTH, HEIGHT = 1000, 1410
NAME, KEY = "report.png", "result"


def shown(document: dict[str, Any]) -> str:
    """Return what a result document gives for the picture to show: torque and verdict."""
    torque = document["headline"]["compensated"]
    value, expanded = torque["value"], torque["expanded_uncertainty_95"]
    return f"{value:.4f} ± {expanded:.4f} {torque['unit']}: {document['decision']['verdict']}"


def make(runs: Path, folder: Path) -> Path:
    """Write the picture into a folder; raise SystemExit where there is no run or no Chromium."""
    browser = shutil.which("chromium")
    folders = sorted(runs.glob("*SSPB-STT-1000*"))
    if browser is None or not folders:
        sys.exit("needed: chromium, and the runs of: rigrunner demo --dir RUNS")
    with tempfile.TemporaryDirectory() as place:
        drawn = Path(place) / NAME
        words = (f"--screenshot={drawn}", f"--window-size={WIDTH},{HEIGHT}", "--hide-scrollbars")
        page = (folders[-1] / "report.html").resolve().as_uri()
        subprocess.run([browser, "--headless", "--no-sandbox", *words, page], check=True)  # noqa: S603  (our own page)
        text = PngImagePlugin.PngInfo()
        document = json.loads((folders[-1] / "result.json").read_text(encoding="utf-8"))
        text.add_itxt(KEY, shown(document))
        with Image.open(drawn) as image:
            image.convert("RGB").quantize(256).save(folder / NAME, pnginfo=text, optimize=True)
    return folder / NAME


if __name__ == "__main__":
    print(make(Path(sys.argv[1]), Path(sys.argv[2])))  # noqa: T201  (what it wrote)
