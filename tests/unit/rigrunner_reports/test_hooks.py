from __future__ import annotations

import subprocess
import sys

from rigrunner.registry import load_registry
from unit.rigrunner_reports.helpers_report import report_input


def test_html_format_is_registered_by_entry_point():
    render = load_registry().make("report_format", "html", {})
    assert render(report_input()).startswith(b"<!DOCTYPE html>")


def test_declaring_the_formats_loads_no_heavy_library():
    code = (
        "import sys, rigrunner_reports.hooks as h; h.rigrunner_report_formats();"
        "print([m for m in ('numpy', 'matplotlib', 'jinja2') if m in sys.modules])"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"
