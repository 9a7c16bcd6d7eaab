"""Report sections from an installed third-party package."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

PAGES = """
from dataclasses import dataclass
from rigrunner.api import AnalysisDetails
from rigrunner_reports.section import BELOW, TILES, Headline, Section, Sections

@dataclass(frozen=True)
class Wear(AnalysisDetails):
    depth_um: float
    shows_recordings = True

SECTIONS = Sections(
    page=lambda report: report.result.details_of(Wear),
    headline=lambda report, page: Headline("Wear depth", "h", str(page.depth_um), "", "µm", ""),
    sections=(
        Section("track", "Wear track", 30, lambda report, page: page, package="stranger_pages"),
        Section("deep", "", 60, lambda report, page: page.depth_um > 10, inside=TILES,
                package="stranger_pages"),
        Section("never", "", 0, lambda report, page: page.depth_um > 99, inside=BELOW,
                package="stranger_pages"),
    ),
)
"""
SHOW = """
import sys
from dataclasses import replace
from rigrunner_reports.render import html
from stranger_pages import Wear
from unit.rigrunner_reports.helpers_report import loaded_result, report_input
result = replace(loaded_result(), details=(Wear(float(sys.argv[1])),))
sys.stdout.buffer.write(html(report_input(result, truth={})))
"""


@pytest.fixture
def site(tmp_path):
    """Return a folder in which the package is installed."""
    templates = tmp_path / "stranger_pages" / "templates"
    templates.mkdir(parents=True)
    (templates.parent / "__init__.py").write_text(PAGES)
    (templates / "track.html.j2").write_text(
        '<section id="track"><h2>Wear track</h2><p>{{ view.depth_um }} of {{ page.run_id }}</p>'
        "</section>"
    )
    (templates / "deep.html.j2").write_text('<div class="tile">Deeper than 10 µm</div>')
    (templates / "never.html.j2").write_text("never shown")
    info = tmp_path / "stranger_pages-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: stranger-pages\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(
        "[rigrunner_reports.sections]\nstranger = stranger_pages:SECTIONS\n"
    )
    return tmp_path


def render_report(site, depth_um):
    path = os.pathsep.join([str(site), *filter(None, sys.path)])
    return subprocess.run(
        [sys.executable, "-c", SHOW, str(depth_um)],
        env=os.environ | {"PYTHONPATH": path},
        capture_output=True,
        encoding="utf-8",
        check=False,
    )


def test_plugin_headline_tile_and_section_are_in_the_report(site):
    page = render_report(site, 12.5).stdout
    assert "Wear depth" in page
    assert '<span class="nowrap">12.5' in page
    assert '<li><a href="#track">Wear track</a></li>' in page
    assert "<p>12.5 of 20260302T091500Z_SSPB-STT-1000_DEMO-0001</p>" in page
    assert (
        page.index('<div class="tiles">')
        < page.index("Deeper than")
        < page.index("Wear track</h2>")
    )
    assert "never shown" not in page
    assert "Deeper than" not in render_report(site, 8).stdout


def test_sections_that_cannot_be_loaded_are_named(site):
    (site / "stranger_pages" / "__init__.py").write_text(PAGES.replace("SECTIONS =", "OTHERS ="))
    process = render_report(site, 8)
    assert process.returncode != 0
    assert "the report sections of 'stranger' cannot be loaded" in process.stderr
