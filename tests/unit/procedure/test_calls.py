"""Procedures that call others, and pictures: looked up only beside the caller."""

from __future__ import annotations

import time

import pytest

from helpers_language import only_problem, place_of, problems_of
from rigrunner.procedure import load_procedure
from rigrunner.procedure.calls import MAX_CALLS

HEAD = """\
rigrunner: procedure/2
id: {id}
revision: "A"
title: A test
measurand: {{symbol: T, name: torque}}
uses: {{tester: swing_tester}}
"""
INNER = (
    HEAD.format(id="INNER")
    + """\
inputs:
  room: {ask: Room temperature, unit: °C, unattended: 23 °C}
  specimen: {ask: Inner question, unattended: I-1}
parameters: {load: 10 N, values: [1 Hz], words: Ready?}
setup:
  - confirm: {text: $words, unattended: yes}
main:
  - set: {tester.load: $load}
  - sweep: {set: tester.frequency, over: $values, steps: [settle: {cycles: 1}]}
teardown:
  - set: {tester.load: 0 N}
"""
)
CALL = "  - call: {procedure: inner.yaml, with: {load: 20 N}}\n"
OUTER = (
    HEAD.format(id="OUTER")
    + f"""\
inputs:
  specimen: {{ask: Serial number, unattended: S-1}}
parameters: {{pull: 30 N}}
main:
  - wait: {{time: 1 s}}
{CALL}"""
)


@pytest.fixture
def files(tmp_path):
    def write(outer=OUTER, inner=INNER, **others):
        (tmp_path / "outer.yaml").write_text(outer, encoding="utf-8")
        (tmp_path / "inner.yaml").write_text(inner, encoding="utf-8")
        for name, text in others.items():
            (tmp_path / f"{name}.yaml").write_text(text, encoding="utf-8")
        return tmp_path / "outer.yaml"

    return write


def outer_with_call(what):
    return OUTER.replace(CALL, f"  - call: {what}\n")


def test_called_procedure_gets_the_given_values(files):
    called = load_procedure(files()).called[("main", 1)]

    assert called.model.id == "INNER"
    assert str(called.model.main[0].settings.drives["tester.load"]) == "20 N"
    assert str(called.model.main[1].settings.over[0]) == "1 Hz"


def test_lists_and_references_are_passed_to_a_call(files):
    outer = outer_with_call("{procedure: inner.yaml, with: {load: $pull, values: [2 Hz, 3 Hz]}}")
    called = load_procedure(files(outer)).called[("main", 1)]

    assert str(called.model.main[0].settings.drives["tester.load"]) == "30 N"
    assert [str(value) for value in called.model.main[1].settings.over] == ["2 Hz", "3 Hz"]


def test_inputs_are_merged_and_the_callers_question_wins(files):
    inputs = load_procedure(files()).inputs

    assert set(inputs) == {"specimen", "room"}
    assert inputs["specimen"].ask == "Serial number"


def test_calls_within_sweeps_repetitions_and_folders_below(files, tmp_path):
    (tmp_path / "below").mkdir()
    (tmp_path / "below" / "deep.yaml").write_text(INNER, encoding="utf-8")
    middle = HEAD.format(id="MIDDLE") + "main: [call: {procedure: below/deep.yaml}]\n"
    outer = outer_with_call(
        "{procedure: middle.yaml}\n"
        "  - repeat: {times: 2, steps: [call: {procedure: inner.yaml}]}\n"
        "  - sweep: {set: tester.load, over: [1 N], steps: [call: {procedure: inner.yaml}]}"
    )
    loaded = load_procedure(files(outer, middle=middle))

    assert [called.model.id for called in loaded.all_called()] == [
        "MIDDLE",
        "INNER",
        "INNER",
        "INNER",
    ]


@pytest.mark.parametrize(
    ("call", "finger", "field", "message", "hint"),
    [
        ("{procedure: iner.yaml}", "iner.yaml", "procedure", "there is no file 'iner.yaml'",
         "did you mean 'inner.yaml'?"),
        ("{procedure: ../inner.yaml}", "../inner", "procedure",
         "'../inner.yaml' is outside this file's folder",
         "name a file beside this one, or in a folder below"),
        ("{procedure: /etc/passwd}", "/etc", "procedure", "is outside this file's folder", ""),
        ("{procedure: 'C:\\x.yaml'}", "'C:", "procedure", "is outside this file's folder", ""),
        ("{procedure: '..\\inner.yaml'}", "'..", "procedure", "is outside this file's folder",
         ""),
        ("{procedure: outside.yaml}", "outside", "procedure", "is outside this file's folder",
         ""),
        ("{procedure: .}", ".}", "procedure", "there is no file '.'", ""),
        ("{procedure: outer.yaml}", "outer.yaml", "procedure",
         "a procedure cannot call itself: outer.yaml calls outer.yaml", ""),
        ("{procedure: inner.yaml, with: {laod: 5 N}}", "laod", "with.laod",
         "has no parameter 'laod'", "did you mean 'load'?"),
        ("{procedure: inner.yaml, with: {x: 5 N}}", "x: 5", "with.x",
         "has no parameter 'x'", "parameters: load, values, words"),
        ("{procedure: press.yaml}", "press.yaml", "procedure",
         "it uses a press in the role 'press', which this procedure does not",
         "add it here: 'uses: {press: press}'"),
        ("{procedure: tester.yaml}", "tester.yaml", "procedure",
         "it uses a press in the role 'tester', which this procedure does not",
         "add it here: 'uses: {tester: press}'"),
    ],
)  # fmt: skip
def test_invalid_call_is_refused(files, tmp_path, call, finger, field, message, hint):  # noqa: PLR0917  (a table)
    outer = outer_with_call(call)
    press = INNER.replace("uses: {tester: swing_tester}", "uses: {press: press}")
    press = press.replace("tester.", "press.")
    secret = tmp_path.parent / f"{tmp_path.name}-outside.yaml"
    secret.write_text(INNER, encoding="utf-8")
    (tmp_path / "outside.yaml").symlink_to(secret)
    tester = INNER.replace("tester: swing_tester", "tester: press")
    path = files(outer, press=press, tester=tester)
    problem = only_problem(load_procedure, path)

    assert message in problem.message
    assert hint in problem.hint
    assert problem.field == f"main[1].call.{field}"
    within = outer[outer.index("call:") :]
    assert str(problem.location) == f"{path}:{place_of(outer, within[within.index(finger) :])}"


def test_impossible_file_name_is_refused(files):
    name = "x" * 5000
    problem = only_problem(load_procedure, files(outer_with_call(f"{{procedure: {name}}}")))

    assert "cannot be looked up" in problem.message
    assert len(str(problem)) < 400


def test_circular_calls_are_refused_with_their_path(files):
    third = HEAD.format(id="THIRD") + "main: [call: {procedure: outer.yaml}]\n"
    path = files(outer_with_call("{procedure: third.yaml}"), third=third)
    problem = only_problem(load_procedure, path)

    assert problem.message == (
        "a procedure cannot call itself: outer.yaml calls third.yaml calls outer.yaml"
    )
    assert problem.location.file.endswith("third.yaml")


def test_multiplying_calls_are_refused_quickly(files):
    many = "main:\n" + "  - call: {procedure: NEXT}\n" * 15
    levels = {
        f"l{n}": HEAD.format(id=f"L{n}") + many.replace("NEXT", f"l{n + 1}.yaml") for n in range(6)
    }
    levels["l6"] = INNER
    path = files(outer_with_call("{procedure: l0.yaml}"), **levels)
    start_s = time.process_time()
    problems = problems_of(load_procedure, path)

    assert time.process_time() - start_s < 10
    assert problems[0].message.startswith(f"more than {MAX_CALLS} calls")


def test_frequent_calls_of_a_long_file_are_refused_quickly(files):
    long = INNER + "description: " + "x" * 300_000 + "\n"
    calls = "\n  - call: {procedure: inner.yaml}" * 100
    path = files(outer_with_call("{procedure: inner.yaml}") + calls, long)
    start_s = time.process_time()
    problems = problems_of(load_procedure, path)

    assert time.process_time() - start_s < 10
    assert "1,000,000 characters" in problems[0].message


def test_wrong_value_is_reported_where_used_and_where_given(files):
    outer = outer_with_call("{procedure: inner.yaml, with: {load: 20}}")
    path = files(outer)
    problem = only_problem(load_procedure, path)

    inner = path.parent / "inner.yaml"
    assert str(problem.location) == f"{inner}:{place_of(INNER, '$load')}"
    assert problem.field == "main[0].set.tester.load"
    assert f"it is written at {path}:{place_of(outer, '20}')}" in problem.hint


def test_problems_of_all_files_are_reported_together_and_once(files):
    inner = INNER.replace("cycles: 1", "cycles: x")
    outer = outer_with_call(
        "{procedure: inner.yaml}\n  - call: {procedure: inner.yaml}\n  - call: {procedure: no.yaml}"
    )
    problems = problems_of(load_procedure, files(outer, inner))

    assert [problem.message for problem in problems] == [
        "got 'x', expected a whole number",
        "there is no file 'no.yaml'",
    ]


@pytest.mark.parametrize("step", ["confirm: {text: Ready", "ask: {text: Side, into: side"])
def test_picture_is_found_beside_the_procedure(files, tmp_path, step):
    outer = OUTER + f"  - {step}, picture: side.png}}\n"
    (tmp_path / "side.png").write_bytes(b"\x89PNG")

    assert load_procedure(files(outer)).model.main[2]


@pytest.mark.parametrize(
    ("picture", "message", "hint"),
    [
        ("side.jpg", "there is no file 'side.jpg'", "did you mean 'side.png'?"),
        ("../side.png", "'../side.png' is outside this file's folder", "beside this one"),
        ("outer.yaml", "'outer.yaml' is not a picture", "allowed: .png, .jpg"),
    ],
)
def test_invalid_picture_is_refused(files, tmp_path, picture, message, hint):
    (tmp_path / "side.png").write_bytes(b"\x89PNG")
    outer = OUTER + f"  - confirm: {{text: Ready, picture: {picture}}}\n"
    path = files(outer)
    problem = only_problem(load_procedure, path)

    assert (problem.message, problem.field) == (message, "main[2].confirm.picture")
    assert hint in problem.hint
    assert str(problem.location) == f"{path}:{place_of(outer, picture)}"
