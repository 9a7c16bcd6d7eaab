"""What a person writes for another holds no character that cannot be seen, wherever it is typed."""

from __future__ import annotations

import json

import pytest
from pydantic import ValidationError

from helpers_cli import call
from helpers_language import PROCEDURE, STATION, edited, only_problem, place_of, problems_of
from rigrunner.api.cleanup import error_text
from rigrunner.api.texts import plain, refused_character, visible
from rigrunner.certificate.order import read_order
from rigrunner.procedure import parse_procedure
from rigrunner.procedure.answers import AnswerError, Expected
from rigrunner.station import parse_station
from rigrunner_panel.web.requests import BecauseOf, CheckInput, StartRun, TakeControl

TURNING = [*range(0x202A, 0x202F), *range(0x2066, 0x206A), 0x200E, 0x200F, 0x061C]
CONTROLS = [*range(0x09), 0x0B, 0x0C, *range(0x0E, 0x20), *range(0x7F, 0xA0), 0x2028, 0x2029]
HIDDEN = [chr(code) for code in (*TURNING, *CONTROLS)]
SEEN = ["ünit 轴承", "محمل", "מיסב", "क्\N{ZERO WIDTH JOINER}ष", "a\tb", "two\nlines", "±2 °C µm"]
RLO = "\N{RIGHT-TO-LEFT OVERRIDE}"
BEARING = '"Bearing'


@pytest.mark.parametrize("character", HIDDEN, ids=lambda c: f"U+{ord(c):04X}")
def test_what_cannot_be_seen_is_refused_with_its_place(character):
    with pytest.raises(ValueError, match=rf"character 3 is U\+{ord(character):04X}"):
        plain(f"SN{character}17")
    with pytest.raises(AnswerError) as caught:
        Expected().accept(f"SN{character}17")
    assert f"character 3 is U+{ord(character):04X}" in caught.value.hint


@pytest.mark.parametrize("text", SEEN)
def test_what_any_script_needs_is_taken(text):
    assert plain(text) == text
    assert refused_character(text) is None
    assert Expected().accept(text) == text


@pytest.mark.parametrize("character", [*HIDDEN, "\r"], ids=lambda c: f"U+{ord(c):04X}")
def test_what_cannot_be_seen_in_a_text_of_a_device_is_made_visible(character):
    shown = visible(f"SN{character}17")
    assert shown.isprintable()
    assert shown.startswith("SN\\")
    assert shown.encode().decode("unicode_escape") == f"SN{character}17"  # nothing of it is lost
    assert visible(shown) == shown


@pytest.mark.parametrize("text", SEEN)
def test_what_any_script_needs_is_shown_as_it_is(text):
    assert visible(text) == text


def test_the_text_of_an_error_hides_nothing():
    error = ValueError("answer 'OK\x1b[2J'")
    error.add_note(f"beside {RLO}it")
    assert error_text(error) == r"ValueError: answer 'OK\x1b[2J'; beside \u202eit"


def titled(title):
    line = next(text for text in PROCEDURE.splitlines() if text.startswith("title: "))
    return PROCEDURE.replace(line, title)


def test_a_title_is_refused_with_line_and_column_as_it_stands_and_as_an_escape():
    document = titled(f"title: Bearing {RLO}71-NS")
    problem = only_problem(parse_procedure, document, "p.yaml")
    assert str(problem.location) == f"p.yaml:{place_of(document, RLO)}"
    assert "U+202E (right-to-left override)" in problem.message
    for escape in ("\\u202e", "\\x07", "\\x9b"):
        escaped = titled(f'title: "Bearing {escape}71-NS"')
        (problem, *_) = problems_of(parse_procedure, escaped, "p.yaml")
        assert str(problem.location) == f"p.yaml:{place_of(escaped, BEARING)}", escape
        assert f"U+{escape[2:].upper().zfill(4)}" in problem.message


def test_a_comment_is_refused_too():
    """What a reviewer reads there would not be what stands there."""
    commented = f"# approved {RLO}\n{PROCEDURE}"
    assert str(only_problem(parse_procedure, commented, "p.yaml").location) == "p.yaml:1:12"


def test_a_key_is_refused_as_an_escape():
    keyed = edited(PROCEDURE, ("uses:", '"us\\u200ees":'))
    (problem, *_) = problems_of(parse_procedure, keyed, "p.yaml")
    assert "U+200E (left-to-right mark)" in problem.message


@pytest.mark.parametrize(
    ("written", "field"),
    [
        ("serial: T-1", "instruments[0].serial"),
        ("title: A bench", "title"),
    ],
)
def test_a_station_is_refused(written, field):
    key, _, value = written.partition(": ")
    text = edited(STATION, (written, f'{key}: "{value}\\x9b"'))
    problem = only_problem(parse_station, text, "s.yaml")
    assert problem.field == field
    assert "U+009B" in problem.message


def test_an_order_is_refused(tmp_path):
    order = tmp_path / "order.yaml"
    order.write_text('rigrunner: order/1\ncustomer: "Acme\\u202e"\n', encoding="utf-8")
    problem = only_problem(read_order, order)
    assert problem.location.line == 2
    order.write_text('rigrunner: order/1\ncustomer: "Acme\\x07"\n', encoding="utf-8")
    problem = only_problem(read_order, order)
    assert problem.field == "customer"
    assert "character 5 is U+0007" in problem.message


@pytest.mark.parametrize(
    ("body", "content"),
    [
        (TakeControl, {"name": f"Ann{RLO}"}),
        (BecauseOf, {"reason": f"no {RLO}"}),
        (CheckInput, {"procedure": "p", "input": "specimen", "text": f"SN{RLO}"}),
        (StartRun, {"procedure": "p", "station": "s", "operator": f"Ann{RLO}"}),
        (StartRun, {"procedure": "p", "station": "s", "inputs": {"specimen": f"SN{RLO}"}}),
    ],
)
def test_the_panel_refuses_it(body, content):
    with pytest.raises(ValidationError, match=r"U\+202E"):
        body.model_validate_json(json.dumps(content))


@pytest.mark.parametrize("option", ["--operator", "--set", "--reason"])
def test_a_command_refuses_it_in_any_word(option):
    called = call("run", "p.yaml", option, f"specimen=SN{RLO}17")
    assert called.code == 2
    assert "U+202E (right-to-left override)" in called.err
    assert RLO not in called.err
