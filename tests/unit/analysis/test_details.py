"""The details that any analysis may add to its results, and their use in documents."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf

import pytest

from rigrunner.analysis.analyse import analyse
from rigrunner.analysis.document import document
from rigrunner.analysis.verdict.document import verdict_in
from rigrunner.api import (
    AnalysisDetails,
    AnalysisRecord,
    Check,
    Findings,
    MeasurementResult,
    ResultDefinition,
    Verdict,
)
from rigrunner.api.certificate import CertifiedDetails, Deviation
from rigrunner.api.data import Estimate, Measurement
from rigrunner.api.errors import DataError
from rigrunner.api.limits import ValueLimit
from rigrunner.api.results import Result
from rigrunner.certificate.results import certified_of
from rigrunner.certificate.validity import not_calibrated
from rigrunner.procedure import Acceptance, AnalysisRef, Measurand
from rigrunner.registry import Plugin, Provider, Registry, load_registry
from unit.analysis.helpers_runs import run_of

REQUIRED_KEYS = {"headline", "points", "no_load_points", "compensations", "fits", "validation"}
"""The keys of each `result.json` of version 0.1.0."""


class Friction(AnalysisDetails):
    """The details of another analysis."""


@dataclass(frozen=True)
class Wear(AnalysisDetails):
    """The details of a third-party analysis."""

    depth_um: float = 12.5

    @property
    def shown_results(self):
        return frozenset({"wear"})

    def document(self):
        return {"wear_track": {"value": self.depth_um, "unit": "µm"}}

    def certified(self, run):
        assert run.partners == {}
        text = "profile measured in air"
        return CertifiedDetails(
            channels=frozenset({"stylus.height"}),
            deviations=(Deviation(kind="remark", run_id=run.run_id, text=text),),
        )


def result(*details):
    return Result(run=run_of(), measurand="", symbol="", details=details)


def limited(*details):
    """Return a result with a measured value that has a limit, so that it can be certified."""
    row = Measurement(
        name="readings",
        utc="2026-03-02T09:15:00Z",
        setpoints={},
        values={"oven.temperature": 300.0},
        units={"oven.temperature": "K"},
        limits=(ValueLimit("oven.temperature", 290.0, 310.0, "K"),),
    )
    analysed = result(*details)
    return replace(analysed, run=replace(analysed.run, measurements=(row,)))


def test_third_party_details_are_found_by_class_and_documented():
    analysed = result(Wear(), Friction())
    assert analysed.details_of(Wear).depth_um == 12.5
    assert analysed.details_of(Friction) is analysed.details[1]
    content = document(result(Wear()))
    assert content["wear_track"] == {"value": 12.5, "unit": "µm"}
    assert content.keys() >= REQUIRED_KEYS


@pytest.mark.parametrize(("recording", "stated"), [("002_20Hz", "002_20Hz"), ("", None)])
def test_document_names_the_recording_of_a_limited_value(recording, stated):
    analysed = limited()
    row = replace(analysed.run.measurements[0], recording=recording)
    analysed = replace(analysed, run=replace(analysed.run, measurements=(row,)))
    (value,) = document(analysed)["limits"]["values"]
    assert value["recording"] == stated


@pytest.mark.parametrize(
    ("stored", "verdict"),
    [
        ({"verdict": {"verdict": "fail"}, "decision": {"verdict": "pass"}}, "fail"),
        ({"verdict": None, "decision": None}, ""),
        ({"decision": {"verdict": "pass"}}, "pass"),  # without limits on measured values
        ({"decision": None}, ""),
        (None, ""),
    ],
)
def test_verdict_of_a_stored_result(stored, verdict):
    assert verdict_in(stored) == verdict


def test_document_without_torque_keeps_all_keys():
    analysed = analyse(run_of(), (), acceptance=None, measurand=None, lookup=load_registry())
    assert analysed.details == ()
    content = document(analysed)
    assert content["headline"] == {
        "method": None,
        "compensated": None,
        "budget": [],
        "raw_peak": None,
    }
    assert content["points"] == content["no_load_points"] == content["fits"] == []
    assert (content["compensations"], content["validation"]) == ({}, None)


@pytest.mark.parametrize(
    ("symbol", "quantity", "unit"),
    [
        ("Ω", "", "Ω"),
        ("mN·m", "", "N·m"),  # as in documents of 0.1.0
        (None, "", ""),
        (None, "force", "N"),
        ("kN", "force", "N"),
        (None, "torque", "N·m"),
    ],
)
def test_document_has_the_unit_of_the_measurand(symbol, quantity, unit):
    record = AnalysisRecord(
        name="given",
        help="Made up.",
        factory=lambda _: lambda run: Findings(),  # noqa: ARG005  (it finds nothing)
        yields=lambda _: (),
        measurand=quantity,
    )
    analysed = analyse(
        run_of(),
        [AnalysisRef.model_validate({"given": None})],
        acceptance=None,
        measurand=Measurand(symbol="x", name="quantity", unit=symbol),
        lookup=Registry([Plugin("analysis", record, Provider("lab", "1"))]),
    )
    assert document(analysed)["measurand"] == {"symbol": "x", "name": "quantity", "unit": unit}
    plain = analyse(run_of(), (), acceptance=None, measurand=None, lookup=load_registry())
    assert document(plain)["measurand"]["unit"] == ""


def test_certificate_includes_the_deviations_of_each_analysis():
    with pytest.raises(DataError, match="its procedure names no primary method"):
        certified_of(result(Wear()))
    (deviation,) = not_calibrated(limited(Wear()))
    assert deviation.text == "profile measured in air"


def test_third_party_findings_reach_result_and_document():
    depth = ResultDefinition(name="wear", unit="mm")

    def measure(run):
        assert run.run_id == "run-1"
        value = MeasurementResult(of=depth, estimate=Estimate(0.5, 0.1, inf, "mm"))
        failed = Check("stylus", ok=False, text="blunt", decisive=True)
        return Findings(results=(value,), checks=(failed,), details=(Wear(7.0),))

    record = AnalysisRecord(
        name="track", help="Wear.", factory=lambda _: measure, yields=lambda _: (depth,)
    )
    limit = {"of": "wear", "max": "1 mm", "source": "a test"}
    analysed = analyse(
        run_of(),
        [AnalysisRef.model_validate({"track": None})],
        acceptance=Acceptance.model_validate({"limits": [limit], "rule": "simple"}),
        measurand=None,
        lookup=Registry(
            [
                *(plugin for plugin in load_registry().plugins if plugin.kind == "decision_rule"),
                Plugin("analysis", record, Provider("lab", "1")),
            ]
        ),
    )
    assert analysed.details_of(Wear).depth_um == 7.0
    assert document(analysed)["wear_track"]["value"] == 7.0
    assert analysed.other_results == ()  # wear is shown by its own page
    assert analysed.decision.verdict is Verdict.INCONCLUSIVE
    assert "The check 'stylus' failed: blunt" in analysed.decision.reason
    assert analysed.decision.deciding.uncompensated is None  # nothing was corrected
