from __future__ import annotations

import json
import shutil
from datetime import UTC, datetime

import pytest

import helpers_tester
from rigrunner.api.errors import DataError, UsageError
from rigrunner.procedure import Acceptance
from rigrunner.registry import load_registry
from rigrunner.run.decisions import Decider, decide_again, later_decisions
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
    """Return the folder of a loaded run which its procedure passes, beside its no-load run."""
    return quick_copy.loaded


@pytest.fixture
def folder(passed, tmp_path):
    copy = tmp_path / passed.name
    shutil.copytree(passed, copy)
    return copy


def again(folder, acceptance=TIGHT, who=WHO):
    return decide_again(folder, load_registry(), who, lambda *_: acceptance)


@pytest.fixture(scope="module")
def second(passed, tmp_path_factory):
    """Decide once more on a copy of the run; return what was written, and the result."""
    copy = tmp_path_factory.mktemp("decided") / passed.name
    shutil.copytree(passed, copy)
    return again(copy)


@pytest.fixture(scope="module")
def decided(second):
    """Return the folder of the run with a second decision, to be copied."""
    written, _ = second
    return written.path.parent


@pytest.fixture
def decided_copy(decided, tmp_path):
    return shutil.copytree(decided, tmp_path / decided.name)


def test_it_is_decided_anew_without_touching_what_is_there(passed, second, decided):
    written, result = second
    assert result.decision.verdict == "fail"
    assert written.path.name == "decision-2.json"
    before, after = (
        {path.name: path.read_bytes() for path in folder.iterdir()} for folder in (passed, decided)
    )
    assert {name: after[name] for name in before} == before
    assert set(after) - set(before) == {"decision-2.json"}


def test_the_record_says_who_why_when_of_what_and_what_held_before(decided):
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


def test_the_numbers_are_those_of_the_first_analysis(second, passed):
    written, _ = second
    first = read(passed).result_document["headline"]["compensated"]
    assert written.document["decision"]["result"] == first


def test_each_decision_follows_the_one_before(decided_copy):
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
def test_without_name_or_reason_nothing_is_decided(folder, name):
    who = Decider(**{**vars(WHO), name: " "})
    with pytest.raises(UsageError, match="needs a name and a reason"):
        again(folder, who=who)
    assert later_decisions(read(folder), folder) == ()


def test_what_holds_already_is_no_decision(decided_copy):
    with pytest.raises(UsageError, match="already in force"):
        again(decided_copy)


def test_a_limit_of_another_torque_is_refused(folder):
    limit = LIMIT | {
        "source": "AS14101",
        "measurand": {"nature": "no_load", "condition": "from_rest"},
    }
    with pytest.raises(DataError, match="AS14101: the limit is for the no-load torque from rest"):
        again(folder, Acceptance.model_validate({"limits": [limit]}))
    assert later_decisions(read(folder), folder) == ()


@pytest.mark.usefixtures("tester")
def test_a_measurand_is_refused_for_a_result_that_states_none(tmp_path):
    readings = helpers_tester.run(helpers_tester.procedure_file(tmp_path, "idle"), tmp_path).folder
    limit = {"of": "idle_torque", "where": {"tester.frequency": "8 Hz"}}
    acceptance = Acceptance.model_validate({"limits": [LIMIT | limit | {"mean": False}]})
    with pytest.raises(DataError, match="'idle_torque' does not say whether it is the "):
        again(readings, acceptance)


def test_a_run_that_compensates_nothing_is_refused(passed):
    no_load = next(path for path in passed.parent.iterdir() if "NLI" in path.name)
    with pytest.raises(DataError, match="has no result to decide on"):
        again(no_load)


def spoil(change):
    def spoiled(path):
        document = json.loads(path.read_text(encoding="utf-8"))
        change(document)
        path.write_text(json.dumps(document), encoding="utf-8")

    return spoiled


def test_a_measurand_of_another_version_of_the_plugin_is_kept_as_it_is_written(decided):
    written = {"nature": "of_old", "since": 7}
    path = decided / "decision-2.json"
    before = path.read_text(encoding="utf-8")
    spoil(lambda document: document["acceptance"]["limits"][0].update(measurand=written))(path)
    (decision,) = later_decisions(read(decided), decided)
    path.write_text(before, encoding="utf-8")
    assert decision.acceptance.limits[0].as_written()["measurand"] == written


@pytest.mark.parametrize(
    ("spoiled", "words"),
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
def test_a_spoiled_record_is_told_not_passed_over(decided_copy, spoiled, words):
    spoiled(decided_copy / "decision-2.json")
    with pytest.raises(DataError, match=words):
        later_decisions(read(decided_copy), decided_copy)


def test_other_files_are_no_decisions(folder):
    for name in ("decision.json", "decision-02.json", "decision-2.json.tmp", "my-decision-2.json"):
        (folder / name).write_text("{", encoding="utf-8")
    assert later_decisions(read(folder), folder) == ()
