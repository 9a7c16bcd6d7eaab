"""The figures on the page about the paper are made by the script that the page names."""

from __future__ import annotations

import runpy
from xml.etree import ElementTree as ET

import pytest

from helpers_docs import ROOT, links

PAGE = ROOT / "docs/explanation/the-paper.md"
SCRIPT = ROOT / "docs/images/paper_figures.py"


@pytest.fixture(scope="module")
def drawn(demo):
    return runpy.run_path(str(SCRIPT))["figures"](demo.folder)


def test_every_figure_of_the_page_is_drawn(drawn):
    shown = {(PAGE.parent / link).resolve() for link in links(PAGE) if link.endswith(".svg")}
    assert shown == {SCRIPT.parent / name for name in drawn}


def test_each_is_a_picture_of_modest_size(drawn):
    for name, svg in drawn.items():
        assert ET.fromstring(svg).tag.endswith("svg"), name  # noqa: S314  (drawn just now)
        assert len(svg) < 120_000, name


def test_without_a_loaded_run_it_says_what_to_do(tmp_path):
    figures = runpy.run_path(str(SCRIPT))["figures"]
    with pytest.raises(SystemExit, match="rigrunner demo --dir"):
        figures(tmp_path)
