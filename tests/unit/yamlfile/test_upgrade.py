"""Texts of an older form of the language in today's: what they say, and how they look."""

from __future__ import annotations

import pytest

from helpers_language import only_problem
from rigrunner.yamlfile import parse
from rigrunner.yamlfile.upgrade import upgraded

HEAD = "rigrunner: procedure/1\n"
NEW = "rigrunner: procedure/2\n"


def test_the_keys_of_an_analysis_stand_under_its_name_with_their_comments():
    text = (
        "# of a lab\nrigrunner: procedure/1   # the form\nid: X\nanalysis:   # why\n"
        "  # first\n  outliers: {grubbs: {alpha: 0.05}}\n\n  fits:\n  - polynomial: {degree: 2}\n"
        "  # primary: none\n# the end\nteardown: []\n"
    )
    assert upgraded(text, "p.yaml") == (
        "# of a lab\nrigrunner: procedure/2   # the form\nid: X\nanalysis:   # why\n"
        "  - swing_torque:\n"
        "      # first\n      outliers: {grubbs: {alpha: 0.05}}\n\n      fits:\n"
        "      - polynomial: {degree: 2}\n      # primary: none\n# the end\nteardown: []\n"
    )


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("analysis: {fits: [pchip]}  # c\n", "analysis:\n  - swing_torque: {fits: [pchip]}  # c\n"),
        ("analysis: {fits:\n  [pchip]}\n", "analysis: [{swing_torque: {fits:\n  [pchip]}}]\n"),
        ("analysis: {}\n", "analysis: []\n"),
        ("main: []", "main: []"),
        ("analysis:\n  outliers: mad", "analysis:\n  - swing_torque:\n      outliers: mad"),
        ("analysis:\r\n  outliers: mad\r\n",
         "analysis:\r\n  - swing_torque:\r\n      outliers: mad\r\n"),
        ("analysis:\n  outliers: mad\n  starts: {window: 4 deg,  smoothing: 3 ms}   # of 4°\n",
         ("analysis:\n  - breakaway:\n      outliers: mad\n      window: 4 deg\n"
          "      smoothing: 3 ms   # of 4°\n")),
        ("analysis:\n  starts:   # s\n    # w\n    window: 4 deg\n  outliers: mad\n",
         ("analysis:\n  - breakaway:\n      # s\n      # w\n      window: 4 deg\n"
          "      outliers: mad\n")),
        ("analysis:\n  starts: {}\n", "analysis:\n  - breakaway:\n      window: 5 deg\n"),
        ("analysis: {starts: {window: 4 deg}, outliers: mad}\n",
         "analysis:\n  - breakaway: {window: 4 deg, outliers: mad}\n"),
    ],
)  # fmt: skip
def test_each_way_to_lay_it_out(before, after):
    assert upgraded(HEAD + before, "p.yaml") == NEW + after


def test_a_procedure_as_json_of_a_run_by_hand():
    text = '{\n "rigrunner": "procedure/1",\n "analysis": {\n  "starts": {},\n  "fits": []\n }\n}'
    assert parse(upgraded(text, "p"), "p").data == {
        "rigrunner": "procedure/2",
        "analysis": [{"breakaway": {"window": "5 deg", "fits": []}}],
    }


@pytest.mark.parametrize("text", [NEW + "analysis: []\n", "rigrunner: import/1\n", "- a\n", "7\n"])
def test_what_has_todays_form_stays_as_it_is(text):
    assert upgraded(text, "p.yaml") == text


def test_what_cannot_be_edited_is_refused_and_not_misread():
    text = HEAD + "? analysis\n:\n  outliers: mad\n"
    problem = only_problem(upgraded, text, "p.yaml")

    assert "it cannot be brought from 'procedure/1' to 'procedure/2'" in problem.message
    assert problem.location.file == "p.yaml"
