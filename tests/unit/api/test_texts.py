"""Texts for people contain no invisible characters, wherever they are entered."""

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

DIRECTIONS = [*range(0x202A, 0x202F), *range(0x2066, 0x206A), 0x200E, 0x200F, 0x061C]
CONTROLS = [*range(0x09), 0x0B, 0x0C, *range(0x0E, 0x20), *range(0x7F, 0xA0), 0x2028, 0x2029]
HIDDEN = [chr(code) for code in (*DIRECTIONS, *CONTROLS)]
VISIBLE = ["ünit 轴承", "محمل", "מיסב", "क्\N{ZERO WIDTH JOINER}ष", "a\tb", "two\nlines", "±2 °C µm"]
RLO = "\N{RIGHT-TO-LEFT OVERRIDE}"
BEARING = '"Bearing'


@pytest.mark.parametrize("character", HIDDEN, ids=lambda c: f"U+{ord(c):04X}")
def test_invisible_character_is_refused_with_its_position(character):
    with pytest.raises(ValueError, match=rf"character 3 is U\+{ord(character):04X}"):
        plain(f"SN{character}17")
    with pytest.raises(AnswerError) as caught:
        Expected().accept(f"SN{character}17")
    assert f"character 3 is U+{ord(character):04X}" in caught.value.hint


@pytest.mark.parametrize("text", VISIBLE)
def test_text_of_any_script_is_accepted(text):
    assert plain(text) == text
    assert refused_character(text) is None
    assert Expected().accept(text) == text


@pytest.mark.parametrize("character", [*HIDDEN, "\r"], ids=lambda c: f"U+{ord(c):04X}")
def test_invisible_character_of_a_device_is_escaped(character):
    shown = visible(f"SN{character}17")
    assert shown.isprintable()
    assert shown.startswith("SN\\")
    assert shown.encode().decode("unicode_escape") == f"SN{character}17"  # no character is lost
    assert visible(shown) == shown


@pytest.mark.parametrize("text", VISIBLE)
def test_text_of_any_script_is_shown_unchanged(text):
    assert visible(text) == text


def test_error_text_escapes_invisible_characters():
    error = ValueError("answer 'OK\x1b[2J'")
    error.add_note(f"beside {RLO}it")
    assert error_text(error) == r"ValueError: answer 'OK\x1b[2J'; beside \u202eit"


def with_title(title):
    line = next(text for text in PROCEDURE.splitlines() if text.startswith("title: "))
    return PROCEDURE.replace(line, title)


def test_invisible_character_in_a_title_is_refused_with_its_location():
    document = with_title(f"title: Bearing {RLO}71-NS")
    problem = only_problem(parse_procedure, document, "p.yaml")
    assert str(problem.location) == f"p.yaml:{place_of(document, RLO)}"
    assert "U+202E (right-to-left override)" in problem.message
    for escape in ("\\u202e", "\\x07", "\\x9b"):
        escaped = with_title(f'title: "Bearing {escape}71-NS"')
        (problem, *_) = problems_of(parse_procedure, escaped, "p.yaml")
        assert str(problem.location) == f"p.yaml:{place_of(escaped, BEARING)}", escape
        assert f"U+{escape[2:].upper().zfill(4)}" in problem.message


def test_invisible_character_in_a_comment_is_refused():
    """Otherwise a reviewer would see another text than the file contains."""
    commented = f"# approved {RLO}\n{PROCEDURE}"
    assert str(only_problem(parse_procedure, commented, "p.yaml").location) == "p.yaml:1:12"


def test_escaped_invisible_character_in_a_key_is_refused():
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
def test_invisible_character_in_a_station_is_refused(written, field):
    key, _, value = written.partition(": ")
    text = edited(STATION, (written, f'{key}: "{value}\\x9b"'))
    problem = only_problem(parse_station, text, "s.yaml")
    assert problem.field == field
    assert "U+009B" in problem.message


def test_invisible_character_in_an_order_is_refused(tmp_path):
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
def test_panel_refuses_invisible_characters(body, content):
    with pytest.raises(ValidationError, match=r"U\+202E"):
        body.model_validate_json(json.dumps(content))


@pytest.mark.parametrize("option", ["--operator", "--set", "--reason"])
def test_commands_refuse_invisible_characters_in_options(option):
    result = call("run", "p.yaml", option, f"specimen=SN{RLO}17")
    assert result.code == 2
    assert "U+202E (right-to-left override)" in result.err
    assert RLO not in result.err
