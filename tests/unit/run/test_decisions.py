from __future__ import annotations

import json
import shutil
from datetime import UTC, datetime
from types import SimpleNamespace

import pytest

import helpers_tester
from rigrunner.api.errors import DataError, UsageError
from rigrunner.procedure import Acceptance
from rigrunner.registry import load_registry
from rigrunner.run.decisions import Decider, _refuse_other_results, decide_again, later_decisions
from rigrunner.runfile import read

WHO = Decider(by="A. Person", reason="a test", at=datetime(2026, 3, 2, tzinfo=UTC))
LIMIT = {
    "of": "torque",
    "mean": True,
    "max": "0.6 N·m",
    "source": "a drawing",
    "measurand": {"nature": "load_induced", "condition": "at_reversal"},
}


def other_rule(acceptance, name):
    return Acceptance.model_validate({**acceptance.as_written(), "rule": name})


TIGHT = Acceptance.model_validate({"limits": [LIMIT], "rule": "simple"})


@pytest.fixture(scope="module")
def passed(quick_copy):
    """Return the folder of a loaded run that passed, beside its no-load run."""
    return quick_copy.loaded


@pytest.fixture
def folder(passed, tmp_path):
    copy = tmp_path / passed.name
    shutil.copytree(passed, copy)
    return copy


def decide(folder, acceptance=TIGHT, who=WHO):
    return decide_again(folder, load_registry(), who, lambda *_: acceptance)


@pytest.fixture(scope="module")
def second_decision(passed, tmp_path_factory):
    """Decide once more on a copy of the run; return the decision file and the result."""
    copy = tmp_path_factory.mktemp("decided") / passed.name
    shutil.copytree(passed, copy)
    return decide(copy)


@pytest.fixture(scope="module")
def decided(second_decision):
    """Return the folder of the run with a second decision, to be copied."""
    decision, _ = second_decision
    return decision.path.parent


@pytest.fixture
def decided_copy(decided, tmp_path):
    return shutil.copytree(decided, tmp_path / decided.name)


def test_new_decision_changes_no_existing_file(passed, second_decision, decided):
    decision, result = second_decision
    assert result.decision.verdict == "fail"
    assert decision.path.name == "decision-2.json"
    before, after = (
        {path.name: path.read_bytes() for path in folder.iterdir()} for folder in (passed, decided)
    )
    assert {name: after[name] for name in before} == before
    assert set(after) - set(before) == {"decision-2.json"}


def test_decision_file_has_person_reason_time_run_and_previous_decision(decided):
    document = json.loads((decided / "decision-2.json").read_text(encoding="utf-8"))
    assert document["run"] == {"id": decided.name, "digest_sha256": read(decided).digest}
    assert (document["by"], document["reason"]) == ("A. Person", "a test")
    assert document["decided_utc"] == "2026-03-02T00:00:00.000Z"
    assert document["before"]["file"] == "run.h5"
    assert document["before"]["verdict"] == "pass"
    assert document["before"]["rule"].startswith("guard_band_u")
    assert document["before"]["acceptance"]["limits"][0]["max"] == "0.95 N·m"
    assert document["acceptance"]["limits"][0]["max"] == "0.6 N·m"
    assert document["decision"]["verdict"] == "fail"


def test_decision_uses_result_of_first_analysis(second_decision, passed):
    decision, _ = second_decision
    first = read(passed).result_document["headline"]["compensated"]
    assert decision.document["decision"]["result"] == first


def test_decisions_form_a_chain(decided_copy):
    acceptances = []
    decide_again(
        decided_copy,
        load_registry(),
        WHO,
        lambda before, _: acceptances.append(before) or other_rule(before, "non_binary"),
    )
    assert acceptances == [TIGHT]
    second, third = later_decisions(read(decided_copy), decided_copy)
    assert third.document["before"]["file"] == second.path.name == "decision-2.json"
    assert third.summary.rule_before.startswith("simple")


@pytest.mark.parametrize("name", ["by", "reason"])
def test_decision_needs_name_and_reason(folder, name):
    who = Decider(**{**vars(WHO), name: " "})
    with pytest.raises(UsageError, match="needs a name and a reason"):
        decide(folder, who=who)
    assert later_decisions(read(folder), folder) == ()


def test_unchanged_acceptance_is_refused(decided_copy):
    with pytest.raises(UsageError, match="already in force"):
        decide(decided_copy)


def test_limit_of_another_measurand_is_refused(folder):
    limit = LIMIT | {
        "source": "AS14101",
        "measurand": {"nature": "no_load", "condition": "from_rest"},
    }
    with pytest.raises(DataError, match="AS14101: the limit is for the no-load torque from rest"):
        decide(folder, Acceptance.model_validate({"limits": [limit]}))
    assert later_decisions(read(folder), folder) == ()


def test_limit_of_unknown_result_is_refused():
    entries = [SimpleNamespace(name=name, of=None) for name in ("torque", "drift")]
    result = SimpleNamespace(
        results=entries[:1], missing=entries[1:], means=(), run=SimpleNamespace(run_id="R-1")
    )
    wear = Acceptance.model_validate({"limits": [LIMIT | {"of": "wear"}]})
    with pytest.raises(DataError, match="R-1 has no result 'wear'") as caught:
        _refuse_other_results(result, wear, ["paper"])
    assert caught.value.hint == "results: torque, drift"


@pytest.mark.usefixtures("tester")
def test_measurand_is_refused_for_result_without_one(tmp_path):
    readings = helpers_tester.run(helpers_tester.procedure_file(tmp_path, "idle"), tmp_path).folder
    limit = {"of": "idle_torque", "where": {"tester.frequency": "8 Hz"}}
    acceptance = Acceptance.model_validate({"limits": [LIMIT | limit | {"mean": False}]})
    with pytest.raises(DataError, match="'idle_torque' does not say whether it is the "):
        decide(readings, acceptance)


def test_run_without_result_is_refused(passed):
    no_load = next(path for path in passed.parent.iterdir() if "NLI" in path.name)
    with pytest.raises(DataError, match="has no result to decide on"):
        decide(no_load)


def spoil(change):
    def spoiled(path):
        document = json.loads(path.read_text(encoding="utf-8"))
        change(document)
        path.write_text(json.dumps(document), encoding="utf-8")

    return spoiled


def test_measurand_of_other_plugin_version_is_kept_as_written(decided):
    stored = {"nature": "of_old", "since": 7}
    path = decided / "decision-2.json"
    before = path.read_text(encoding="utf-8")
    spoil(lambda document: document["acceptance"]["limits"][0].update(measurand=stored))(path)
    (decision,) = later_decisions(read(decided), decided)
    path.write_text(before, encoding="utf-8")
    assert decision.acceptance.limits[0].as_written()["measurand"] == stored


@pytest.mark.parametrize(
    ("spoiled", "message"),
    [
        (lambda path: path.write_text("{", encoding="utf-8"), "is not a decision"),
        (lambda path: path.write_text("[]", encoding="utf-8"), "is not a decision"),
        (lambda path: path.write_text("[" * 100_000, encoding="utf-8"), "is not a decision"),
        (spoil(lambda document: document.pop("by")), "is not a decision"),
        (spoil(lambda document: document.update(by=7)), "is not a decision"),
        (spoil(lambda document: document.update(format="decision/9")), "is not a decision"),
        (spoil(lambda document: document["acceptance"].pop("limits")), "is not a decision"),
        (spoil(lambda document: document["decision"].update(verdict="good")), "is not a decision"),
        (
            spoil(lambda document: document["run"].update(digest_sha256="0" * 64)),
            "decision on other recordings",
        ),
        (
            spoil(lambda document: document["before"].update(file="decision-9.json")),
            "does not follow run.h5",
        ),
        (lambda path: path.rename(path.with_name("decision-3.json")), "does not follow run.h5"),
    ],
)
def test_invalid_decision_file_is_reported(decided_copy, spoiled, message):
    spoiled(decided_copy / "decision-2.json")
    with pytest.raises(DataError, match=message):
        later_decisions(read(decided_copy), decided_copy)


def test_other_files_are_not_read_as_decisions(folder):
    for name in ("decision.json", "decision-02.json", "decision-2.json.tmp", "my-decision-2.json"):
        (folder / name).write_text("{", encoding="utf-8")
    assert later_decisions(read(folder), folder) == ()
