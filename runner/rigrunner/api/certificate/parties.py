"""The laboratory, the customer and the item."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from rigrunner.api.certificate.part import Part, Text


class Laboratory(Part):
    """The laboratory that issues the certificate (7.8.2.1 b, c)."""

    name: Text
    address: Annotated[tuple[Text, ...], Field(min_length=1)]
    """Address by line."""
    place: Text
    """Place of the test: the laboratory's premises, or another one."""
    contact: str = ""
    accreditation: str = ""
    """Statement of the laboratory on its accreditation, verbatim; empty for none."""


class Customer(Part):
    """The customer (7.8.2.1 e)."""

    name: Text
    contact: Text
    reference: str = ""
    """Order number of the customer."""


class Item(Part):
    """The item under test (7.8.2.1 g, h, k; 7.8.2.2)."""

    description: Text
    identification: Text
    condition: Text
    """Condition when received."""
    received: Text
    """Date of receipt, such as 2026-01-31."""
    sampling: str = ""
    """Plan and method of sampling, if done by the laboratory; empty: tested as received."""


class Authorisation(Part):
    """The person who authorises the certificate (7.8.2.1 o)."""

    by: Text
    role: str = ""
