"""A conforming analysis, and for each check of the kit an analysis that fails it."""

from __future__ import annotations

from dataclasses import replace
from math import nan

from helpers_measurand import Hardness
from rigrunner.api.analysis import NeededChannel, NeededRun, Requirements
from rigrunner.api.findings import Findings, ResultDefinition
from rigrunner.api.hooks import AnalysisRecord, NoSettings
from rigrunner.registry import load_registry
from unit.rigrunner_testing.helpers_zoo import registry_of

SETTINGS = {
    "of": "meter.voltage",
    "per": ["load.current"],
    "result": {"name": "voltage", "unit": "V"},
}
READINGS = load_registry().make("analysis", "readings", SETTINGS)
VOLTAGE = ResultDefinition(name="voltage", unit="V", per=("load.current",))
METER = NeededChannel(name="meter.voltage", key=("of",), enters=("voltage",))
DARK = NeededRun(name="dark", key=("dark",), procedure="DARK", channels=(METER,))


def changed(**fields):
    """Return an analysis with fields of each result replaced."""
    return lambda run: Findings(
        results=tuple(replace(result, **fields) for result in READINGS(run).results)
    )


def accepts_a_missing_channel(run):
    return READINGS(run) if run.measurements[0].values else Findings()


def more_certain_when_worse(run):
    """State a smaller uncertainty for a worse instrument."""
    (meter,) = run.instruments.values()
    u = 1 / meter.limit_of_error(1.0)
    return Findings(
        results=tuple(
            replace(result, estimate=replace(result.estimate, u=u), components=())
            for result in READINGS(run).results
        )
    )


class CountsItsCalls:
    """Adds the number of its calls to each value."""

    calls = 0

    def __call__(self, run):
        self.calls += 1
        results = READINGS(run).results
        shifted = [
            replace(e, estimate=replace(e.estimate, value=e.estimate.value + self.calls))
            for e in results
        ]
        return Findings(results=tuple(shifted))


def analysis_registry(analysis=READINGS, **fields):
    """Return a registry with one analysis, with fields of its record replaced."""
    record = AnalysisRecord(
        **{
            "name": "broken",
            "help": "An analysis.",
            "settings": NoSettings,
            "factory": lambda _: analysis,
            "yields": lambda _: (VOLTAGE,),
            "requires": lambda _: Requirements(channels=(METER,)),
            "trial_units": {"meter.voltage": "V"},
            **fields,
        }
    )
    return registry_of("analysis", record)


def adds_the_first_sample(run):
    """Add the first recorded sample to each value."""
    first = float(next(iter(run.recordings[0].channels.values()))[0]) if run.recordings else 0.0
    return shifted(READINGS(run), first)


def adds_the_day(run):
    """Add the day of the first row to each value."""
    day = float(run.measurements[0].utc[8:10]) if run.measurements else 0.0
    return shifted(READINGS(run), day)


def shifted(findings, by):
    return Findings(
        results=tuple(
            replace(result, estimate=replace(result.estimate, value=result.estimate.value + by))
            for result in findings.results
        )
    )


def without_uncertainty(run):
    return Findings(
        results=tuple(
            replace(result, estimate=replace(result.estimate, u=nan), components=())
            for result in READINGS(run).results
        )
    )


def understates_uncertainty(run):
    """State a tenth of the uncertainty."""
    return Findings(
        results=tuple(
            replace(
                result, estimate=replace(result.estimate, u=result.estimate.u / 10), components=()
            )
            for result in READINGS(run).results
        )
    )


class ForgetsEarlierBlocks:
    """Shows only the last block."""

    def __init__(self, _):
        self.live = load_registry().live("readings", SETTINGS)
        self.recording = None

    def begin(self, recording):
        self.recording = recording

    def take(self, block):
        self.live = load_registry().live("readings", SETTINGS)
        self.live.begin(self.recording)
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
    "refuses_a_run_that_lacks_a_channel": lambda: analysis_registry(accepts_a_missing_channel),
    "refuses_a_partner_run_that_lacks_a_channel": lambda: analysis_registry(
        requires=lambda _: Requirements(channels=(METER,), partners=(DARK,))
    ),
    "is_pure": lambda: analysis_registry(CountsItsCalls()),
    "a_worse_instrument_is_no_surer": lambda: analysis_registry(more_certain_when_worse),
    "the_order_of_recordings_means_nothing": lambda: analysis_registry(adds_the_first_sample),
    "a_shift_of_time_means_nothing": lambda: analysis_registry(adds_the_day),
    "covers_the_truth": lambda: analysis_registry(understates_uncertainty),
    "live_shows_what_it_finds": lambda: analysis_registry(live=ForgetsEarlierBlocks),
    "can_be_made": lambda: analysis_registry(READINGS, factory=lambda _: None),
}
"""By check, the analysis that fails it."""
