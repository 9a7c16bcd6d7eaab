"""What only people know of a test: the customer, the item as it came, who authorises.

It comes from options of the command, else from a file `order/1`, else from the run's inputs of the
same name. What ISO/IEC 17025:2017, 7.8.2.1 requires is asked for, never left blank.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from pydantic import ValidationError

from rigrunner.api.certificate import Customer, ExternalResult, Item, Opinion
from rigrunner.api.errors import UsageError
from rigrunner.api.settings import IsoDate, ListOf, PlainText, Settings
from rigrunner.yamlfile import read, validate
from rigrunner.yamlfile.names import Text

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path


class OpinionEntry(Settings):
    """An opinion or interpretation."""

    text: Text
    """With its basis."""
    by: Text
    """Who is authorised to give it."""


class ExternalEntry(Settings):
    """A result that another provider supplied."""

    text: Text
    """The result with its uncertainty."""
    provider: Text
    """Who supplied it."""


class Order(Settings):
    """What is known of an order; every field may be left out until a certificate is issued."""

    rigrunner: Literal["order/1"] = "order/1"
    """What this file is, and its version of the language."""
    customer: PlainText = ""
    """Name of the customer."""
    customer_contact: PlainText = ""
    """Address, or how else to reach the customer."""
    customer_reference: PlainText = ""
    """The customer's own number of the order."""
    item: PlainText = ""
    """What was tested, in words."""
    item_id: PlainText = ""
    """By what the item is told from others: left out, the run's input `specimen`."""
    item_condition: PlainText = ""
    """The state in which it was received."""
    received: IsoDate | None = None
    """When it was received."""
    sampling: PlainText = ""
    """Plan and method of sampling, where the laboratory did it."""
    conditions: PlainText = ""
    """What is to be said of the conditions besides what was recorded."""
    operator: PlainText = ""
    """Who measured: left out, the run's input `operator`."""
    deviations: ListOf[Text] = ()
    """Deviations from the method that no record shows."""
    opinions: ListOf[OpinionEntry] = ()
    """Opinions and interpretations; they are marked as such."""
    external: ListOf[ExternalEntry] = ()
    """Results of external providers; they are marked as such."""


FROM_INPUT = {"item_id": "specimen", "operator": "operator"}
"""Fields that a run's input answers under another name, or the same."""
NEEDED = {
    "customer": "the customer's name",
    "customer_contact": "the customer's address or other contact",
    "item": "what was tested, in words",
    "item_id": "by what the item is told from others",
    "item_condition": "the state in which the item was received",
    "received": "the date of receipt",
    "operator": "who measured",
}
"""What a certificate must say (ISO/IEC 17025:2017, 7.8.2.1 e, g, h; operator: 7.5.1)."""


def read_order(path: Path) -> Order:
    """Return the order in a file; raise InvalidFileError with all that is wrong in it."""
    return validate(Order, read(path))


def complete(order: Order, given: Mapping[str, object], inputs: Mapping[str, str]) -> Order:
    """Return the order with the options that were given, and with what the run's inputs know.

    Raises UsageError that names everything that is missing, and how to give it.
    """
    known = {
        name: value
        for name in NEEDED
        if isinstance(value := inputs.get(FROM_INPUT.get(name, name), ""), str) and value.strip()
    }
    entered = {name: value for name, value in order if value}
    text = known | entered | {name: value for name, value in given.items() if value}
    try:
        merged = Order.model_validate(text)
    except ValidationError as error:
        first = error.errors()[0]
        name = str(first["loc"][0])
        raise UsageError(
            f"{_option(name)}: {first['msg'].removeprefix('Value error, ')}", field=name
        ) from error
    missing = [name for name in NEEDED if not str(getattr(merged, name) or "").strip()]
    if missing:
        raise UsageError(
            "a certificate must say: " + "; ".join(f"{NEEDED[name]} ({name})" for name in missing),
            hint=f"give {', '.join(_option(name) for name in missing)}, or an --order FILE",
            field=missing[0],
        )
    return merged


def customer_of(order: Order) -> Customer:
    """Return the customer of a complete order."""
    return Customer(
        name=order.customer, contact=order.customer_contact, reference=order.customer_reference
    )


def item_of(order: Order) -> Item:
    """Return the item of a complete order."""
    return Item(
        description=order.item,
        identification=order.item_id,
        condition=order.item_condition,
        received="" if order.received is None else order.received.isoformat(),
        sampling=order.sampling,
    )


def opinions_of(order: Order) -> tuple[Opinion, ...]:
    """Return the opinions and interpretations."""
    return tuple(Opinion(text=each.text, by=each.by) for each in order.opinions)


def external_of(order: Order) -> tuple[ExternalResult, ...]:
    """Return the results of external providers."""
    return tuple(ExternalResult(text=each.text, provider=each.provider) for each in order.external)


def _option(name: str) -> str:
    return f"--{name.replace('_', '-')}"
