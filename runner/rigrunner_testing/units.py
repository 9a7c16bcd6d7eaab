"""Checks on units of measurement."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.hooks import UnitRecord
from rigrunner.api.quantity import parse_quantity
from rigrunner.api.units import QuantityError, define
from rigrunner_testing.check import AnyCheck, Nonconformity, check, demand

if TYPE_CHECKING:
    from rigrunner_testing.subjects import Subject

NUMBER = 3.0


@check(fix="give it a symbol of its own, its kind of quantity, and that kind's base units")
def can_be_known(subject: Subject) -> None:
    """Its symbol and spellings are unused, and its dimension is that of its kind of quantity."""
    try:
        define([subject.record_as(UnitRecord).definition], subject.plugin.provider.name)
    except QuantityError as error:
        raise Nonconformity(error.message) from error


@check(fix="let no other plugin define the same symbol", needs=("can_be_known",))
def comes_back_as_written(subject: Subject) -> None:
    """A quantity in each of its spellings is parsed, and shown with its symbol."""
    definition = subject.record_as(UnitRecord).definition
    for spelling in (definition.symbol, *definition.spellings):
        try:
            quantity = parse_quantity(f"{NUMBER:g} {spelling}", definition.kind)
        except QuantityError as error:
            raise Nonconformity(error.message, fix=error.hint) from error
        shown = f"{NUMBER:g} {definition.symbol}"
        demand(str(quantity) == shown, f"'{spelling}' comes back as '{quantity}'")
        si = NUMBER * definition.factor + definition.offset
        parsed = quantity.si
        demand(parsed == si, f"3 {spelling} is {parsed!r} in the SI unit, by the record {si!r}")


CHECKS: tuple[AnyCheck, ...] = (can_be_known, comes_back_as_written)
