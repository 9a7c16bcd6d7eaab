"""Who tested what for whom."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from rigrunner.api.certificate.part import Part, Text


class Laboratory(Part):
    """Who issues the certificate (7.8.2.1 b, c)."""

    name: Text
    address: Annotated[tuple[Text, ...], Field(min_length=1)]
    """Line by line."""
    place: Text
    """Where the test was done: the laboratory's own premises, or another place."""
    contact: str = ""
    accreditation: str = ""
    """What the laboratory says of its accreditation, verbatim; empty for none."""


class Customer(Part):
    """The customer (7.8.2.1 e)."""

    name: Text
    contact: Text
    reference: str = ""
    """The customer's own number of the order."""


class Item(Part):
    """What was tested (7.8.2.1 g, h, k; 7.8.2.2)."""

    description: Text
    identification: Text
    condition: Text
    """As it was received."""
    received: Text
    """The date of receipt, as 2026-01-31."""
    sampling: str = ""
    """Plan and method of sampling, where the laboratory did it; empty: tested as received."""


class Authorisation(Part):
    """Who authorises the certificate (7.8.2.1 o)."""

    by: Text
    role: str = ""
