"""The order: the data of a test that only people have, such as customer and item.

It comes from options of the command, else from a file `order/1`, else from inputs of the run with
the same name. What ISO/IEC 17025:2017, 7.8.2.1 requires must be stated.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from pydantic import ValidationError

from rigrunner.api.certificate import Customer, ExternalResult, Item, Opinion
from rigrunner.api.errors import UsageError
from rigrunner.api.names import Text
from rigrunner.api.settings import IsoDate, ListOf, PlainText, Settings
from rigrunner.yamlfile import read, validate

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path


class OpinionEntry(Settings):
    """An opinion or interpretation."""

    text: Text
    """The opinion with its basis."""
    by: Text
    """Who is authorised to give it."""


class ExternalEntry(Settings):
    """A result of an external provider."""

    text: Text
    """The result with its uncertainty."""
    provider: Text
    """The provider."""


class Order(Settings):
    """An order; fields may be left out until a certificate is issued."""

    rigrunner: Literal["order/1"] = "order/1"
    """Type and version of this file."""
    customer: PlainText = ""
    """Name of the customer."""
    customer_contact: PlainText = ""
    """Address or other contact of the customer."""
    customer_reference: PlainText = ""
    """Order number of the customer."""
    item: PlainText = ""
    """Description of the item."""
    item_id: PlainText = ""
    """Identification of the item; by default the input `specimen` of the run."""
    item_condition: PlainText = ""
    """Condition of the item when received."""
    received: IsoDate | None = None
    """Date of receipt."""
    sampling: PlainText = ""
    """Plan and method of sampling, if done by the laboratory."""
    conditions: PlainText = ""
    """Statement on the conditions, in addition to the recorded ones."""
    operator: PlainText = ""
    """Name of the operator; by default the input `operator` of the run."""
    deviations: ListOf[Text] = ()
    """Deviations from the method that are not recorded."""
    opinions: ListOf[OpinionEntry] = ()
    """Opinions and interpretations, marked as such."""
    external: ListOf[ExternalEntry] = ()
    """Results of external providers, marked as such."""


FROM_INPUT = {"item_id": "specimen", "operator": "operator"}
"""Inputs of a run that answer fields, by field."""
NEEDED = {
    "customer": "the customer's name",
    "customer_contact": "the customer's address or other contact",
    "item": "a description of the item",
    "item_id": "the identification of the item",
    "item_condition": "the condition of the item when received",
    "received": "the date of receipt",
    "operator": "who measured",
}
"""What a certificate must state (ISO/IEC 17025:2017, 7.8.2.1 e, g, h; operator: 7.5.1)."""


def read_order(path: Path) -> Order:
    """Return the order in a file; raise InvalidFileError with all problems."""
    return validate(Order, read(path))


def complete(order: Order, options: Mapping[str, object], inputs: Mapping[str, str]) -> Order:
    """Return the order completed from options and inputs of the run.

    Raises UsageError with everything that is missing, and how to give it.
    """
    answers = {
        name: value
        for name in NEEDED
        if isinstance(value := inputs.get(FROM_INPUT.get(name, name), ""), str) and value.strip()
    }
    from_file = {name: value for name, value in order if value}
    # An option takes precedence over the file, and that over the inputs of the run.
    values = answers | from_file | {name: value for name, value in options.items() if value}
    try:
        merged = Order.model_validate(values)
    except ValidationError as error:
        first = error.errors()[0]
        name = str(first["loc"][0])
        raise UsageError(
            f"{_option(name)}: {first['msg'].removeprefix('Value error, ')}", field=name
        ) from error
    missing = [name for name in NEEDED if not str(getattr(merged, name) or "").strip()]
    if missing:
        raise UsageError(
            "a certificate must state: "
            + "; ".join(f"{NEEDED[name]} ({name})" for name in missing),
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
    return tuple(Opinion(text=opinion.text, by=opinion.by) for opinion in order.opinions)


def external_of(order: Order) -> tuple[ExternalResult, ...]:
    """Return the results of external providers."""
    return tuple(ExternalResult(text=each.text, provider=each.provider) for each in order.external)


def _option(name: str) -> str:
    return f"--{name.replace('_', '-')}"
