"""The upgrade of a station's register from its older form, with its layout."""

from __future__ import annotations

import pytest

from helpers_language import STATION, only_problem
from rigrunner.api.errors import InvalidFileError
from rigrunner.station import parse_station
from rigrunner.yamlfile.upgrade import upgraded

HEAD = "rigrunner: station/1\ninstruments:\n"
CREEP = "creep: {limit: 0.1 % reading, source: sheet}\n"
ERRORS = f"errors: {{{CREEP.strip()}}}\n"
BLOCK = """  - channel: a.b
    errors:   # of the sheet
      # first
      creep: {limit: 0.1 % reading, source: sheet}
    accuracy: {gain: 0.3 %, offset: 0 N·m}   # split
    serial: "1"
"""


@pytest.mark.parametrize(
    ("before", "after"),
    [
        (BLOCK, """  - channel: a.b
    accuracy:  # split
      gain: 0.3 %
      offset: 0 N·m
      # first
      creep: {limit: 0.1 % reading, source: sheet}
    serial: "1"
"""),
        (f"  - channel: a.b\n    accuracy: 0.5 % FS  # one\n    {ERRORS}safety: {{}}\n",
         "  - channel: a.b\n    accuracy:  # one\n      overall: 0.5 % FS\n      " + CREEP
         + "safety: {}\n"),
        (f"  - channel: a.b\n    points: []\n    {ERRORS}",
         "  - channel: a.b\n    points: []\n    " + ERRORS.replace("errors", "accuracy")),
        ("  - {channel: a.b, accuracy: 1 % FS, errors: {creep: {limit: 1 mN·m}}, id: x}\n",
         "  - {channel: a.b, accuracy: {overall: 1 % FS, creep: {limit: 1 mN·m}}, id: x}\n"),
    ],
)  # fmt: skip
def test_errors_are_moved_under_accuracy_with_comments(before, after):
    assert upgraded(HEAD + before, "s.yaml") == HEAD + after
    assert upgraded(HEAD + after, "s.yaml") == HEAD + after


def test_register_that_cannot_be_edited_is_refused():
    text = HEAD + "  - errors: {creep: {limit: 1 mN·m}}\n    accuracy: 1 % FS\n"
    with pytest.raises(InvalidFileError, match="its register cannot be upgraded"):
        upgraded(text, "s.yaml")


def test_older_station_is_refused_unless_stored_with_a_run():
    older = STATION.replace("    serial: T-1\n", f"    serial: T-1\n    {ERRORS}")
    problem = only_problem(parse_station, older, "s.yaml")
    assert problem.field == "instruments[0].errors"
    assert problem.hint == "type 'rigrunner upgrade s.yaml'"
    (stored,) = parse_station(older, "run", stored=True).model.instruments
    (upgraded_entry,) = parse_station(upgraded(older, "s.yaml"), "s.yaml").model.instruments
    assert stored == upgraded_entry
    assert upgraded_entry.half_width("creep", 5.0) == 0.005
