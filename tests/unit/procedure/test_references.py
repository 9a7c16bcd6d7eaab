"""`$name`: plain replacement with both places kept."""

from __future__ import annotations

import pytest

from helpers_language import PROCEDURE, edited, only_problem, place_of
from rigrunner.procedure import parse_procedure


def problem(*changes):
    text = edited(PROCEDURE, *changes)
    return text, only_problem(parse_procedure, text, "p.yaml")


@pytest.mark.parametrize(
    ("change", "part", "message", "hint"),
    [
        (("$load", "$laod"), "$laod", "there is no parameter 'laod'", "did you mean '$load'?"),
        (
            ("$load", "$zzz"),
            "$zzz",
            "there is no parameter 'zzz'",
            "parameters: $load, $frequencies",
        ),
        (
            (
                "main:\n",
                "main:\n  - repeat: {times: 2, as: nth, steps: [{set: {tester.load: $nth}}]}\n",
            ),
            "$nth",
            "'nth' counts a repeat",
            "write a sweep",
        ),
        (("$load", "$load*2"), "$load*2", "'$load*2' is not a reference", "no expressions"),
        (("$load", "$"), "$}", "'$' is not a reference", "no expressions"),
        (("$load", "$load + 5 N"), "$load +", "is not a reference", "no expressions"),
        (("  load: 1000 N", "  load: $frequencies"), "$frequencies", "cannot refer to another", ""),
    ],
)
def test_a_reference_that_leads_nowhere(change, part, message, hint):
    text, error = problem(change)

    assert str(error.location) == f"p.yaml:{place_of(text, part)}"
    assert message in error.message
    assert hint in error.hint


def test_what_is_wrong_with_a_parameter_is_told_where_it_is_used_and_where_it_stands():
    text, error = problem(("  load: 1000 N", "  load: 1000"))

    assert str(error.location) == f"p.yaml:{place_of(text, '$load')}"
    assert error.field == "main[0].set.tester.load"
    assert f"it is written at p.yaml:{place_of(text, '1000')}" in error.hint


def test_an_item_of_a_list_is_found_in_the_list():
    text, error = problem(("[2 Hz, 10 Hz]", "[2 Hz, 10]"))

    assert error.field == "main[1].sweep.over[1]"
    assert f"it is written at p.yaml:{place_of(text, '10]')}" in error.hint


def test_a_reference_may_stand_for_any_value():
    text = edited(
        PROCEDURE,
        ("  load: 1000 N", "  load: 1000 N\n  n: 5\n  chans: [tester.angle]\n  who: Guards shut"),
        ("settle: {cycles: 5}", "settle: {cycles: $n}"),
        ("[tester.angle, tester.torque]", "$chans"),
        ("Guards closed", "$who"),
    )
    model = parse_procedure(text, "p.yaml").model

    assert model.setup[0].settings.text == "Guards shut"
    settle, record = model.main[1].settings.steps
    assert settle.settings.cycles == 5
    assert record.settings.channels == ("tester.angle",)


def test_a_dollar_within_a_text_is_a_dollar():
    text = edited(PROCEDURE, ("Guards closed", "Pay 5 $load"))

    assert parse_procedure(text, "p.yaml").model.setup[0].settings.text == "Pay 5 $load"


def test_a_doubled_dollar_begins_a_text_that_is_no_reference():
    text = edited(
        PROCEDURE,
        ("Guards closed", "$$load is the load"),
        ("  load: 1000 N", "  load: 1000 N\n  price: $$5"),
        ("text: Remarks", "text: $price"),
    )
    model = parse_procedure(text, "p.yaml").model

    assert model.setup[0].settings.text == "$load is the load"
    assert model.parameters["price"] == "$5"
    assert model.setup[1].settings.text == "$5"
