"""The figures of the pages are up to date with the scripts that the pages name."""

from __future__ import annotations

import json
import re
import runpy
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from PIL import Image

from helpers_docs import ROOT, links

pytestmark = pytest.mark.figures

PAGE = ROOT / "docs/explanation/the-paper.md"
SCRIPT = ROOT / "docs/images/paper_figures.py"


@pytest.fixture(scope="module")
def drawn(demo):
    return runpy.run_path(str(SCRIPT))["figures"](demo.folder)


@pytest.mark.thorough
def test_every_figure_of_the_page_is_drawn(drawn):
    shown = {(PAGE.parent / link).resolve() for link in links(PAGE) if link.endswith(".svg")}
    assert shown == {SCRIPT.parent / name for name in drawn}


@pytest.mark.thorough
def test_each_figure_is_a_small_svg(drawn):
    for name, svg in drawn.items():
        assert ET.fromstring(svg).tag.endswith("svg"), name  # noqa: S314  (drawn just now)
        assert len(svg) < 120_000, name


def marks_of(svg):
    """Return the marks of a figure: points, ticks and letters."""
    coordinates = re.findall(r'<use [^>]*x="([\d.]+)" y="([\d.]+)"', svg)
    return np.array(coordinates, dtype=float)


@pytest.mark.thorough
def test_figures_of_the_page_are_up_to_date(drawn):
    """If not, run the command of the page."""
    for name, svg in drawn.items():
        now, committed = svg.decode(), (SCRIPT.parent / name).read_text(encoding="utf-8")
        assert re.findall(r"<!-- (.*?) -->", committed) == re.findall(r"<!-- (.*?) -->", now), name
        # in a figure some 700 wide
        assert np.allclose(marks_of(committed), marks_of(now), atol=1.0), name


def test_picture_of_the_report_is_up_to_date(demo):
    """If not, run `python docs/images/report_picture.py RUNS docs/images`."""
    script = runpy.run_path(str(SCRIPT.with_name("report_picture.py")))
    document = json.loads((demo.loaded / "result.json").read_text(encoding="utf-8"))
    with Image.open(SCRIPT.with_name("report.png")) as image:
        assert image.text["result"] == script["shown"](document)


def test_without_a_loaded_run_the_script_says_what_to_do(tmp_path):
    figures = runpy.run_path(str(SCRIPT))["figures"]
    with pytest.raises(SystemExit, match="rigrunner demo --dir"):
        figures(tmp_path)
