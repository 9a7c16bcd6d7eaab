"""Each case is examined once, also if the study was interrupted."""

from __future__ import annotations

import json
import threading
from dataclasses import dataclass
from math import inf, pi

import pytest

from rigrunner.api.errors import AbortedError, DataError, UsageError
from rigrunner.jobs import InProcess
from rigrunner_bearings.study import case_runner as module
from rigrunner_bearings.study.case import Case
from rigrunner_bearings.study.case_runner import CaseRunner
from rigrunner_bearings.study.coverage import Finding, Outcome

CASES = [Case("sim", "", 1, number) for number in range(5)]
EXACT = Outcome((0.1 + 0.2, -inf), (pi, 1e-300), (1 / 3, 2.0), 0.1, 0.2)


def finding_of(case):
    return Finding(case, "law", case.number / 3, {"method": EXACT}, {})


@dataclass
class Study:
    """Records the examined cases and stops after `stop_after` of them."""

    journal_path: object
    stop_after: int = 99

    def __post_init__(self):
        self.examined, self.progress, self.stop = [], [], threading.Event()

    def __call__(self, case):
        self.examined.append(case.number)
        if len(self.examined) == self.stop_after:
            self.stop.set()
        return finding_of(case)

    def run(self, cases=CASES):
        runner = CaseRunner(
            InProcess(), self.stop, lambda *counts: self.progress.append(counts), self.journal_path
        )
        return runner.findings("name", self, Finding, cases)


def test_interrupted_study_resumes_and_examines_each_case_once(tmp_path):
    first = Study(tmp_path / "part", stop_after=2)
    with pytest.raises(AbortedError, match="stopped after 2 of 5 rigs") as stopped:
        first.run()
    assert str(first.journal_path) in stopped.value.hint
    second = Study(tmp_path / "part")
    assert second.run() == [finding_of(case) for case in CASES]
    assert (first.examined, second.examined) == ([0, 1], [2, 3, 4])
    assert second.progress == [(2, 5), (3, 5), (4, 5), (5, 5)]


def test_larger_study_reuses_findings(tmp_path):
    Study(tmp_path / "part").run(CASES[:3])
    larger = Study(tmp_path / "part")
    assert larger.run(CASES[::-1]) == [finding_of(case) for case in CASES[::-1]]
    assert larger.examined == [4, 3]


def test_findings_of_another_program_are_refused(tmp_path, monkeypatch):
    Study(tmp_path / "part").run()
    monkeypatch.setattr(module, "code_digest", lambda: "another")
    with pytest.raises(UsageError, match="has results of other work: code was"):
        Study(tmp_path / "part").run()


def test_worker_with_other_software_is_refused(monkeypatch):
    monkeypatch.setattr(module, "software", lambda _: {"Rigrunner": "0.0.1"})
    with pytest.raises(DataError, match=r"a worker of the cluster has Rigrunner .*, not 0\.0\.1"):
        Study(None).run()


def test_without_journal_nothing_is_kept():
    study = Study(None, stop_after=1)
    with pytest.raises(AbortedError) as stopped:
        study.run()
    assert not stopped.value.hint


def refuses(_):
    raise DataError("not this one")


def breaks(_):
    raise KeyError("bug")


@pytest.mark.parametrize(("examine", "error"), [(refuses, DataError), (breaks, RuntimeError)])
def test_failing_case_ends_the_study(examine, error, tmp_path):
    runner = CaseRunner(InProcess(), threading.Event(), lambda *_: None, tmp_path / "part")
    with pytest.raises(error, match=r"not this one|in breaks"):
        runner.findings("name", examine, Finding, CASES)


def test_journal_is_lines_of_json(tmp_path):
    Study(tmp_path / "part").run(CASES[:1])
    header, line = map(json.loads, (tmp_path / "part").read_text().splitlines())
    assert header["of"]["study"] == "name"
    assert json.loads(line[0])["number"] == 0
