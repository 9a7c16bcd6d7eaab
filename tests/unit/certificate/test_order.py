"""The details of an order: all missing ones are reported, others are taken from the run."""

from __future__ import annotations

import re

import pytest

from helpers_certificate import ORDER
from rigrunner.api.errors import InvalidFileError, UsageError
from rigrunner.certificate.order import NEEDED, Order, complete, read_order

INPUTS = {"specimen": "SN-17", "operator": "O. Perator"}


def test_missing_details_are_reported_at_once_with_their_options():
    with pytest.raises(UsageError) as caught:
        complete(Order(), {}, {})
    for name, words in NEEDED.items():
        assert words in caught.value.message
        assert f"--{name.replace('_', '-')}" in caught.value.hint


@pytest.mark.parametrize("name", ["customer", "customer_contact", "item", "item_condition"])
def test_blank_detail_is_missing(name):
    with pytest.raises(UsageError, match=NEEDED[name]):
        complete(ORDER.model_copy(update={name: "  "}), {}, INPUTS)


def test_details_of_the_run_are_used():
    order = complete(ORDER, {}, INPUTS)
    assert (order.item_id, order.operator) == ("SN-17", "O. Perator")


def test_options_override_the_order_which_overrides_the_run():
    order = ORDER.model_copy(update={"item_id": "from the order"})
    assert complete(order, {}, INPUTS).item_id == "from the order"
    assert complete(order, {"item_id": "given"}, INPUTS).item_id == "given"


def test_invalid_date_names_its_option():
    with pytest.raises(UsageError, match=re.escape("--received: 'tomorrow' is not a date")):
        complete(ORDER, {"received": "tomorrow"}, INPUTS)


def test_order_file_is_read_strictly(tmp_path):
    path = tmp_path / "order.yaml"
    path.write_text("rigrunner: order/1\ncustomer: A\ncustumer_contact: B\n")
    with pytest.raises(InvalidFileError, match=r"order\.yaml:3:1.*did you mean 'customer_contact'"):
        read_order(path)
