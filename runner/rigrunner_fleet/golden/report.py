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


def golden_study(overall: Overall) -> GoldenStudy:
    """Return the check for a report."""
    return GoldenStudy(
        quantity=f"{len(overall.moved)} of {len(overall.runs)} to review",
        unit="N·m",
        asked={
            "Golden runs": str(len(overall.runs)),
            "Tolerance": f"{overall.tolerance:g} U",
            **{name: f"{now}, was {then}" for name, then, now in overall.made_by},
        },
        excluded=tuple(
            Excluded(run.name, run.problem)
            for run in overall.runs
            if run.standing is Standing.NOT_COMPARED
        ),
        tolerance=overall.tolerance,
        counts=tuple(
            (str(standing), standing.moved, count) for standing, count in overall.counts().items()
        ),
        flips=tuple((then, now, count) for (then, now), count in overall.verdict_flips().items()),
        shifts_in_u=tuple(overall.shifts_in_u()),
        set_points=tuple(
            Shift(
                frequency_hz=row.frequency_hz,
                count=row.shift_nm.n,
                mean_nm=row.shift_nm.mean,
                deviation_nm=row.shift_nm.deviation,
                mean_in_u=None if row.in_u is None else row.in_u.mean,
                largest_in_u=None if row.in_u is None else row.in_u.largest,
            )
            for row in overall.by_frequency()
        ),
        runs=tuple(
            GoldenRun(
                name=run.name,
                standing=str(run.standing),
                moved=run.standing.moved,
                verdict=run.after.verdict,
                lines=tuple(details(run)),
            )
            for run in overall.runs
        ),
    )


def junit(overall: Overall) -> str:
    """Return the check as XML, with a test case for each run."""
    standings = [run.standing for run in overall.runs]
    errors = standings.count(Standing.NOT_COMPARED)
    suite = Element(
        "testsuite",
        name="rigrunner golden",
        tests=str(len(standings)),
        failures=str(len(overall.moved) - errors),
        errors=str(errors),
        skipped="0",
    )
    for run in overall.runs:
        case = SubElement(suite, "testcase", classname="golden", name=printable(run.name))
        if run.standing.moved:
            kind = "error" if run.standing is Standing.NOT_COMPARED else "failure"
            problem = SubElement(case, kind, message=str(run.standing), type=run.standing.name)
            problem.text = printable("\n".join(details(run)))
    return tostring(suite, encoding="unicode", xml_declaration=True) + "\n"
