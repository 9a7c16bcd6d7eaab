"""The quantities that can be studied over many runs, results or figures of the rig, and limits."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from rigrunner.api.errors import UsageError
from rigrunner.api.quantity import parse_quantity
from rigrunner.api.units import QuantityError, from_si, unit, with_article
from rigrunner_fleet.archive.querying import rows

if TYPE_CHECKING:
    from rigrunner.api.quantity import Quantity as PhysicalQuantity
    from rigrunner_fleet.archive.database import Database
    from rigrunner_fleet.archive.filters import Filters

TORQUE_UNIT = "N·m"
TORQUES = {"torque": ("torque_nm", "expanded_nm"), "raw_peak": ("raw_peak_nm", "")}
"""Columns of a run, and of a set-point: the value and its expanded uncertainty."""
SHORT = {"J": "inertia", "fn": "natural frequency", "damping": "damping ratio"}
"""Short names of the rig's figures."""
ZERO = "zero"


@dataclass(frozen=True)
class Quantity:
    """A result of runs, or a figure of their rigs in the archive: 'name', 'source/name'."""

    name: str
    is_named: bool = False
    """Whether it is a named result, of any unit."""

    @property
    def is_result(self) -> bool:
        """Whether it is a result; else a figure of the rig."""
        return self.is_named or self.name in TORQUES

    @property
    def groups(self) -> tuple[str, ...]:
        """Columns of runs by which it is grouped by default."""
        return ("type", "lot") if self.is_result else ("rig",)

    @property
    def is_zero(self) -> bool:
        """Whether it is a zero reading, which depends on no mandrel."""
        return self.name == ZERO or self.name.startswith(f"{ZERO}/")

    def fits(self, source: str, name: str) -> bool:
        """Return whether a figure of the archive is this one."""
        figure = SHORT.get(self.name, self.name)
        return figure in {name, f"{source}/{name}"} or (figure == ZERO == source)


def quantity_in(archive: Database, name: str, filters: Filters) -> Quantity:
    """Return the quantity of a name: a result of the selected runs, else a figure of rigs."""
    if name in TORQUES:
        return Quantity(name)
    return Quantity(
        name, is_named=len(rows(archive, "results", of_name(name, filters), limit=1)) > 0
    )


def of_name(name: str, filters: Filters) -> Filters:
    """Return filters of the runs that have a named result."""
    return replace(filters, results={name: None, **filters.results})


def limit_in(text: str, symbol: str) -> float | None:
    """Return a limit in the unit of a study, None for an empty text; raise UsageError."""
    return from_si(_read(text, symbol).si, symbol) if text else None


def width_in(text: str, symbol: str) -> float | None:
    """Return a difference of two limits in the unit of a study; raises as `limit_in`."""
    if not text:
        return None
    width = _read(text, symbol)
    # A difference: the offset of a scale of temperature is in none.
    return width.number * width.unit.factor / unit(symbol).factor


def _read(text: str, symbol: str) -> PhysicalQuantity:
    try:
        quantity = parse_quantity(text)
    except QuantityError as error:
        raise UsageError(f"'{text}': {error.message}", hint=error.hint) from error
    if quantity.dimension != unit(symbol).dimension:
        raise UsageError(
            f"'{text}' is {with_article(quantity.dimension)}, and the values are in {symbol}"
        )
    return quantity
