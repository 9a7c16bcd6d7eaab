"""Inputs: given on the command line, in a file, asked, or left to their unattended answers."""

from __future__ import annotations

import pytest

from helpers_language import PROCEDURE, edited, only_problem, problems_of
from rigrunner.api.errors import UsageError
from rigrunner.engine import UnattendedAnswers
from rigrunner.procedure import parse_procedure
from rigrunner.run.inputs import answer_inputs, read_answers

INPUTS = """\
  specimen: {ask: Serial number, unattended: S-1}
  room: {ask: Room, unit: °C, max: 30 °C, unattended: 23 °C}
  side: {ask: Side, choices: [left, right], unattended: left}
  operator: {ask: Name}
"""
LOADED = parse_procedure(edited(PROCEDURE, (INPUTS.splitlines(keepends=True)[0], INPUTS)), "p.yaml")


class Person(UnattendedAnswers):
    """Answers questions without an unattended answer, and records the steps that asked."""

    def __init__(self) -> None:
        self.steps: list[str] = []

    def ask(self, step, question):
        self.steps.append(step)
        return question.unattended or "Zoë"


def answered(inputs):
    person = Person()
    return answer_inputs(LOADED, inputs, person), person.steps


def test_missing_inputs_are_asked():
    values, questions = answered({"room": "24", "specimen": "SN-17"})

    assert values == {"specimen": "SN-17", "room": "24 °C", "side": "left", "operator": "Zoë"}
    assert questions == ["inputs.side", "inputs.operator"]


def test_missing_unattended_answer_is_refused():
    with pytest.raises(UsageError, match=r"inputs\.operator: there is nobody to answer 'Name'"):
        answer_inputs(LOADED, {}, UnattendedAnswers())


@pytest.mark.parametrize(
    ("inputs", "message", "hint"),
    [
        ({"oprator": "me"}, "TEST-1 has no input 'oprator'", "did you mean 'operator'?"),
        ({"zzz": "me"}, "TEST-1 has no input 'zzz'", "it asks for: specimen, room, side, operator"),
        ({"room": "31 °C"}, "the input 'room': 31 °C is out of range (30 °C or less)", ""),
        ({"side": "lft"}, "the input 'side': got 'lft', expected one of: left, right",
         "did you mean 'left'?"),
    ],
)  # fmt: skip
def test_given_inputs_are_checked_before_questions(inputs, message, hint):
    person = Person()
    with pytest.raises(UsageError) as caught:
        answer_inputs(LOADED, inputs, person)

    assert (caught.value.message, caught.value.hint) == (message, hint)
    assert person.steps == []


@pytest.fixture
def answers(tmp_path):
    def write(text):
        path = tmp_path / "answers.yaml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_answers_are_read_from_file(answers):
    path = answers("specimen: SN-17      # as engraved\nroom: 24.5 °C\nside: right\n")

    assert read_answers(path, LOADED) == {
        "specimen": "SN-17",
        "room": "24.5 °C",
        "side": "right",
    }


@pytest.mark.parametrize(
    ("text", "line", "message", "hint"),
    [
        ("oprator: me", "1:1: oprator", "there is no such input", "did you mean 'operator'?"),
        ("specimen: 17", "1:11: specimen", "got 17, expected a text", "put it in quotes: '17'"),
        ("specimen: 0017", "1:11: specimen", "0017 has a leading zero", "'0017' in quotes"),
        ("specimen: yes\nroom: 24", "2:7: room", "got 24, expected a text",
         "write it as '24 °C'"),
        ("specimen:", "1:10: specimen", "got nothing, expected a text", ""),
        ("specimen: [a]", "1:11: specimen", "expected a text", ""),
        ("room: 24,5 °C", "1:7: room", "'24,5 °C' has a decimal comma", "write '24.5 °C'"),
        ("side: up", "1:7: side", "got 'up', expected one of: left, right", ""),
        ("side: left\nside: right", "2:1", "the key 'side' is given twice", ""),
        ("[left]", "1:1", "expected a mapping of inputs to answers", "such as 'specimen: SN-17'"),
        ("", "", "the file is empty", ""),
        ("specimen: &a x\nside: *a", "1:11", "the anchor &a is not allowed", ""),
    ],
)  # fmt: skip
def test_invalid_file_of_answers_is_refused(answers, text, line, message, hint):
    path = answers(text)
    problem = problems_of(read_answers, path, LOADED)[0]

    assert message in problem.message
    assert hint in problem.hint
    assert str(problem).startswith(f"{path}:{line}")


def test_all_problems_of_answers_are_reported_together(answers):
    path = answers("specimen: 17\nroom: 5 N\nzzz: a\n")

    assert [problem.field for problem in problems_of(read_answers, path, LOADED)] == [
        "specimen",
        "room",
        "zzz",
    ]


def test_missing_file_of_answers_is_refused(tmp_path):
    assert "cannot be read" in only_problem(read_answers, tmp_path / "no.yaml", LOADED).message
