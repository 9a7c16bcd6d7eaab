"""The pictures of the pages are those of today: made by the scripts that the pages name."""

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
def test_each_is_a_picture_of_modest_size(drawn):
    for name, svg in drawn.items():
        assert ET.fromstring(svg).tag.endswith("svg"), name  # noqa: S314  (drawn just now)
        assert len(svg) < 120_000, name


def places(svg):
    """Return the marks of a figure: points, ticks and letters."""
    found = re.findall(r'<use [^>]*x="([\d.]+)" y="([\d.]+)"', svg)
    return np.array(found, dtype=float)


@pytest.mark.thorough
def test_those_on_the_page_are_what_is_drawn_today(drawn):
    """If not: the command of the page."""
    for name, svg in drawn.items():
        now, committed = svg.decode(), (SCRIPT.parent / name).read_text(encoding="utf-8")
        assert re.findall(r"<!-- (.*?) -->", committed) == re.findall(r"<!-- (.*?) -->", now), name
        assert np.allclose(places(committed), places(now), atol=1.0), name  # of some 700 in width


def test_the_picture_of_the_report_shows_the_result_of_today(demo):
    """If not: `python docs/images/report_picture.py RUNS docs/images`."""
    script = runpy.run_path(str(SCRIPT.with_name("report_picture.py")))
    document = json.loads((demo.loaded / "result.json").read_text(encoding="utf-8"))
    with Image.open(SCRIPT.with_name("report.png")) as image:
        assert image.text["result"] == script["shown"](document)


def test_without_a_loaded_run_it_says_what_to_do(tmp_path):
    figures = runpy.run_path(str(SCRIPT))["figures"]
    with pytest.raises(SystemExit, match="rigrunner demo --dir"):
        figures(tmp_path)
