"""Units of plugins, as stored with a run: it can be read and shown without these plugins."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.errors import DataError
from rigrunner.api.unit_tables import UnitDefinition
from rigrunner.api.units import QuantityError, define

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

_UNIT = "unit "
"""Prefix of the names of units in the provenance of a run."""


def unit_texts(definitions: Iterable[UnitDefinition]) -> dict[str, str]:
    """Return units as texts of a run's provenance, by name."""
    texts = {}
    for unit in definitions:
        scale = "logarithmic" if unit.logarithmic else "linear"
        spellings = " ".join((unit.symbol, *unit.spellings))
        texts[f"{_UNIT}{unit.symbol}"] = (
            f"{unit.kind}; {unit.base}; {unit.factor!r}; {unit.offset!r}; {scale}; {spellings}"
        )
    return texts


def define_units_of(provenance: Mapping[str, str], run_id: str) -> None:
    """Define the units that a run was made with; raise DataError if their text is damaged."""
    try:
        define(_definitions(provenance, run_id), f"the run {run_id}")
    except QuantityError as error:
        raise DataError(error.message, hint=error.hint) from error


def _definitions(provenance: Mapping[str, str], run_id: str) -> Iterator[UnitDefinition]:
    for name, text in provenance.items():
        if not name.startswith(_UNIT):
            continue
        try:
            kind, base, factor, offset, scale, spellings = text.split("; ")
            symbol, *alternatives = spellings.split()
            yield UnitDefinition(
                symbol, kind, base, float(factor), float(offset), tuple(alternatives),
                logarithmic=scale == "logarithmic",
            )  # fmt: skip
        except ValueError as error:
            raise DataError(f"{run_id}: the {name} is damaged: '{text[:60]}'") from error
