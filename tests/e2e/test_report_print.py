"""Prints a report to PDF pages with a real browser: as a lab would, offline."""

from __future__ import annotations

import re
import shutil
import subprocess

import pytest

from helpers_lacking import lacking
from helpers_thorough import first
from rigrunner_reports.render import html
from unit.rigrunner_reports.helpers_report import loaded_result, no_load_result, report_input

pytestmark = pytest.mark.figures

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")
QUIET = (
    *("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
    "--host-resolver-rules=MAP * ~NOTFOUND",
)
A4_POINTS = (595, 842)


def find_program(programs, what):
    """Return the first installed one of the programs; skip, or fail where it is required."""
    program = next((path for name in programs if (path := shutil.which(name))), None)
    if program is None:
        lacking("BROWSER", f"{what} is not installed: none of {', '.join(programs)} was found")
    return program


@pytest.fixture(scope="module", params=first(1, [loaded_result, no_load_result]))
def printed(request, tmp_path_factory):
    browser = find_program(BROWSERS, "a browser")
    result, folder = request.param(), tmp_path_factory.mktemp("print")
    page, pdf = folder / "report.html", folder / "report.pdf"
    page.write_bytes(html(report_input(result)))
    command = [browser, *QUIET, f"--user-data-dir={folder / 'profile'}", "--no-pdf-header-footer"]
    subprocess.run(
        [*command, f"--print-to-pdf={pdf}", page.as_uri()],
        check=True,
        capture_output=True,
        timeout=120,
    )
    return result, pdf


def pages(pdf):
    """Return the text of each page."""
    reader = find_program(["pdftotext"], "a PDF reader (poppler-utils)")
    text = subprocess.run([reader, "-layout", pdf, "-"], check=True, capture_output=True).stdout
    return text.decode("utf-8").split("\f")[:-1]


def test_pages_are_a4(printed):
    _, pdf = printed
    boxes = re.findall(rb"/MediaBox \[0 0 ([0-9.]+) ([0-9.]+)\]", pdf.read_bytes())
    assert boxes
    assert {tuple(round(float(side)) for side in box) for box in boxes} == {A4_POINTS}


def test_every_page_shows_the_run_and_its_page_number(printed):
    result, pdf = printed
    texts = pages(pdf)
    assert 3 <= len(texts) <= 9
    for number, text in enumerate(texts, 1):
        assert f"Page {number} of {len(texts)}" in text
        assert result.run.run_id in text


def test_report_begins_with_headline_and_ends_with_end_mark(printed):
    result, pdf = printed
    texts = pages(pdf)
    assert result.symbol in texts[0]
    assert "Result" in texts[0]
    assert f"End of report {result.run.run_id}" in texts[-1]


def test_all_figures_are_printed_and_numbered_in_order(printed):
    _, pdf = printed
    text = "".join(pages(pdf))
    numbers = [int(number) for number in re.findall(r"Figure (\d+)\.", text)]
    assert numbers == list(range(1, len(numbers) + 1))
    assert len(numbers) >= 5
