"""Pydantic's errors in plain words, at the right location."""

from __future__ import annotations

from typing import Annotated, Literal

import pytest
from pydantic import Field

from helpers_language import only_problem, problems_of
from rigrunner.api.settings import Force, Frequency, ListOf, Ratio, Settings, YesNo
from rigrunner.yamlfile import Document, parse, validate


class Inner(Settings):
    speed: Frequency
    mode: Literal["slow", "fast"] = "slow"


class Other(Settings):
    force: Force


class Model(Settings):
    name: str
    count: Annotated[int, Field(ge=1, le=9)] = 1
    ratio: float = 1.0
    quiet: YesNo = False
    flag: bool = False
    inner: Inner | None = None
    inners: ListOf[Inner] = ()
    by_name: dict[str, Inner] = Field(default_factory=dict)
    either: Inner | Other | None = None
    some: Annotated[ListOf[Inner], Field(min_length=1)] = (Inner(speed="1 Hz"),)
    words: Annotated[ListOf[str], Field(max_length=2)] = ()


class Marked(Settings):
    rigrunner: Literal["procedure/2"]
    name: str


@pytest.mark.parametrize(
    ("mark", "messages"),
    [
        ("station/1", ["got 'station/1', expected 'procedure/2'"]),
        (
            "procedure/3",
            [
                "got 'procedure/3', expected 'procedure/2'",
                "the key 'name' is missing",
                "unknown key 'devices'",
            ],
        ),
    ],
)
def test_wrong_kind_of_file_is_the_only_problem_reported(mark, messages):
    document = parse(f"rigrunner: {mark}\ndevices: {{}}\n", "f.yaml")
    problems = problems_of(lambda: validate(Marked, document))
    assert sorted(problem.message for problem in problems) == messages


def test_file_without_a_kind_has_that_problem_only():
    problem = only_problem(validate, Marked, parse("format: result/4\nvalue: 1\n", "f.yaml"))
    assert str(problem) == (
        "f.yaml:1:1: rigrunner: the key 'rigrunner' is missing"
        " (it states the type of the file, such as 'rigrunner: procedure/2')"
    )


def document(text: str) -> Document:
    return parse(f"name: x\n{text}\n", "f.yaml")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("count: no", "2:8: count: got 'no', expected a whole number"),
        ("count: 1.5", "2:8: count: got 1.5, expected a whole number"),
        ("count: true", "2:8: count: got true, expected a whole number"),
        ("count:", "2:7: count: got nothing, expected a whole number"),
        ("count: 0", "2:8: count: got 0, expected 1 or more"),
        ("count: 10", "2:8: count: got 10, expected 9 or less"),
        ("count: [1]", "2:8: count: got a list of 1, expected a whole number"),
        ("count: {a: 1}", "2:8: count: got a mapping of a, expected a whole number"),
        ("ratio: fast", "2:8: ratio: got 'fast', expected a number"),
        ("quiet: off", "2:8: quiet: got 'off', expected yes or no"),
        ("quiet: 1", "2:8: quiet: got '1', expected yes or no"),
        ("flag: yes", "2:7: flag: got 'yes', expected true or false"),
        ("inner: fast", "2:8: inner: got 'fast', expected a mapping of names to values"),
        ("inners: {a: 1}", "2:9: inners: got a mapping of a, expected a list"),
        ("inners: [{}]", "2:10: inners[0].speed: the key 'speed' is missing"),
        ("inner: {mode: slow}", "2:1: inner.speed: the key 'speed' is missing"),
        ("words: [a, b, c]", "2:8: words: got a list of 3, expected 2 or fewer"),
        ("words: [a, 2]", "2:12: words[1]: got 2, expected a text (put it in quotes: '2')"),
        ("inner: {speed: 5}",
         "2:16: inner.speed: 5 is not a number with a unit (write it as '5 Hz')"),
        ("inner: {speed: [5]}",
         "2:16: inner.speed: got a list, expected a number with a unit (such as '10 Hz')"),
        ("inner: {speed: 5 N}",
         "2:16: inner.speed: '5 N' is a force, not a frequency (units of frequency: Hz, kHz, rpm)"),
        ("inner: {speed: 5 hz}",
         "2:16: inner.speed: unknown unit 'hz' (did you mean 'Hz'?)"),
        ("inner: {speed: 5 Hz, mode: fats}",
         "2:28: inner.mode: got 'fats', expected 'slow' or 'fast' (did you mean 'fast'?)"),
        ("inner: {sped: 5 Hz, speed: 5 Hz}",
         "2:9: inner.sped: unknown key 'sped' (did you mean 'speed'? known keys: speed, mode)"),
        ("mode: slow", "2:1: mode: unknown key 'mode' (it is a key of 'inner')"),
        ("inner: {mode: fast, speed: 5 Hz, valve open?}",
         "2:34: inner.valve open?: unknown key 'valve open?' (put a text with a comma in quotes)"),
        ("by_name: {a: {speed: 5 Hz, zzz: 1}}",
         "2:28: by_name.a.zzz: unknown key 'zzz' (known keys: speed, mode)"),
    ],
)  # fmt: skip
def test_each_error_names_location_field_value_and_expectation(text, expected):
    assert str(only_problem(validate, Model, document(text))) == f"f.yaml:{expected}"


def test_missing_key_is_located_at_the_parent_key():
    problem = only_problem(validate, Model, parse("count: 2\n", "f.yaml"))

    assert str(problem) == "f.yaml:1:1: name: the key 'name' is missing"


def test_wrong_item_does_not_make_its_list_too_short():
    (problem,) = problems_of(validate, Model, document("some: [{speed: 5}]"))

    assert problem.field == "some[0].speed"


def test_field_does_not_show_the_member_of_a_union():
    problems = problems_of(validate, Model, document("either: {speed: 5 N, force: 5 N}"))

    assert {problem.field for problem in problems} <= {"either.speed", "either.force"}
    hints = {p.hint for p in problems if p.message == "unknown key 'speed'"}
    assert hints == {"known keys: force"}


def test_problems_are_reported_at_once_up_to_a_limit():
    text = "inners:\n" + "  - {speed: 5}\n" * 200
    problems = problems_of(validate, Model, document(text))

    assert len(problems) == 51
    assert problems[-1].message == "150 more problems follow; fix these first"


@pytest.mark.parametrize("text", ["inner: {speed: 5 Hz}", "quiet: yes", "quiet: true"])
def test_valid_texts_pass(text):
    validate(Model, document(text))


def test_yes_and_no_are_booleans_only_in_yes_no_fields():
    assert validate(Model, document("quiet: yes")).quiet is True
    assert validate(Model, document("quiet: no")).quiet is False
    assert validate(Model, document("words: [yes, no]")).words == ("yes", "no")


def test_part_of_a_document_keeps_its_locations():
    tree = parse("a:\n  b: {speed: 5}\n  c:\n", "f.yaml")

    problem = only_problem(validate, Inner, tree, ("a", "b"))
    assert str(problem.location) == "f.yaml:2:14"
    assert problem.field == "a.b.speed"
    empty = only_problem(validate, Inner, tree, ("a", "c"))
    assert str(empty.location) == "f.yaml:3:3"
    missing = only_problem(validate, Inner, tree, ("a", "d", "e"))
    assert str(missing.location) == "f.yaml:1:1"
    assert missing.field == "a.d.e.speed"


def test_long_values_are_shortened_in_messages():
    problem = only_problem(validate, Model, document(f"count: {'x' * 10_000}"))

    assert len(str(problem)) < 200


class Either(Settings):
    value: str | float | bool


def test_value_of_no_type_of_a_union_is_one_problem():
    (problem,) = problems_of(lambda: validate(Either, parse("value: {a: 1}\n", "f.yaml")))
    assert problem.message == "got a mapping of a, expected a text or a number or true or false"


class Share(Settings):
    gain: Ratio


@pytest.mark.parametrize(
    ("value", "hint"),
    [("0.3", "'0.3 %' or '0.3 1'"), ("3 °F", "units of ratio: 1, %"), ("3 Hz", "1, %")],
)
def test_unit_of_another_quantity_is_never_suggested(value, hint):
    (problem,) = problems_of(lambda: validate(Share, parse(f"gain: {value}\n", "f.yaml")))
    assert hint in problem.hint
    assert "did you mean" not in problem.hint
