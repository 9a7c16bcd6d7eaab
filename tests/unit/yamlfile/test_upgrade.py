"""The upgrade of texts in an older form of the language, with their layout."""

from __future__ import annotations

import pytest

from helpers_language import only_problem
from rigrunner.yamlfile import parse
from rigrunner.yamlfile.upgrade import refuse_older, upgraded, upgraded_acceptance

HEAD = "rigrunner: procedure/1\n"
NEW = "rigrunner: procedure/2\n"


def test_analysis_keys_are_moved_under_its_name_with_comments():
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
def test_every_layout_is_upgraded(before, after):
    assert upgraded(HEAD + before, "p.yaml") == NEW + after


def test_json_procedure_is_upgraded():
    text = '{\n "rigrunner": "procedure/1",\n "analysis": {\n  "starts": {},\n  "fits": []\n }\n}'
    assert parse(upgraded(text, "p"), "p").data == {
        "rigrunner": "procedure/2",
        "analysis": [{"breakaway": {"window": "5 deg", "fits": []}}],
    }


@pytest.mark.parametrize("text", [NEW + "analysis: []\n", "rigrunner: import/1\n", "- a\n", "7\n"])
def test_current_text_is_unchanged(text):
    assert upgraded(text, "p.yaml") == text


def test_text_that_cannot_be_edited_is_refused():
    text = HEAD + "? analysis\n:\n  outliers: mad\n"
    problem = only_problem(upgraded, text, "p.yaml")

    assert "it cannot be upgraded from 'procedure/1' to 'procedure/2'" in problem.message
    assert problem.location.file == "p.yaml"


MEASURAND = "measurand: {nature: total, condition: from_rest}"


@pytest.mark.parametrize(
    ("before", "after"),
    [
        (f"  limit:   # l\n    max: 1 N·m   # c\n    source: x\n    {MEASURAND}\n  rule: simple\n",
         (f"  limits:   # l\n    - of: torque\n      mean: yes\n      max: 1 N·m   # c\n"
          f"      source: x\n      {MEASURAND}\n  rule: simple\n")),
        (f"  limit: {{max: 1 N·m, {MEASURAND}}}   # c\n",
         f"  limits: [{{of: torque, mean: yes, max: 1 N·m, {MEASURAND}}}]   # c\n"),
        (f"  limits:\n    - of: mean\n      min: 1 N·m\n      {MEASURAND}\n",
         f"  limits:\n    - of: torque\n      mean: yes\n      min: 1 N·m\n      {MEASURAND}\n"),
        ((f"  limits:\n  - {{max: 1 N·m, of: each_frequency, {MEASURAND}}}\n"
          f"  - {{max: 2 N·m, of: each_frequency, at: [5 Hz, 7 Hz], {MEASURAND}}}\n"
          "  - {of: swing, each: block, max: 3 N·m}\n"),
         ("  limits:\n  - {max: 1 N·m, of: torque, each: frequency, "
          f"except: {{frequency: [5 Hz, 7 Hz]}}, {MEASURAND}}}\n"
          "  - {max: 2 N·m, of: torque, each: frequency, "
          f"where: {{frequency: [5 Hz, 7 Hz]}}, {MEASURAND}}}\n"
          "  - {of: swing, each: block, max: 3 N·m}\n")),
        ((f"  limit:\n    of: each_frequency\n    at:\n    - 5 Hz   # c\n    max: 1 N·m\n"
          f"    {MEASURAND}\n"),
         (f"  limits:\n    - of: torque\n      each: frequency\n      where: {{frequency: [5 Hz]}}"
          f"   # c\n      max: 1 N·m\n      {MEASURAND}\n")),
    ],
)  # fmt: skip
@pytest.mark.parametrize("mark", ["procedure/2", "acceptance/1"])
def test_older_limit_becomes_a_limit_of_the_torque(before, after, mark):
    head = f"rigrunner: {mark}\nacceptance:\n"
    assert upgraded(head + before, "p.yaml") == head + after
    assert upgraded(head + after, "p.yaml") == head + after


def test_limits_and_analysis_are_upgraded_together():
    text = '{"rigrunner": "procedure/1", "analysis": {}, "acceptance": {"limit": {"max": "1 N·m"}}}'
    content = parse(upgraded(text, "p"), "p").data
    limit = {"of": "torque", "mean": "yes", "max": "1 N·m"}
    assert content == {
        "rigrunner": "procedure/2",
        "analysis": [],
        "acceptance": {"limits": [limit]},
    }


def test_older_limits_are_refused_with_the_upgrade_command():
    text = f"rigrunner: acceptance/1\nacceptance:\n  limit: {{max: 1 N·m, {MEASURAND}}}\n"
    problem = only_problem(refuse_older, parse(text, "my limits.yaml"))
    assert (problem.field, problem.location.line) == ("acceptance.limit", 3)
    assert problem.hint == "type 'rigrunner upgrade 'my limits.yaml''"


def test_older_limits_of_a_document_are_upgraded():
    older = {"limit": {"max": "1 N·m", "of": "each_frequency"}, "rule": "simple"}
    limit = {"of": "torque", "each": "frequency", "max": "1 N·m"}
    assert upgraded_acceptance(older) == {"limits": [limit], "rule": "simple"}
    assert upgraded_acceptance({"limits": [limit]}) == {"limits": [limit]}
