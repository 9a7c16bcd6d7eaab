"""A conforming unit, and for each check of the kit a unit that fails it."""

from __future__ import annotations

from dataclasses import dataclass, replace

from rigrunner.api.errors import PluginError
from rigrunner.api.hooks import UnitRecord
from rigrunner.api.unit_tables import UnitDefinition
from rigrunner.api.units import define
from unit.rigrunner_testing.helpers_zoo import registry_of

OUNCE = UnitDefinition("zooOz", "mass", "kg", 0.028349523125, spellings=("zoooz",))
TWICE = replace(OUNCE, symbol="zooTwice", spellings=())


@dataclass(frozen=True, kw_only=True)
class CannotBeMade(UnitRecord):
    def factory(self, settings):  # noqa: ARG002  (as its base has it)
        raise PluginError("it cannot be made")


def _record(definition, kind=UnitRecord):
    return kind(name="ounce", help="An ounce.", definition=definition)


UNITS = {
    "can_be_made": _record(OUNCE, CannotBeMade),
    "can_be_known": _record(replace(OUNCE, base="m")),
    "comes_back_as_written": _record(TWICE),
}
"""By check, the unit that fails it."""


def unit_registry(record):
    if record.definition is TWICE:
        define([replace(TWICE, factor=1.0)], "another")
    return registry_of("unit", record)


def good_unit_registry():
    define([OUNCE], "zoo")
    return registry_of("unit", _record(OUNCE))
