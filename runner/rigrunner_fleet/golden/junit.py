"""The check as a JUnit file for continuous integration, with a test case for each run."""

from __future__ import annotations

from typing import TYPE_CHECKING
from xml.etree.ElementTree import Element, SubElement, tostring

from rigrunner.printable import printable
from rigrunner_fleet.golden.comparing import Standing
from rigrunner_fleet.golden.words import details

if TYPE_CHECKING:
    from rigrunner_fleet.golden.comparing import Compared
    from rigrunner_fleet.golden.overall import Overall


def junit(found: Overall) -> str:
    """Return the check as XML."""
    standings = [each.standing for each in found.runs]
    errors = standings.count(Standing.NOT_COMPARED)
    suite = Element(
        "testsuite",
        name="rigrunner golden",
        tests=str(len(standings)),
        failures=str(len(found.moved) - errors),
        errors=str(errors),
        skipped="0",
    )
    for each in found.runs:
        _case(suite, each)
    return tostring(suite, encoding="unicode", xml_declaration=True) + "\n"


def _case(suite: Element, each: Compared) -> None:
    case = SubElement(suite, "testcase", classname="golden", name=printable(each.name))
    if each.standing.moved:
        kind = "error" if each.standing is Standing.NOT_COMPARED else "failure"
        problem = SubElement(case, kind, message=str(each.standing), type=each.standing.name)
        problem.text = printable("\n".join(details(each)))
