"""The check, for a report on many runs, and as a JUnit file for continuous integration."""

from __future__ import annotations

from typing import TYPE_CHECKING
from xml.etree.ElementTree import Element, SubElement, tostring

from rigrunner.api.studies import Excluded, GoldenRun, GoldenStudy, Shift
from rigrunner.printable import printable
from rigrunner_fleet.golden.comparing import Standing
from rigrunner_fleet.golden.words import details

if TYPE_CHECKING:
    from rigrunner_fleet.golden.overall import Overall


def golden_study(found: Overall) -> GoldenStudy:
    """Return the check for a report."""
    return GoldenStudy(
        quantity=f"{len(found.moved)} of {len(found.runs)} to be looked at",
        unit="N·m",
        asked={
            "Golden runs": str(len(found.runs)),
            "Tolerance": f"{found.tolerance:g} U",
            **{name: f"{now}, was {then}" for name, then, now in found.made_by},
        },
        excluded=tuple(
            Excluded(each.name, each.problem)
            for each in found.runs
            if each.standing is Standing.NOT_COMPARED
        ),
        tolerance=found.tolerance,
        counts=tuple((str(each), each.moved, count) for each, count in found.counts().items()),
        flips=tuple((then, now, count) for (then, now), count in found.verdict_flips().items()),
        shifts_in_u=tuple(found.shifts_in_u()),
        set_points=tuple(
            Shift(
                frequency_hz=each.frequency_hz,
                count=each.shift_nm.n,
                mean_nm=each.shift_nm.mean,
                deviation_nm=each.shift_nm.deviation,
                mean_in_u=None if each.in_u is None else each.in_u.mean,
                largest_in_u=None if each.in_u is None else each.in_u.largest,
            )
            for each in found.by_frequency()
        ),
        runs=tuple(
            GoldenRun(
                name=each.name,
                standing=str(each.standing),
                moved=each.standing.moved,
                verdict=each.after.verdict,
                lines=tuple(details(each)),
            )
            for each in found.runs
        ),
    )


def junit(found: Overall) -> str:
    """Return the check as XML, with a test case for each run."""
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
        case = SubElement(suite, "testcase", classname="golden", name=printable(each.name))
        if each.standing.moved:
            kind = "error" if each.standing is Standing.NOT_COMPARED else "failure"
            problem = SubElement(case, kind, message=str(each.standing), type=each.standing.name)
            problem.text = printable("\n".join(details(each)))
    return tostring(suite, encoding="unicode", xml_declaration=True) + "\n"
