"""Checks on analyses that name their results."""

from __future__ import annotations

import re
from collections import Counter
from typing import TYPE_CHECKING, Any

import numpy as np

from rigrunner.analysis.scrutiny import Scrutiny
from rigrunner.api.data import Measurement, RunData
from rigrunner.api.errors import DataError, PluginError
from rigrunner.api.hooks import AnalysisRecord
from rigrunner.api.instruments import Instrument
from rigrunner.api.member import NAME, Member
from rigrunner.api.rig import RigDescription
from rigrunner.api.settings import own_keys
from rigrunner.api.units import QuantityError, unit
from rigrunner.study.tools import tools
from rigrunner_testing.check import AnyCheck, Nonconformity, check, demand

if TYPE_CHECKING:
    from rigrunner.api.analysis import NeededChannel, Requirements
    from rigrunner.api.findings import Findings, ResultDefinition
    from rigrunner_testing.subjects import Subject

PLACES, ROWS = 3, 4
"""A made-up run has so many places, and so many rows at each."""
START = "2026-01-05T10:00:{second:02d}+00:00"


@check(fix="give `yields` one ResultDefinition for each result, with a name and a unit")
def says_what_it_yields(subject: Subject) -> None:
    """From its settings alone it says which results it names, each in a unit."""
    named = _definitions(subject)
    demand(named, "it yields no result")
    for each in named:
        demand(re.fullmatch(NAME, each.name), f"'{each.name}' is no name for a result")
        try:
            unit(each.unit)
        except QuantityError as error:
            raise Nonconformity(f"the result '{each.name}': {error.message}") from error
    twice = [name for name, count in Counter(each.name for each in named).items() if count > 1]
    demand(not twice, f"it yields '{twice[:1]}' twice")


@check(fix="let `requires` give Requirements: a NeededChannel for each channel, as 'role.name'")
def says_what_it_requires(subject: Subject) -> None:
    """From its settings alone it says which channels and results it needs."""
    needs = _needs(subject)
    demand(needs.channels or needs.results, "it requires neither a channel nor a result")
    for each in needs.channels:
        if each.or_coordinate:
            continue
        try:
            Member.parse(each.name)
        except ValueError as error:
            raise Nonconformity(str(error)) from error


@check(
    fix="give each result that `yields` names, in its unit, and u as its budget has it",
    needs=("says_what_it_yields", "says_what_it_requires"),
)
def gives_what_it_yields(subject: Subject) -> None:
    """Of a made-up run it gives each result that it names, in its unit, with its uncertainty."""
    found = _found(subject, _run(subject))
    given = {each.name for each in found.results}
    due = {each.name for each in _definitions(subject)}
    demand(given == due, f"it gave {sorted(given)}, and yields {sorted(due)}")


@check(fix="raise DataError with what is missing", needs=("gives_what_it_yields",))
def refuses_a_run_that_lacks_a_channel(subject: Subject) -> None:
    """Of a run without what it requires it raises DataError."""
    for each in _needed(subject):
        try:
            _made(subject)(_run(subject, without=each.name))
        except DataError:
            continue
        except Exception as error:
            what = f"{type(error).__name__} without {each.name}, needed is DataError"
            raise Nonconformity(f"it raises {what}") from error
        raise Nonconformity(f"it gives a result without {each.name}")


@check(fix="keep nothing between two calls, and change no array", needs=("gives_what_it_yields",))
def is_pure(subject: Subject) -> None:
    """Asked twice it gives the same, whatever it was asked between."""
    analysis, run = _made(subject), _run(subject)
    first = _numbers(analysis(run))
    analysis(_run(subject, seed=2))
    demand(_numbers(analysis(run)) == first, "it gives other numbers when it is asked again")


@check(fix="use the register: see `RunData.reading_errors`", needs=("is_pure",))
def a_worse_instrument_is_no_surer(subject: Subject) -> None:
    """With limits of error that are ten times as wide, no result has a smaller uncertainty."""
    good, bad = (_found(subject, _run(subject, widen=w)).results for w in (1.0, 10.0))
    for one, other in zip(good, bad, strict=True):
        surer = other.estimate.u < one.estimate.u * (1 - 1e-9)
        demand(not surer, f"'{one.name}': u falls from {one.estimate.u:g} to {other.estimate.u:g}")


def _record(subject: Subject) -> AnalysisRecord:
    return subject.record_as(AnalysisRecord)


def _told(subject: Subject) -> Any:
    return subject.registry.validated(subject.kind, subject.name, subject.settings)


def _definitions(subject: Subject) -> tuple[ResultDefinition, ...]:
    return tuple(_record(subject).yields(_told(subject)))


def _needs(subject: Subject) -> Requirements:
    return subject.registry.requires(subject.kind, subject.name, subject.settings)


def _needed(subject: Subject) -> tuple[NeededChannel, ...]:
    return _needs(subject).channels


def _made(subject: Subject) -> Any:
    """Return the analysis as a run has it: what it gives is looked at."""
    return Scrutiny(subject.registry).make(subject.kind, subject.name, subject.settings)


def _found(subject: Subject, run: RunData) -> Findings:
    try:
        found: Findings = _made(subject)(run)
    except (PluginError, DataError) as error:
        raise Nonconformity(error.message) from error
    return found


def _numbers(found: Findings) -> list[tuple[str, str, float, float]]:
    return [(e.name, e.place, e.estimate.value, e.estimate.u) for e in found.results]


def _run(subject: Subject, *, without: str = "", seed: int = 1, widen: float = 1.0) -> RunData:
    """Return a made-up run: rows of every channel at some places, and instruments for them."""
    rng, units = np.random.default_rng(seed), dict(_record(subject).trial_units)
    names = [each.name for each in _needed(subject)]
    missing = [name for name in names if name not in units]
    if missing:
        raise Nonconformity(
            f"nothing says in which unit {missing[0]} is",
            fix="give the record `trial_units`: the SI unit of each channel of its `trial`",
        )
    places = [name for each in _definitions(subject) for name in each.per]
    rows = tuple(
        Measurement(
            "made_up",
            START.format(second=ROWS * place + each),
            {name: float(place) for name in places},
            {name: 10.0 + place + rng.normal(0, 0.01) for name in names if name != without},
            units | dict.fromkeys(places, "1"),
        )
        for place in range(PLACES)
        for each in range(ROWS)
    )
    instruments = [
        Instrument.model_validate(
            {
                "channel": name,
                "measures": unit(units[name]).dimension,
                "serial": "made up",
                "range": {"max": f"100 {units[name]}"},
                "accuracy": f"{0.1 * widen:g} {'K' if units[name] == 'K' else '% FS'}",
            }
        )
        for name in names
        if unit(units[name]).dimension != "torque"
    ]
    return RunData(
        run_id="made up",
        procedure_id="MADE-UP",
        procedure_revision="A",
        procedure_title="Made up",
        station_id="made up",
        started_utc=START.format(second=0),
        ended_utc=START.format(second=59),
        outcome="completed",
        inputs={},
        rig=own_keys(RigDescription, tools().station.rig),
        instruments={each.channel: each for each in instruments},
        zeros={},
        recordings=(),
        measurements=rows,
    )


CHECKS: tuple[AnyCheck, ...] = (
    says_what_it_yields,
    says_what_it_requires,
    gives_what_it_yields,
    refuses_a_run_that_lacks_a_channel,
    is_pure,
    a_worse_instrument_is_no_surer,
)
