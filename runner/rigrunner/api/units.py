"""Units of measurement: the SI, others in common use, and products and quotients of them.

A unit has a kind of quantity beside its dimension (VIM 1.2): N·m is a torque and J an energy, Hz a
frequency, Bq an activity and rad/s an angular velocity, though their dimensions are equal. Spelling
is strict: a general parser reads '12.3 Nm' as twelve point three nano-metres or yarn counts.
"""

from __future__ import annotations

import difflib
import math
import re
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache
from typing import TYPE_CHECKING

from rigrunner.api.errors import RigrunnerError
from rigrunner.api.texts import clip
from rigrunner.api.unit_tables import (
    BY_NAME_ALONE,
    CUSTOMARY,
    FACTORS,
    KINDS,
    LEVELS,
    MEANT,
    PREFIXED,
    PRODUCTS,
    SPELLINGS,
    UNITS,
    Unit,
    UnitDefinition,
)

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

Exponents = tuple[int, ...]
"""Exponents of kg, m, s, A, K, mol, cd and rad, in this order."""


class QuantityError(RigrunnerError, ValueError):
    """A text is not a quantity or unit of the required kind."""


_BASES = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
# Unicode has two of each of these signs, which look alike.
_SAME_LETTERS = str.maketrans(
    {"\N{GREEK SMALL LETTER MU}": "µ", "\N{OHM SIGN}": "Ω", "\N{ANGSTROM SIGN}": "Å"}
)
_SUPERSCRIPTS = "⁰¹²³⁴⁵⁶⁷⁸⁹"
_DIGITS = str.maketrans(f"{_SUPERSCRIPTS}⁻\N{MINUS SIGN}", "0123456789--")
_NAME = "[A-Za-zÅΩµ°%]+"
_MINUS = "-\N{MINUS SIGN}"
# In plain digits a power of 1 is not written, but -1 is.
_POWER = rf"(?:\^?[{_MINUS}]?[2-9]|\^?[{_MINUS}]1|⁻?[{_SUPERSCRIPTS}])"
_FACTOR = rf"{_NAME}{_POWER}?"
_TIMES = r"[·*.]"
_PRODUCT = rf"{_FACTOR}(?:{_TIMES}{_FACTOR})+"
_BELOW = rf"/(?:{_FACTOR}|\({_PRODUCT}\))"
COMPOSED = rf"(?:(?:1|{_FACTOR}){_BELOW}|{_PRODUCT}(?:{_BELOW})?|{_NAME}{_POWER})"
"""A regular expression, also valid in JSON Schema, for products and quotients of units."""
_COMPOSED = re.compile(COMPOSED)
_PART = re.compile(rf"({_NAME})({_POWER})?")
_ADDED_SYMBOL = re.compile(r"[A-Za-zΩµ°%][A-Za-z0-9Ωµ°%]*")
_ADDED_KIND = re.compile(r"[a-z]+(?: [a-z]+)*")
_BASE = re.compile(rf"1|{_NAME}")
"""A base that is not composed."""
_HIGHEST_POWER = 9  # a single superscript
_LARGEST_FACTOR = 1e30
"""That of quetta, the largest prefix of the SI."""
_LONGEST = 40
_NEAR = 0.51
"""Minimum similarity of a suggested unit: °F must not suggest °C."""


def unit(symbol: str, dimension: str | None = None) -> Unit:
    """Return the unit of a symbol or spelling; raise QuantityError with a suggestion.

    `dimension`: the required kind; units of other kinds are not suggested.
    """
    if (match := _BY_SPELLING.get(symbol)) is not None:
        return match
    spelling = symbol.strip().translate(_SAME_LETTERS)
    if (match := _lookup(spelling)) is not None:
        return match
    suggestion = _with_one_bar(spelling) or _similar(spelling, dimension)
    if suggestion:
        hint = f"did you mean '{suggestion}'?"
    elif dimension:
        hint = f"units of {dimension}: {', '.join(units_of(dimension))}"
    else:
        common = ", ".join(entry.symbol for entry in UNITS)
        hint = f"known units, with prefixes, products and quotients: {common}"
    raise QuantityError(f"unknown unit '{clip(symbol.strip())}'", hint=hint)


def find_unit(symbol: str) -> Unit | None:
    """Return the unit of a symbol or spelling; None if there is none, or two define it."""
    with suppress(QuantityError):  # two define it differently
        return _lookup(symbol.strip().translate(_SAME_LETTERS))
    return None


def _lookup(spelling: str) -> Unit | None:
    """Return a unit; None for none. Raises QuantityError if two define it differently."""
    match = _unit_named(spelling)
    if match is None and len(spelling) <= _LONGEST and _COMPOSED.fullmatch(spelling):
        match = _composed(spelling)
    return match


def _with_one_bar(text: str) -> str:
    """Return mV/V/kN as mV/(V·kN), as the SI brochure has it (5.2); '' if it is no such unit."""
    above, *below = text.split("/")
    fixed = f"{above}/({'·'.join(below)})"
    return fixed if len(below) > 1 and _COMPOSED.fullmatch(fixed) and _composed(fixed) else ""


def _similar(text: str, dimension: str | None) -> str:
    """Return the symbol that was probably meant; '' for none."""
    suggestion = MEANT.get(text, "")
    if suggestion and dimension in (None, unit(suggestion).dimension):
        return suggestion
    by_case = {
        spelling.lower(): symbol for spelling, symbol, kind in _spellings()
        if dimension in (None, kind)
    }  # fmt: skip
    matches = difflib.get_close_matches(text[:_LONGEST].lower(), by_case, n=1, cutoff=_NEAR)
    return by_case[matches[0]] if matches else ""


def define(added: Iterable[UnitDefinition], by: str) -> None:
    """Define units; raise QuantityError for an invalid one.

    `by` is the definer: its later definition of a symbol replaces its earlier one. If two definers
    define a symbol differently, using it raises QuantityError, which names both.
    """
    definitions = tuple(added)
    for definition in definitions:
        for objection in _objections(definition, definitions):
            raise QuantityError(f"the unit '{clip(definition.symbol)}' of {by} {objection}")
    for definition in definitions:
        for spelling in (definition.symbol, *definition.spellings):
            claims = _ADDED.setdefault(spelling, {})
            if definition not in claims.values():
                claims[by] = definition
    if definitions:  # products and quotients may use them
        _composed.cache_clear()


def kinds() -> tuple[str, ...]:
    """Return the names of all kinds of quantities."""
    standard = [name for name, _, _ in KINDS]
    return (*standard, *sorted({new.kind for new in _added()} - set(standard)))


def units_of(dimension: str) -> list[str]:
    """Return the symbols of the usual units of a kind, at least of its coherent SI unit."""
    return [entry.symbol for entry in usual_units(dimension)]


def usual_units(dimension: str) -> list[Unit]:
    """Return the usual units for values of a kind, at least its SI unit."""
    units = [u for u in UNITS if u.dimension == dimension and u.symbol not in CUSTOMARY]
    if dimension not in _COHERENT:
        units = list(dict.fromkeys(new.unit for new in _added() if new.kind == dimension))
    return units or [unit(si_symbol(dimension))]


def spellings_of(dimension: str | None) -> list[str]:
    """Return all spellings of units of a kind, or of any kind, without those of COMPOSED."""
    return [spelling for spelling, _, kind in _spellings() if dimension in (None, kind)]


def si_symbol(dimension: str) -> str:
    """Return the symbol of the coherent SI unit of a kind."""
    if dimension in _COHERENT:
        return _COHERENT[dimension]
    return next((new.symbol for new in _added() if _is_si_unit_of(new, dimension)), dimension)


def rate_of(dimension: str) -> str | None:
    """Return the kind of the rate of change of a quantity; None for a level."""
    if _is_level(dimension):
        return None
    symbol = si_symbol(dimension)
    numerator, _, denominator = symbol.partition("/")
    parts = [part for part in (denominator.strip("()"), "s") if part]
    below = "·".join(parts)
    return unit(f"{numerator}/({below})" if len(parts) > 1 else f"{numerator}/s").dimension


def of_difference(dimension: str) -> str:
    """Return the kind of the difference of two values of a kind: of power levels, a level."""
    return "level" if dimension == "power level" else dimension


def from_si(value: float, symbol: str) -> float:
    """Convert an SI value to a unit."""
    return unit(symbol).from_si(value)


def with_symbol(number: str, symbol: str) -> str:
    """Return a number as text with its unit; the unit one is not written (SI brochure, 5.4.7)."""
    return number if symbol in {"", "1"} else f"{number} {symbol}"


def is_coherent(unit_: Unit) -> bool:
    """Return whether numbers in a unit are SI values."""
    return (unit_.factor, unit_.offset) == (1, 0)


def with_article(dimension: str) -> str:
    """Return a kind with its article: 'a force', 'an angle', 'a quantity in V/K'."""
    if dimension not in kinds():
        return f"a quantity in {dimension}"
    return f"{'an' if dimension[0] in 'aeiou' else 'a'} {dimension}"


def _unit_named(spelling: str) -> Unit | None:
    """Return the unit of a name; raise QuantityError if two define it differently."""
    match = _BY_SPELLING.get(spelling)
    if match is not None or spelling not in _ADDED:
        return match
    by, definition = next(iter(_ADDED[spelling].items()))
    for rival_by, rival in _rivals(spelling, definition):
        if replace(rival, spellings=()) != replace(definition, spellings=()):
            definers = f"{by} ({_meaning(definition)}) and {rival_by} ({_meaning(rival)})"
            raise QuantityError(
                f"the unit '{spelling}' is defined twice: by {definers}",
                hint="uninstall or remove one of them; Rigrunner does not choose for you",
            )
    return definition.unit


def _rivals(spelling: str, definition: UnitDefinition) -> Iterator[tuple[str, UnitDefinition]]:
    """Yield other definers of the same symbol, or of another SI unit of the same new kind."""
    yield from _ADDED[spelling].items()
    for claims in _ADDED.values():
        for by, rival in claims.items():
            if all(_is_si_unit_of(each, definition.kind) for each in (definition, rival)):
                yield by, rival


def _meaning(definition: UnitDefinition) -> str:
    zero = f" + {definition.offset!r}" if definition.offset else ""
    size = f"{definition.factor!r}{zero} in {definition.base}"
    return f"{definition.symbol} = {size}, {definition.kind}"


def _objections(definition: UnitDefinition, coherent: Iterable[UnitDefinition]) -> Iterator[str]:
    """Yield why a unit cannot be added; `coherent` are the SI units defined with it."""
    for spelling in (definition.symbol, *definition.spellings):
        if not _ADDED_SYMBOL.fullmatch(spelling) or len(spelling) > _LONGEST:
            yield f"is written '{clip(spelling)}'; expected letters, °, %, µ, Ω, and then digits"
        elif spelling in _BY_SPELLING:
            yield f"is written '{spelling}', and Rigrunner itself has '{spelling}'"
        elif _COMPOSED.fullmatch(spelling):
            yield f"is written '{spelling}', which reads as a power of a unit"
    yield from _objections_to_size(definition, coherent)


def _objections_to_size(
    definition: UnitDefinition, coherent: Iterable[UnitDefinition]
) -> Iterator[str]:
    base, kind = definition.base, definition.kind
    if not 1 / _LARGEST_FACTOR <= definition.factor <= _LARGEST_FACTOR:
        yield f"has factor {definition.factor!r}; expected more than 0, to {_LARGEST_FACTOR:g}"
    if not math.isfinite(definition.offset):
        yield f"has offset {definition.offset!r}"
    names = {name for name, _ in _powers(base)} - set(_BASES)
    if names or not (_BASE.fullmatch(base) or _COMPOSED.fullmatch(base)):
        yield f"has base '{clip(base)}'; expected 1, or products of {', '.join(_BASES)}"
    elif kind in _COHERENT:
        is_level = kind in LEVELS
        if _exponents(base) != _EXPONENTS[kind] or definition.logarithmic != is_level:
            (si_base,) = (si_base for name, _, si_base in KINDS if name == kind)
            level = ", logarithmic" if is_level else ""
            yield f"has base '{base}'; {with_article(kind)} is in {si_base}{level}"
    elif not _ADDED_KIND.fullmatch(kind):
        yield f"has kind '{clip(kind)}'; expected words of small letters"
    elif not any(_is_si_unit_of(each, kind) for each in (*coherent, *_added())):
        yield f"has the new kind '{kind}', of which no unit has factor 1 and offset 0"


def _added() -> Iterator[UnitDefinition]:
    for claims in _ADDED.values():
        yield from claims.values()


def _is_si_unit_of(definition: UnitDefinition, kind: str) -> bool:
    return definition.kind == kind and definition.is_coherent and kind not in _COHERENT


def _is_level(kind: str) -> bool:
    return kind in LEVELS or any(new.logarithmic for new in _added() if new.kind == kind)


def _spellings() -> Iterator[tuple[str, str, str]]:
    """Yield every spelling with the symbol and the kind of its unit."""
    for spelling, entry in _BY_SPELLING.items():
        yield spelling, entry.symbol, entry.dimension
    for spelling, claims in _ADDED.items():
        definition = next(iter(claims.values()))
        yield spelling, definition.symbol, definition.kind


def _powers(text: str) -> Iterator[tuple[str, int]]:
    """Yield each factor of a product or quotient with its power, as written."""
    above, _, below = text.partition("/")
    for part, sign in ((above, 1), (below, -1)):
        for name, power in _PART.findall(part):
            yield name, sign * int(power.lstrip("^").translate(_DIGITS) or 1)


@lru_cache(maxsize=1024)
def _composed(text: str) -> Unit | None:
    """Return the unit of a product or quotient; None if a factor is no unit."""
    parts: list[tuple[Unit, int]] = []
    for name, power in _powers(text):
        base = _unit_named(name)
        if base is None or (power != 1 and not base.symbol.isalpha() and base.symbol != "%"):
            return None  # a power of N·m, written Nm2, may mean two things
        if _is_level(base.dimension):
            hint = "a level is a logarithm: write the quantity itself"
            raise QuantityError(f"no unit is made of {base.symbol}, as in '{text}'", hint=hint)
        if base.offset:
            raise QuantityError(f"'{text}' has {base.symbol}, which has an offset zero",
                                hint="differences of temperature are in K")  # fmt: skip
        parts.append((base, power))
    exact = Fraction(1)
    for base, power in parts:
        # In decimals: products of powers of ten are exact, and equal units have equal factors.
        exact *= Fraction(repr(base.factor)) ** power
    # A fraction beyond the range of floats would be an OverflowError.
    factor = float(exact) if abs(exact) < _LARGEST_FACTOR else math.inf
    if not 1 / _LARGEST_FACTOR <= factor <= _LARGEST_FACTOR:
        raise QuantityError(f"'{text}' is too large or too small a unit")
    symbol = _symbol((base.symbol, power) for base, power in parts)
    return _BY_SPELLING.get(symbol) or Unit(symbol, _kind(parts), factor)


def _symbol(parts: Iterable[tuple[str, int]]) -> str:
    """Return a product or quotient in canonical form: N·m²/(K·s)."""
    factors = list(parts)
    above = [_raised(name, power) for name, power in factors if power > 0]
    below = [_raised(name, -power) for name, power in factors if power < 0]
    under = f"({'·'.join(below)})" if len(below) > 1 else "".join(below)
    return "/".join(part for part in ("·".join(above) or "1", under) if part)


def _raised(name: str, power: int) -> str:
    return name + (_SUPERSCRIPTS[power] if power > 1 else "")


def kind_of(exponents: Exponents) -> str:
    """Return the kind with these exponents; if it has no name, its coherent SI unit."""
    return _KIND_OF.get(exponents) or _shortest(exponents)


def _kind(parts: Iterable[tuple[Unit, int]]) -> str:
    """Return the kind of a product: by its factors if agreed, else by its dimension."""
    powers: dict[str, int] = {}
    dimension = (0,) * len(_BASES)
    for base, power in parts:
        powers[base.dimension] = powers.get(base.dimension, 0) + power
        exponents = exponents_of(base.dimension)
        dimension = tuple(a + power * b for a, b in zip(dimension, exponents, strict=True))
    agreed = frozenset((kind, power) for kind, power in powers.items())
    if agreed in PRODUCTS:
        return PRODUCTS[agreed]
    return kind_of(dimension)


def exponents_of(kind: str) -> Exponents:
    """Return the exponents of a kind for kg, m, s, A, K, mol, cd and rad, in this order."""
    if kind in _EXPONENTS:
        return _EXPONENTS[kind]
    return _exponents(next((new.base for new in _added() if new.kind == kind), kind))


def _exponents(text: str) -> Exponents:
    """Return the exponents of an expression of base units and named coherent units."""
    total = [0] * len(_BASES)
    for name, power in _powers(text):
        if name in _BASES:
            total[_BASES.index(name)] += power
        else:
            (expression,) = (base for _, symbol, base in KINDS if symbol == name)
            for index, exponent in enumerate(_exponents(expression)):
                total[index] += power * exponent
    return tuple(total)


def _shortest(dimension: Exponents) -> str:
    """Return the coherent unit of a dimension without a name, from a named one and base units."""
    named_units = [symbol for _, symbol, _ in KINDS if symbol.isalpha() and symbol not in _BASES]
    if max(map(abs, dimension)) > _HIGHEST_POWER:
        raise QuantityError("the power of a unit is too high")
    candidates: list[tuple[tuple[int, int], str]] = []
    for symbol, sign in [("", 0), *((name, sign) for name in named_units for sign in (1, -1))]:
        exponents = _exponents(symbol)
        # Hz, Bq, Gy, ... share their dimension with another kind, which a product is of.
        if symbol and _KIND_OF.get(exponents) != _KIND_BY_SYMBOL[symbol]:
            continue
        remainder = tuple(a - sign * b for a, b in zip(dimension, exponents, strict=True))
        factors = [(symbol, sign)] if symbol else []
        factors += [(base, power) for base, power in zip(_BASES, remainder, strict=True) if power]
        if max(map(abs, remainder)) > _HIGHEST_POWER:
            continue
        size = sum(abs(power) for _, power in factors)
        candidates.append(((len(factors), size), _symbol(factors)))
    return min(candidates, key=lambda candidate: candidate[0])[1]


def _all_spellings() -> dict[str, Unit]:
    units = {entry.symbol: entry for entry in UNITS}
    for symbol, prefixes in PREFIXED.items():
        base = units[symbol]
        for prefix in prefixes:
            name = f"{prefix}{symbol}"
            prefixed = Unit(name, base.dimension, FACTORS[prefix] * base.factor)
            units.setdefault(name, prefixed)
    for name in [name for name in units if name.startswith("µ")]:
        units[f"u{name[1:]}"] = units[name]
    return units


_COHERENT = {name: symbol for name, symbol, _ in KINDS}
_KIND_BY_SYMBOL = {symbol: name for name, symbol, _ in KINDS}
_EXPONENTS = {name: _exponents(base) for name, _, base in KINDS}
_KIND_OF = {exponents: name for name, exponents in _EXPONENTS.items() if name not in BY_NAME_ALONE}
_ADDED: dict[str, dict[str, UnitDefinition]] = {}
"""Units of plugins and stored runs: by spelling, then by definer."""
_BY_SPELLING: dict[str, Unit] = _all_spellings()
_BY_SPELLING.update({spelling: unit(symbol) for spelling, symbol in SPELLINGS.items()})
