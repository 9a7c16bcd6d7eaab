"""An analysis that keeps to everything, and one broken in one way for each check of the kit."""

from __future__ import annotations

from dataclasses import replace
from math import nan

from helpers_measurand import Hardness
from rigrunner.api.analysis import NeededChannel, NeededRun, Requirements
from rigrunner.api.findings import Findings, ResultDefinition
from rigrunner.api.hooks import AnalysisRecord, NoSettings
from rigrunner.registry import load_registry
from unit.rigrunner_testing.helpers_zoo import registry_of

TOLD = {
    "of": "meter.voltage",
    "per": ["load.current"],
    "result": {"name": "voltage", "unit": "V"},
}
READINGS = load_registry().make("analysis", "readings", TOLD)
VOLTAGE = ResultDefinition(name="voltage", unit="V", per=("load.current",))
METER = NeededChannel(name="meter.voltage", key=("of",), enters=("voltage",))
DARK = NeededRun(name="dark", key=("dark",), procedure="DARK", channels=(METER,))


def changed(**parts):
    """Return an analysis of which each result has other parts."""
    return lambda run: Findings(
        results=tuple(replace(result, **parts) for result in READINGS(run).results)
    )


def forgiving(run):
    return READINGS(run) if run.measurements[0].values else Findings()


def surer_when_worse(run):
    """Give the uncertainty of an instrument that is the better the worse the register has it."""
    (meter,) = run.instruments.values()
    u = 1 / meter.limit_of_error(1.0)
    return Findings(
        results=tuple(
            replace(result, estimate=replace(result.estimate, u=u), components=())
            for result in READINGS(run).results
        )
    )


class Moody:
    """Remembers how often it was asked."""

    calls = 0

    def __call__(self, run):
        self.calls += 1
        results = READINGS(run).results
        moved = [
            replace(e, estimate=replace(e.estimate, value=e.estimate.value + self.calls))
            for e in results
        ]
        return Findings(results=tuple(moved))


def analysis_registry(analysis=READINGS, **parts):
    """Return a registry of one analysis, its record with other parts."""
    record = AnalysisRecord(
        **{
            "name": "broken",
            "help": "An analysis.",
            "settings": NoSettings,
            "factory": lambda _: analysis,
            "yields": lambda _: (VOLTAGE,),
            "requires": lambda _: Requirements(channels=(METER,)),
            "trial_units": {"meter.voltage": "V"},
            **parts,
        }
    )
    return registry_of("analysis", record)


def first_comes_first(run):
    """Add what was recorded first to each value."""
    first = float(next(iter(run.recordings[0].channels.values()))[0]) if run.recordings else 0.0
    return moved(READINGS(run), first)


def older_is_more(run):
    """Add the day of the first row to each value."""
    day = float(run.measurements[0].utc[8:10]) if run.measurements else 0.0
    return moved(READINGS(run), day)


def moved(findings, by):
    return Findings(
        results=tuple(
            replace(result, estimate=replace(result.estimate, value=result.estimate.value + by))
            for result in findings.results
        )
    )


def of_unknown_uncertainty(run):
    return Findings(
        results=tuple(
            replace(result, estimate=replace(result.estimate, u=nan), components=())
            for result in READINGS(run).results
        )
    )


def boastful(run):
    """Give a tenth of the uncertainty."""
    return Findings(
        results=tuple(
            replace(
                result, estimate=replace(result.estimate, u=result.estimate.u / 10), components=()
            )
            for result in READINGS(run).results
        )
    )


class Forgetful:
    """Shows the last block alone."""

    def __init__(self, _):
        self.live = load_registry().live("readings", TOLD)
        self.begun = None

    def begin(self, recording):
        self.begun = recording

    def take(self, block):
        self.live = load_registry().live("readings", TOLD)
        self.live.begin(self.begun)
        self.live.take(block)

    def findings(self):
        return self.live.findings()


ANALYSES = {
    "says_what_it_yields": lambda: analysis_registry(
        yields=lambda _: (replace(VOLTAGE, unit="furlong"),)
    ),
    "limits_can_say_which_result": lambda: analysis_registry(
        yields=lambda _: (replace(VOLTAGE, measurand=Hardness("HRC")),), limit_measurand=NoSettings
    ),
    "says_what_it_requires": lambda: analysis_registry(requires=lambda _: Requirements()),
    "gives_what_it_yields": lambda: analysis_registry(changed(of=replace(VOLTAGE, unit="mV"))),
    "refuses_a_run_that_lacks_a_channel": lambda: analysis_registry(forgiving),
    "refuses_a_partner_run_that_lacks_a_channel": lambda: analysis_registry(
        requires=lambda _: Requirements(channels=(METER,), partners=(DARK,))
    ),
    "is_pure": lambda: analysis_registry(Moody()),
    "a_worse_instrument_is_no_surer": lambda: analysis_registry(surer_when_worse),
    "the_order_of_recordings_means_nothing": lambda: analysis_registry(first_comes_first),
    "a_shift_of_time_means_nothing": lambda: analysis_registry(older_is_more),
    "covers_the_truth": lambda: analysis_registry(boastful),
    "live_shows_what_it_finds": lambda: analysis_registry(live=Forgetful),
    "can_be_made": lambda: analysis_registry(READINGS, factory=lambda _: None),
}
"""By check, the analysis that fails it."""
