"""The analyses of torque for the checks of plans, with made-up methods."""

from __future__ import annotations

from types import SimpleNamespace

from helpers_language import PROCEDURE, STATION, TESTER, edited
from rigrunner.api import AnalysisContext, Requirements
from rigrunner.api.errors import PluginError
from rigrunner.plan import check_plan, make_plan, run_to_come
from rigrunner.procedure import check_result_limits, parse_procedure
from rigrunner.station import parse_station
from rigrunner_bearings.api.measurand import Condition, MeasurandKind, Nature
from rigrunner_bearings.torque.records import rigrunner_analyses

STARTING = MeasurandKind(Nature.LOAD_INDUCED, Condition.AT_REVERSAL)
ANALYSES = {analysis.name: analysis for analysis in rigrunner_analyses()}
METHODS = ("template", "energy")


class Methods:
    """Compensations that yield one kind of torque, and rules and fits that need nothing."""

    def __init__(self, kind):
        self.kind = kind

    def record(self, kind, name):
        if kind == "compensation" and name not in METHODS:
            raise PluginError(f"there is no compensation '{name}'")
        return SimpleNamespace(yields=self.kind, rejects=False)

    def requires(self, kind, name, _settings):
        self.record(kind, name)
        return Requirements()


class Lookup:
    """Queries the records as a registry does."""

    def __init__(self, kind=STARTING):
        self.context = AnalysisContext(plugins=Methods(kind))

    def definitions(self, name, settings):
        return ANALYSES[name].yields(_settings(name, settings), self.context)

    def plan_problems(self, name, settings, planned):
        return ANALYSES[name].plan_problems(_settings(name, settings), planned, self.context)

    def expects(self, name, settings, planned):
        return ANALYSES[name].expects(_settings(name, settings), planned, self.context)


def _settings(name, settings):
    return ANALYSES[name].settings_model.model_validate(settings)


def planned(text=PROCEDURE, *, station=STATION, lookup=None):
    """Plan a procedure on a station and check it; return procedure, station and both plans."""
    procedure, loaded = parse_procedure(text, "p.yaml"), parse_station(station, "s.yaml")
    plan = make_plan(procedure, loaded, {"tester": TESTER})
    to_come = run_to_come(procedure.model, loaded, plan, {"tester": TESTER})
    check_plan(procedure, loaded, to_come, lookup or Lookup())
    return procedure, loaded, plan, to_come


def check(*changes, kind=STARTING, with_plan=True):
    """Check the limits of the procedure, changed, with and without a plan."""
    text = edited(PROCEDURE, *changes)
    check_result_limits(parse_procedure(text, "p.yaml"), Lookup(kind))
    if with_plan:
        planned(text, lookup=Lookup(kind))
