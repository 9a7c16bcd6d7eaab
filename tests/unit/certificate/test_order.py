"""What a certificate must say is asked for, all at once, and taken from where it is known."""

from __future__ import annotations

import re

import pytest

from helpers_certificate import ORDER
from rigrunner.api.errors import InvalidFileError, UsageError
from rigrunner.certificate.order import NEEDED, Order, complete, read_order

INPUTS = {"specimen": "SN-17", "operator": "O. Perator"}


def test_all_that_is_missing_is_named_at_once_with_its_option():
    with pytest.raises(UsageError) as caught:
        complete(Order(), {}, {})
    for name, words in NEEDED.items():
        assert words in caught.value.message
        assert f"--{name.replace('_', '-')}" in caught.value.hint


@pytest.mark.parametrize("name", ["customer", "customer_contact", "item", "item_condition"])
def test_blanks_are_no_answer(name):
    with pytest.raises(UsageError, match=NEEDED[name]):
        complete(ORDER.model_copy(update={name: "  "}), {}, INPUTS)


def test_what_the_run_knows_is_not_asked_again():
    order = complete(ORDER, {}, INPUTS)
    assert (order.item_id, order.operator) == ("SN-17", "O. Perator")


def test_options_go_before_the_order_and_that_before_the_run():
    order = ORDER.model_copy(update={"item_id": "from the order"})
    assert complete(order, {}, INPUTS).item_id == "from the order"
    assert complete(order, {"item_id": "given"}, INPUTS).item_id == "given"


def test_a_wrong_date_is_told_by_its_option():
    with pytest.raises(UsageError, match=re.escape("--received: 'tomorrow' is not a date")):
        complete(ORDER, {"received": "tomorrow"}, INPUTS)


def test_a_file_is_read_strictly(tmp_path):
    path = tmp_path / "order.yaml"
    path.write_text("rigrunner: order/1\ncustomer: A\ncustumer_contact: B\n")
    with pytest.raises(InvalidFileError, match=r"order\.yaml:3:1.*did you mean 'customer_contact'"):
        read_order(path)
