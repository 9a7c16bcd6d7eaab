"""Checks on analyses with named results."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import replace
from importlib import import_module
from itertools import chain
from math import isclose, isnan
from typing import TYPE_CHECKING, Any

import numpy as np

from rigrunner.analysis.scrutiny import Scrutiny
from rigrunner.api.data import Block, Measurement, Recording, RunData
from rigrunner.api.errors import DataError, PluginError
from rigrunner.api.hooks import AnalysisRecord
from rigrunner.api.instruments import Instrument
from rigrunner.api.member import NAME, Member
from rigrunner.api.units import QuantityError, unit
from rigrunner.signal.coverage import expanded
from rigrunner_testing.check import (
    AnyCheck,
    Nonconformity,
    NotApplicable,
    applies,
    check,
    demand,
)

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from rigrunner.api.analysis import Requirements
    from rigrunner.api.findings import Findings, ResultDefinition
    from rigrunner_testing.subjects import Subject

PLACES, ROWS = 3, 4
"""The numbers of places of a generated run, and of rows at each."""
START = "2026-01-05T10:00:{second:02d}+00:00"
LATER = "2026-01-06"
FULL_SCALE = 100.0
"""Full scale of each generated instrument, in the SI unit; its error limit is 0.1 % of it."""
RATE_HZ, SAMPLES = 100.0, 40
"""Of a generated recording."""
NOISE = 0.01
"""Standard deviation of a generated reading, in the SI unit."""
TRIALS, MOST_MISSED = 40, 8
"""The numbers of runs, and of those in which U may miss the truth: see `covers_the_truth`."""
_OF_A_LIMIT = ("objection", "as_written", "document")
"""The methods of a LimitedMeasurand."""
MOST_TRIED = 3
"""Results of a run whose coverage is counted: each takes a while."""


@check(fix="give `yields` one ResultDefinition for each result, with a name and a unit")
def says_what_it_yields(subject: Subject) -> None:
    """Its settings alone tell which results it names, each with a unit."""
    definitions = _definitions(subject)
    demand(definitions, "it yields no result")
    for definition in definitions:
        name = definition.name
        demand(re.fullmatch(NAME, name), f"'{name}' is not a name for a result")
        try:
            unit(definition.unit)
        except QuantityError as error:
            raise Nonconformity(f"the result '{name}': {error.message}") from error
    counts = Counter(definition.name for definition in definitions)
    twice = [name for name, count in counts.items() if count > 1]
    demand(not twice, f"it yields {', '.join(twice)} twice")


@check(
    fix="name a model in `limit_measurand`: Settings with the methods of a LimitedMeasurand",
    needs=("says_what_it_yields",),
)
def limits_can_say_which_result(subject: Subject) -> None:
    """Where its results say which quantity they are, limits can say so by a key `measurand`."""
    if not any(definition.measurand for definition in _definitions(subject)):
        raise NotApplicable("its results have no measurand")
    model = _record(subject).limit_measurand_model
    if model is None:
        raise Nonconformity("its results have a measurand, but limits cannot state one")
    missing = [name for name in _OF_A_LIMIT if not callable(getattr(model, name, None))]
    demand(not missing, f"the model of the key `measurand` has no {' and no '.join(missing)}")


@check(fix="let `requires` give Requirements: a NeededChannel for each channel, as 'role.name'")
def says_what_it_requires(subject: Subject) -> None:
    """Its settings alone tell which channels and results it needs."""
    needs = _needs(subject)
    if _record(subject).trial_run:
        raise NotApplicable("it finds its channels by their units")
    demand(needs.channels or needs.results, "it requires neither a channel nor a result")
    for channel in needs.channels:
        if channel.or_coordinate:
            continue
        try:
            Member.parse(channel.name)
        except ValueError as error:
            raise Nonconformity(str(error)) from error


@check(
    fix="give each result that `yields` names, in its unit, and u as its budget has it",
    needs=("says_what_it_yields", "says_what_it_requires"),
)
def gives_what_it_yields(subject: Subject) -> None:
    """From a generated run it gives each declared result, in its unit, with its uncertainty."""
    findings = _findings(subject, _run(subject))
    names = {result.name for result in findings.results}
    declared = {definition.name for definition in _definitions(subject)}
    demand(names == declared, f"it gave {sorted(names)}, and yields {sorted(declared)}")


@check(fix="raise DataError with what is missing", needs=("gives_what_it_yields",))
def refuses_a_run_that_lacks_a_channel(subject: Subject) -> None:
    """A run without a required channel is refused with a DataError."""
    if not _needs(subject).channels:
        raise NotApplicable("it requires no channel by its name")
    for channel in _needs(subject).channels:
        try:
            _analysis(subject)(_run(subject, without=channel.name))
        except DataError:
            continue
        except Exception as error:
            what = f"{type(error).__name__} without {channel.name}, expected DataError"
            raise Nonconformity(f"it raises {what}") from error
        raise Nonconformity(f"it gives a result without {channel.name}")


@check(fix="raise DataError with what is missing", needs=("gives_what_it_yields",))
def refuses_a_partner_run_that_lacks_a_channel(subject: Subject) -> None:
    """A partner run without a required channel is refused with a DataError."""
    if not any(partner.channels for partner in _needs(subject).partners):
        raise NotApplicable("it requires no channel of a partner run")
    for partner in _needs(subject).partners:
        for channel in partner.channels:
            run = _run(subject, without=channel.name, of=partner.name)
            try:
                _analysis(subject)(run)
            except DataError:
                continue
            except Exception as error:
                what = f"{type(error).__name__} without {channel.name} in the {partner.words}"
                raise Nonconformity(f"it raises {what}, expected DataError") from error
            raise Nonconformity(f"it gives a result without {channel.name} in the {partner.words}")


@check(fix="keep no state between two calls, and change no array", needs=("gives_what_it_yields",))
def is_pure(subject: Subject) -> None:
    """Called twice it gives the same, also after a call with other data."""
    analysis, run = _analysis(subject), _run(subject)
    first = _numbers(analysis(run))
    analysis(_run(subject, seed=2))
    demand(_numbers(analysis(run)) == first, "it returns different numbers when it is called again")


@check(fix="use the register: see `RunData.reading_errors`", needs=("is_pure",))
def a_worse_instrument_is_no_surer(subject: Subject) -> None:
    """With error limits ten times as wide, no result has a smaller uncertainty."""
    good, bad = (_findings(subject, _run(subject, widen=factor)).results for factor in (1.0, 10.0))
    for result, other in zip(good, bad, strict=True):
        u, other_u = result.estimate.u, other.estimate.u
        smaller = other_u < u * (1 - 1e-9)
        demand(not smaller, f"'{result.name}': u falls from {u:g} to {other_u:g}")


@check(fix="sort by time or by place, not by the order in which it is given", needs=("is_pure",))
def the_order_of_recordings_means_nothing(subject: Subject) -> None:
    """The order of the recordings, or rows, does not change the results."""
    for run in _runs(subject):
        recordings, rows = run.recordings[::-1], run.measurements[::-1]
        reversed_run = replace(run, recordings=recordings, measurements=rows)
        _check_same(_findings(subject, run), _findings(subject, reversed_run), "in another order")


@check(fix="use differences of times alone", needs=("is_pure",))
def a_shift_of_time_means_nothing(subject: Subject) -> None:
    """The same rows or recordings a day later give the same results."""
    run = _run(subject)
    rows = tuple(replace(row, utc=_a_day_later(row.utc)) for row in run.measurements)
    recordings = tuple(
        replace(recording, started_utc=_a_day_later(recording.started_utc))
        for recording in run.recordings
    )
    shifted = replace(run, measurements=rows, recordings=recordings)
    _check_same(_findings(subject, run), _findings(subject, shifted), "a day later")


@check(
    fix="let the budget have the scatter (type A) and what the register states (type B)",
    needs=("gives_what_it_yields", "is_pure"),
)
def covers_the_truth(subject: Subject) -> None:
    """Over runs with noise and errors within the register's limits, U covers the true value.

    The true value is its result for the same run without noise and errors. 95 % should be covered;
    fewer than 32 of 40 runs happen once in 10 000 (binomial).
    """
    ideal = _findings(subject, _run(subject, ideal=True))
    truth = {(result.name, result.place): result.estimate for result in ideal.results}
    missed: Counter[str] = Counter()
    for seed in range(TRIALS):
        for result in _findings(subject, _run(subject, seed=seed, off=True)).results[:MOST_TRIED]:
            reach = expanded(result.estimate)
            if isnan(reach):  # its uncertainty is not known, and so covers nothing
                continue
            error = abs(result.estimate.value - truth[result.name, result.place].value)
            missed[f"{result.name} {result.place}"] += error > reach
    applies(missed, "it states no uncertainty")
    for name, count in missed.items():
        demand(count <= MOST_MISSED, f"U of {name} misses the truth in {count} of {TRIALS} runs")


@check(fix="let `live` show the same statistic as the analysis", needs=("gives_what_it_yields",))
def live_shows_what_it_finds(subject: Subject) -> None:
    """Its live result of whole recordings is its final result, for any size of blocks."""
    record = _record(subject)
    if record.live is None:
        raise NotApplicable("it shows nothing live")
    run = _run(subject, recorded=True)
    results = _findings(subject, run).results
    stored = {(result.name, result.place): result.estimate.value for result in results}
    for samples in (1, 7, SAMPLES):
        fold = record.live(subject.registry.validated(subject.kind, subject.name, subject.settings))
        for recording in run.recordings:
            empty = dict.fromkeys(recording.channels, np.empty(0))
            fold.begin(replace(recording, channels=empty), replace(run, recordings=()))
            for first in range(0, SAMPLES, samples):
                cut = {name: values[first : first + samples] for name, values in
                       recording.arrays().items()}  # fmt: skip
                fold.take(Block(recording.rate_hz, first, first / recording.rate_hz, cut))
        for result in fold.findings().results:
            name, value = result.name, result.estimate.value
            final = stored.get((name, result.place))
            if final is None:
                raise Nonconformity(f"it shows '{name}' at {result.place}, and finds none there")
            is_close = isclose(value, final, rel_tol=1e-6)
            demand(is_close, f"'{name}': live {value:g}, found {final:g}")


def _a_day_later(utc: str) -> str:
    return utc.replace(START[:10], LATER)


def _check_same(findings: Findings, changed: Findings, when: str) -> None:
    estimates = {(result.name, result.place): result.estimate for result in changed.results}
    for result in findings.results:
        estimate = estimates.get((result.name, result.place))
        if estimate is None:
            raise Nonconformity(f"'{result.name}' at {result.place} is missing {when}")
        for what in ("value", "u"):
            first, second = getattr(result.estimate, what), getattr(estimate, what)
            is_same = isclose(first, second, rel_tol=1e-6) or (isnan(first) and isnan(second))
            demand(is_same, f"'{result.name}': {what} is {first:g}, and {second:g} {when}")


def _record(subject: Subject) -> AnalysisRecord:
    return subject.record_as(AnalysisRecord)


def _definitions(subject: Subject) -> tuple[ResultDefinition, ...]:
    return subject.registry.definitions(subject.name, subject.settings)


def _needs(subject: Subject) -> Requirements:
    return subject.registry.requires(subject.kind, subject.name, subject.settings)


def _analysis(subject: Subject) -> Any:
    """Return the analysis as a run uses it, with checks of its output."""
    return Scrutiny(subject.registry).make(subject.kind, subject.name, subject.settings)


def _findings(subject: Subject, run: RunData) -> Findings:
    if _needs(subject).results:
        raise NotApplicable(
            "it needs results of other analyses, but the kit generates only channels"
        )
    try:
        findings: Findings = _analysis(subject)(run)
    except (PluginError, DataError) as error:
        raise Nonconformity(error.message) from error
    return findings


def _numbers(findings: Findings) -> list[tuple[str, str, float, float]]:
    return [(r.name, r.place, r.estimate.value, r.estimate.u) for r in findings.results]


def _in_recordings(run: RunData, rate_hz: float, rng: np.random.Generator, noise: float) -> RunData:
    """Return a run with a recording at each place in place of its rows."""
    recordings = tuple(
        Recording(
            name=f"{place:03d}",
            rate_hz=rate_hz,
            started_utc=row.utc,
            setpoints=row.setpoints,
            channels={
                name: value + rng.normal(0, noise, SAMPLES) for name, value in row.values.items()
            },
            units=row.units,
        )
        for place, row in enumerate(run.measurements[::ROWS])
    )
    return replace(run, measurements=(), recordings=recordings)


def _runs(subject: Subject) -> Iterator[RunData]:
    """Yield a generated run, and one with recordings if the analysis accepts them."""
    yield _run(subject)
    if _record(subject).trial_run:
        return
    recorded = _run(subject, recorded=True)
    try:
        _findings(subject, recorded)
    except Nonconformity:
        return
    yield recorded


def _run(
    subject: Subject,
    *,
    without: str = "",
    of: str = "",
    seed: int = 1,
    widen: float = 1.0,
    ideal: bool = False,
    off: bool = False,
    recorded: bool = False,
) -> RunData:
    """Return a generated run: rows of every channel at some places, and instruments for them.

    Its partner runs have half its values, at the same places, and the same instruments. `without`
    leaves out a channel, of this run or `of` a partner run. `ideal`: without noise; `off`: each
    instrument has an error within its limits, the same in all rows. `recorded`: recordings in place
    of rows, for an analysis that needs cycles or a rate.
    """
    if trial_run := _record(subject).trial_run:
        if without or widen != 1.0 or ideal or off or recorded:
            raise NotApplicable("it is checked on a run of its own, not on generated values")
        module, _, name = trial_run.partition(":")
        record_run: RunData = getattr(import_module(module), name)(seed)
        return record_run
    needs = _needs(subject)
    rng, units = np.random.default_rng(seed), dict(_record(subject).trial_units)
    partner_channels = {
        partner.name: [channel.name for channel in partner.channels] for partner in needs.partners
    }
    channels = [channel.name for channel in needs.channels]
    names = list(dict.fromkeys(chain(channels, *partner_channels.values())))
    missing = [name for name in names if name not in units]
    if missing:
        raise Nonconformity(
            f"nothing says in which unit {missing[0]} is",
            fix="give the record `trial_units`: the SI unit of each channel of its `trial`",
        )
    limits = {name: 0.1 if units[name] == "K" else 0.001 * FULL_SCALE for name in names}
    errors = {name: rng.uniform(-limits[name], limits[name]) if off else 0.0 for name in names}
    places = [name for definition in _definitions(subject) for name in definition.per]

    def rows(channels: Iterable[str], share: float, left_out: str) -> tuple[Measurement, ...]:
        return tuple(
            Measurement(
                "made_up",
                START.format(second=ROWS * place + number),
                {name: float(place) for name in places},
                {
                    name: share * (10.0 + place)
                    + errors[name]
                    + (0.0 if ideal else rng.normal(0, NOISE))
                    for name in channels
                    if name != left_out
                },
                units | dict.fromkeys(places, "1"),
            )
            for place in range(PLACES)
            for number in range(ROWS)
        )

    instruments = [
        Instrument.model_validate(
            {
                "channel": name,
                "measures": unit(units[name]).dimension,
                "serial": "made up",
                "range": {"max": f"{FULL_SCALE:g} {units[name]}"},
                "accuracy": f"{0.1 * widen:g} {'K' if units[name] == 'K' else '% FS'}",
            }
        )
        for name in names
        if unit(units[name]).dimension != "torque"
    ]
    run = RunData(
        run_id="made up",
        procedure_id="MADE-UP",
        procedure_revision="A",
        procedure_title="Made up",
        station_id="made up",
        started_utc=START.format(second=0),
        ended_utc=START.format(second=59),
        outcome="completed",
        inputs={},
        instruments={instrument.channel: instrument for instrument in instruments},
        zeros={},
        recordings=(),
        measurements=rows(channels, 1.0, "" if of else without),
    )
    partners = {
        name: replace(
            run,
            run_id=f"made up, {name}",
            measurements=rows(channels, 0.5, without if of == name else ""),
        )
        for name, channels in partner_channels.items()
    }
    if recorded or needs.rate_hz or needs.cycles:
        rate_hz, noise = max(RATE_HZ, needs.rate_hz), 0.0 if ideal else NOISE
        run = _in_recordings(run, rate_hz, rng, noise)
        partners = {
            name: _in_recordings(partner, rate_hz, rng, noise) for name, partner in partners.items()
        }
    return replace(run, partners=partners)


CHECKS: tuple[AnyCheck, ...] = (
    says_what_it_yields,
    limits_can_say_which_result,
    says_what_it_requires,
    gives_what_it_yields,
    refuses_a_run_that_lacks_a_channel,
    refuses_a_partner_run_that_lacks_a_channel,
    is_pure,
    a_worse_instrument_is_no_surer,
    the_order_of_recordings_means_nothing,
    a_shift_of_time_means_nothing,
    covers_the_truth,
    live_shows_what_it_finds,
)
