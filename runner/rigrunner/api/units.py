"""Units of measurement: the SI, others in common use, and products and quotients of them.

A unit has a kind of quantity beside its dimension (VIM 1.2): N·m is a torque and J an energy, Hz a
frequency, Bq an activity and rad/s an angular velocity, though their dimensions are equal. Spelling
is strict: a general parser reads '12.3 Nm' as twelve point three nano-metres or yarn counts.

Sources of the factors: SI brochure, 9th edition, tables 2 to 8; NIST SP 811, B.8, for what is not
of the SI. All are exact but mmHg.
"""

from __future__ import annotations

import difflib
import math
import re
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import TYPE_CHECKING

from rigrunner.api.errors import RigrunnerError

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

Exponents = tuple[int, ...]
"""Of kg, m, s, A, K, mol, cd and rad, in this order."""


class QuantityError(RigrunnerError, ValueError):
    """A text is not a quantity or unit of the kind that is needed here."""


@dataclass(frozen=True)
class Unit:
    """A unit of measurement; SI value = number * factor + offset."""

    symbol: str
    dimension: str
    """The kind of quantity, such as 'torque'; of a kind without a name its coherent SI unit."""
    factor: float = 1.0
    offset: float = 0.0


_BASES = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
_LBF = 4.4482216152605
_INCH = 0.0254
_DEG = math.pi / 180

_KINDS: tuple[tuple[str, str, str], ...] = (
    ("torque", "N·m", "kg·m²/s²"),
    ("force", "N", "kg·m/s²"),
    ("frequency", "Hz", "1/s"),
    ("angle", "rad", "rad"),
    ("time", "s", "s"),
    ("length", "m", "m"),
    ("ratio", "1", "1"),
    ("temperature", "K", "K"),
    ("voltage", "V", "kg·m²/(s³·A)"),
    ("voltage ratio", "V/V", "1"),
    ("current", "A", "A"),
    ("mass", "kg", "kg"),
    ("moment of inertia", "kg·m²", "kg·m²"),
    ("rotational damping", "N·m·s/rad", "kg·m²/(s·rad)"),
    ("angular velocity", "rad/s", "rad/s"),
    ("angular acceleration", "rad/s²", "rad/s²"),
    ("force rate", "N/s", "kg·m/s³"),
    ("frequency rate", "Hz/s", "1/s²"),
    ("speed", "m/s", "m/s"),
    ("torque rate", "N·m/s", "kg·m²/s³"),
    ("temperature rate", "K/s", "K/s"),
    ("resistance", "Ω", "kg·m²/(s³·A²)"),
    ("power", "W", "kg·m²/s³"),
    ("energy", "J", "kg·m²/s²"),
    ("pressure", "Pa", "kg/(m·s²)"),
    ("acceleration", "m/s²", "m/s²"),
    ("area", "m²", "m²"),
    ("volume", "m³", "m³"),
    ("volume flow rate", "m³/s", "m³/s"),
    ("mass flow rate", "kg/s", "kg/s"),
    ("density", "kg/m³", "kg/m³"),
    ("dynamic viscosity", "Pa·s", "kg/(m·s)"),
    ("kinematic viscosity", "m²/s", "m²/s"),
    ("stiffness", "N/m", "kg/s²"),
    ("rotational stiffness", "N·m/rad", "kg·m²/(s²·rad)"),
    ("conductivity", "S/m", "s³·A²/(kg·m³)"),
    ("charge", "C", "A·s"),
    ("conductance", "S", "s³·A²/(kg·m²)"),
    ("capacitance", "F", "s⁴·A²/(kg·m²)"),
    ("inductance", "H", "kg·m²/(s²·A²)"),
    ("magnetic flux", "Wb", "kg·m²/(s²·A)"),
    ("magnetic flux density", "T", "kg/(s²·A)"),
    ("resistivity", "Ω·m", "kg·m³/(s³·A²)"),
    ("thermal conductivity", "W/(m·K)", "kg·m/(s³·K)"),
    ("temperature coefficient", "1/K", "1/K"),
    ("voltage rate", "V/s", "kg·m²/(s⁴·A)"),
    ("current rate", "A/s", "A/s"),
    ("pressure rate", "Pa/s", "kg/(m·s³)"),
    ("responsivity", "A/W", "s³·A/(kg·m²)"),
    ("rate", "1/s", "1/s"),
    ("amount of substance", "mol", "mol"),
    ("amount concentration", "mol/m³", "mol/m³"),
    ("luminous intensity", "cd", "cd"),
    ("luminance", "cd/m²", "cd/m²"),
    ("luminous flux", "lm", "cd"),
    ("illuminance", "lx", "cd/m²"),
    ("activity", "Bq", "1/s"),
    ("absorbed dose", "Gy", "m²/s²"),
    ("dose equivalent", "Sv", "m²/s²"),
    ("catalytic activity", "kat", "mol/s"),
    ("level", "dB", "1"),
    ("power level", "dBm", "1"),
    ("pH", "pH", "1"),
)
"""Kinds of quantities: name, coherent SI unit, and that in base units."""

_BY_NAME_ALONE = {
    *("torque", "torque rate", "frequency", "frequency rate", "activity", "voltage ratio"),
    *("luminous flux", "illuminance", "absorbed dose", "dose equivalent", "level", "power level"),
    "pH",
}
"""Another kind has the same dimension: a product or quotient is of these by what it is made of."""
_LEVELS = {"level", "power level", "pH"}
"""Logarithmic: no product or quotient is made of them."""

_PRODUCTS: Mapping[frozenset[tuple[str, int]], str] = {
    frozenset({("force", 1), ("length", 1)}): "torque",
    frozenset({("force", 1), ("length", 1), ("time", -1)}): "torque rate",
    frozenset({("torque", 1), ("time", -1)}): "torque rate",
    frozenset({("frequency", 1), ("time", -1)}): "frequency rate",
    frozenset({("luminous flux", 1), ("area", -1)}): "illuminance",
    frozenset({("luminous flux", 1), ("length", -2)}): "illuminance",
    frozenset({("voltage", 0)}): "voltage ratio",
}
"""Kinds that a product has by the kinds of its factors, each with its power."""

UNITS: tuple[Unit, ...] = (
    Unit("N·m", "torque"),
    Unit("mN·m", "torque", 1e-3),
    Unit("in·lbf", "torque", 0.1129848290276167),
    Unit("N", "force"),
    Unit("kN", "force", 1e3),
    Unit("lbf", "force", _LBF),
    Unit("kgf", "force", 9.80665),
    Unit("Hz", "frequency"),
    Unit("kHz", "frequency", 1e3),
    Unit("rpm", "frequency", 1 / 60),
    Unit("rad", "angle"),
    Unit("mrad", "angle", 1e-3),
    Unit("deg", "angle", _DEG),
    Unit("rev", "angle", 2 * math.pi),
    Unit("s", "time"),
    Unit("ms", "time", 1e-3),
    Unit("min", "time", 60.0),
    Unit("h", "time", 3600.0),
    Unit("d", "time", 86400.0),
    Unit("m", "length"),
    Unit("mm", "length", 1e-3),
    Unit("µm", "length", 1e-6),
    Unit("in", "length", _INCH),
    Unit("ft", "length", 0.3048),
    Unit("1", "ratio"),
    Unit("%", "ratio", 1e-2),
    Unit("ppm", "ratio", 1e-6),
    Unit("ppb", "ratio", 1e-9),
    Unit("K", "temperature"),
    Unit("°C", "temperature", 1.0, 273.15),
    Unit("°F", "temperature", 5 / 9, 459.67 * 5 / 9),
    Unit("V", "voltage"),
    Unit("mV", "voltage", 1e-3),
    Unit("V/V", "voltage ratio"),
    Unit("mV/V", "voltage ratio", 1e-3),
    Unit("A", "current"),
    Unit("mA", "current", 1e-3),
    Unit("kg", "mass"),
    Unit("g", "mass", 1e-3),
    Unit("t", "mass", 1e3),
    Unit("lb", "mass", 0.45359237),
    Unit("kg·m²", "moment of inertia"),
    Unit("N·m·s/rad", "rotational damping"),
    Unit("rad/s", "angular velocity"),
    Unit("deg/s", "angular velocity", _DEG),
    Unit("rad/s²", "angular acceleration"),
    Unit("N/s", "force rate"),
    Unit("kN/s", "force rate", 1e3),
    Unit("Hz/s", "frequency rate"),
    Unit("rpm/s", "frequency rate", 1 / 60),
    Unit("m/s", "speed"),
    Unit("mm/s", "speed", 1e-3),
    Unit("N·m/s", "torque rate"),
    Unit("K/s", "temperature rate"),
    Unit("K/min", "temperature rate", 1 / 60),
    Unit("Ω", "resistance"),
    Unit("kΩ", "resistance", 1e3),
    Unit("mΩ", "resistance", 1e-3),
    Unit("W", "power"),
    Unit("kW", "power", 1e3),
    Unit("mW", "power", 1e-3),
    Unit("J", "energy"),
    Unit("eV", "energy", 1.602176634e-19),
    Unit("Pa", "pressure"),
    Unit("kPa", "pressure", 1e3),
    Unit("MPa", "pressure", 1e6),
    Unit("bar", "pressure", 1e5),
    Unit("mbar", "pressure", 1e2),
    Unit("psi", "pressure", _LBF / _INCH**2),
    Unit("atm", "pressure", 101325.0),
    Unit("Torr", "pressure", 101325 / 760),
    Unit("mmHg", "pressure", 133.322387415),
    Unit("m/s²", "acceleration"),
    Unit("m²", "area"),
    Unit("mm²", "area", 1e-6),
    Unit("m³", "volume"),
    Unit("L", "volume", 1e-3),
    Unit("mL", "volume", 1e-6),
    Unit("m³/s", "volume flow rate"),
    Unit("L/min", "volume flow rate", 1e-3 / 60),
    Unit("kg/s", "mass flow rate"),
    Unit("g/s", "mass flow rate", 1e-3),
    Unit("kg/m³", "density"),
    Unit("Pa·s", "dynamic viscosity"),
    Unit("cP", "dynamic viscosity", 1e-3),
    Unit("m²/s", "kinematic viscosity"),
    Unit("cSt", "kinematic viscosity", 1e-6),
    Unit("N/m", "stiffness"),
    Unit("N/mm", "stiffness", 1e3),
    Unit("N·m/rad", "rotational stiffness"),
    Unit("C", "charge"),
    Unit("S", "conductance"),
    Unit("F", "capacitance"),
    Unit("µF", "capacitance", 1e-6),
    Unit("H", "inductance"),
    Unit("mH", "inductance", 1e-3),
    Unit("Wb", "magnetic flux"),
    Unit("T", "magnetic flux density"),
    Unit("mT", "magnetic flux density", 1e-3),
    Unit("Ω·m", "resistivity"),
    Unit("W/(m·K)", "thermal conductivity"),
    Unit("1/K", "temperature coefficient"),
    Unit("V/s", "voltage rate"),
    Unit("A/s", "current rate"),
    Unit("Pa/s", "pressure rate"),
    Unit("bar/min", "pressure rate", 1e5 / 60),
    Unit("A/W", "responsivity"),
    Unit("1/s", "rate"),
    Unit("1/min", "rate", 1 / 60),
    Unit("mol", "amount of substance"),
    Unit("mol/m³", "amount concentration"),
    Unit("mol/L", "amount concentration", 1e3),
    Unit("cd", "luminous intensity"),
    Unit("cd/m²", "luminance"),
    Unit("lm", "luminous flux"),
    Unit("lx", "illuminance"),
    Unit("Bq", "activity"),
    Unit("Gy", "absorbed dose"),
    Unit("Sv", "dose equivalent"),
    Unit("kat", "catalytic activity"),
    Unit("dB", "level"),
    Unit("dBm", "power level"),
    Unit("pH", "pH"),
)
"""What messages and pages list; more are made by prefixes, products and quotients."""

_CUSTOMARY = {
    *("in·lbf", "lbf", "kgf", "in", "ft", "lb", "°F", "psi", "atm", "Torr", "mmHg", "rev", "eV"),
    *("t", "ppb", "cP", "cSt", "bar/min", "mbar"),
}
"""Read, but no value is written in them that a person did not write so."""

_FACTORS = {
    "T": 1e12,
    "G": 1e9,
    "M": 1e6,
    "k": 1e3,
    "h": 1e2,
    "d": 1e-1,
    "c": 1e-2,
    "m": 1e-3,
    "µ": 1e-6,
    "n": 1e-9,
    "p": 1e-12,
    "f": 1e-15,
}
_PREFIXED = {
    **dict.fromkeys(("N", "J", "W", "V", "Ω", "Hz", "eV"), "TGMkmµnp"),
    **dict.fromkeys(("A", "C", "S", "F", "Wb", "T", "lm", "lx", "cd", "Gy", "Sv"), "kmµnpf"),
    "H": "mµn",
    "Bq": "TGMk",
    "kat": "mµn",
    "mol": "kmµn",
    "K": "mµ",
    "rad": "mµ",
    "m": "kdcmµnpf",
    "g": "mµn",
    "s": "mµnp",
    "L": "dcmµ",
    "Pa": "GMkhmµ",
    "bar": "kmµ",
}
"""Which prefixes a unit takes; pH is no picohenry."""

_SPELLINGS = {
    "Nm": "N·m", "N m": "N·m", "mNm": "mN·m", "kNm": "kN·m",
    "in-lb": "in·lbf", "in-lbf": "in·lbf", "in·lb": "in·lbf", "ft-lb": "ft·lbf", "lb-ft": "ft·lbf",
    "°": "deg", "degC": "°C", "degF": "°F", "kg m2": "kg·m²", "r/min": "rpm", "rev/min": "rpm",
    "Wh": "W·h", "kWh": "kW·h", "Ah": "A·h", "mAh": "mA·h", "l": "L", "ml": "mL", "l/min": "L/min",
    "Ohm": "Ω", "ohm": "Ω", "kOhm": "kΩ", "kohm": "kΩ", "MOhm": "MΩ", "Mohm": "MΩ", "mOhm": "mΩ",
    "mohm": "mΩ",
}  # fmt: skip
_SAME_LETTERS = str.maketrans({"\N{GREEK SMALL LETTER MU}": "µ", "\N{OHM SIGN}": "Ω"})
_SUPERSCRIPTS = "⁰¹²³⁴⁵⁶⁷⁸⁹"
_DIGITS = str.maketrans(f"{_SUPERSCRIPTS}⁻\N{MINUS SIGN}", "0123456789--")
_NAME = "[A-Za-zΩµ°%]+"
_MINUS = "-\N{MINUS SIGN}"
_POWER = rf"(?:\^?[{_MINUS}]?[2-9]|\^?[{_MINUS}]1|⁻?[{_SUPERSCRIPTS}])"
_FACTOR = rf"{_NAME}{_POWER}?"
_TIMES = r"[·*.]"
_PRODUCT = rf"{_FACTOR}(?:{_TIMES}{_FACTOR})*"
COMPOSED = rf"(?:1|{_PRODUCT})(?:/(?:{_FACTOR}|\({_PRODUCT}\)))?"
"""A regular expression, for JSON Schema too, of products and quotients of units."""
_COMPOSED = re.compile(COMPOSED)
_PART = re.compile(rf"({_NAME})({_POWER})?")
_LARGEST_FACTOR = 1e30
_LONGEST = 40
_NEAR = 0.51
"""How alike a unit must be to be suggested: °C is not what was meant by °F."""


def unit(symbol: str, dimension: str | None = None) -> Unit:
    """Return the unit of that symbol or spelling; raise QuantityError with a suggestion.

    `dimension`: what is measured here; a unit of something else is not suggested.
    """
    wanted = symbol.strip().translate(_SAME_LETTERS)
    found = _BY_SPELLING.get(wanted)
    if found is None and len(wanted) <= _LONGEST and _COMPOSED.fullmatch(wanted):
        found = _composed(wanted)
    if found is not None:
        return found
    by_case = {
        spelling.lower(): known.symbol
        for spelling, known in _BY_SPELLING.items()
        if dimension in (None, known.dimension)
    }
    near = difflib.get_close_matches(wanted[:_LONGEST].lower(), by_case, n=1, cutoff=_NEAR)
    hint = f"did you mean '{by_case[near[0]]}'?" if near else _listing(dimension)
    raise QuantityError(f"unknown unit '{clip(symbol.strip())}'", hint=hint)


def kinds() -> tuple[str, ...]:
    """Return the names of all kinds of quantities that have one."""
    return tuple(name for name, _, _ in _KINDS)


def units_of(dimension: str) -> list[str]:
    """Return the symbols of the listed units of a kind, at least of its coherent SI unit."""
    found = [known.symbol for known in UNITS if known.dimension == dimension]
    return found or [si_symbol(dimension)]


def usual_units(dimension: str) -> list[Unit]:
    """Return the listed units of a kind in which values are written, at least its SI unit."""
    found = [u for u in UNITS if u.dimension == dimension and u.symbol not in _CUSTOMARY]
    return found or [unit(si_symbol(dimension))]


def spellings_of(dimension: str | None) -> list[str]:
    """Return all spellings of units of a kind, or of any, without those of COMPOSED."""
    return [
        spelling for spelling, known in _BY_SPELLING.items() if dimension in (None, known.dimension)
    ]


def si_symbol(dimension: str) -> str:
    """Return the symbol of the coherent SI unit of a kind."""
    return _COHERENT.get(dimension, dimension)


def rate_of(dimension: str) -> str | None:
    """Return the kind of what a quantity changes by in a time; None for a level."""
    if dimension in _LEVELS:
        return None
    symbol = si_symbol(dimension)
    numerator, _, denominator = symbol.partition("/")
    parts = [part for part in (denominator.strip("()"), "s") if part]
    below = "·".join(parts)
    return unit(f"{numerator}/({below})" if len(parts) > 1 else f"{numerator}/s").dimension


def is_coherent(known: Unit) -> bool:
    """Say whether numbers in a unit are SI values."""
    return (known.factor, known.offset) == (1, 0)


def with_article(dimension: str) -> str:
    """Return a kind as a sentence has it: 'a torque', 'an angle', 'a quantity in V/K'."""
    if dimension not in _COHERENT:
        return f"a quantity in {dimension}"
    return f"{'an' if dimension[0] in 'aeiou' else 'a'} {dimension}"


def clip(text: str) -> str:
    """Return a text as a message has it, not too long."""
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 1]}…"


def _listing(dimension: str | None) -> str:
    if dimension:
        return f"units of {dimension}: {', '.join(units_of(dimension))}"
    common = ", ".join(known.symbol for known in UNITS)
    return f"known units, with prefixes, products and quotients: {common}"


def _powers(text: str) -> Iterator[tuple[str, int]]:
    """Yield each factor of a product or quotient with its power, as they stand."""
    above, _, below = text.partition("/")
    for part, sign in ((above, 1), (below, -1)):
        for name, power in _PART.findall(part):
            yield name, sign * _power(power)


def _power(text: str) -> int:
    if not text:
        return 1
    return int(text.lstrip("^").translate(_DIGITS))


@lru_cache(maxsize=1024)
def _composed(text: str) -> Unit | None:
    """Return the unit that a product or quotient is; None where a factor is no unit."""
    parts: list[tuple[Unit, int]] = []
    for name, power in _powers(text):
        known = _BY_SPELLING.get(name)
        if known is None:
            return None
        if known.dimension in _LEVELS:
            hint = "a level is a logarithm: write what it stands for"
            raise QuantityError(f"no unit is made of {known.symbol}, as in '{text}'", hint=hint)
        if known.offset:
            raise QuantityError(f"'{text}' has {known.symbol}, which has a zero of its own",
                                hint="differences of temperature are in K")  # fmt: skip
        parts.append((known, power))
    exact = Fraction(1)
    for known, power in parts:
        exact *= Fraction(repr(known.factor)) ** power
    factor = float(exact) if abs(exact) < _LARGEST_FACTOR else math.inf
    if not 1 / _LARGEST_FACTOR <= factor <= _LARGEST_FACTOR:
        raise QuantityError(f"'{text}' is too large or small a unit to be meant")
    symbol = _symbol((known.symbol, power) for known, power in parts)
    return _BY_SPELLING.get(symbol) or Unit(symbol, _kind(parts), factor)


def _symbol(parts: Iterable[tuple[str, int]]) -> str:
    """Return a product or quotient in one form: N·m²/(K·s)."""
    given = list(parts)
    above = [_raised(name, power) for name, power in given if power > 0]
    below = [_raised(name, -power) for name, power in given if power < 0]
    under = f"({'·'.join(below)})" if len(below) > 1 else "".join(below)
    return "/".join(each for each in ("·".join(above) or "1", under) if each)


def _raised(name: str, power: int) -> str:
    return name + (_SUPERSCRIPTS[power] if power > 1 else "")


def _kind(parts: Iterable[tuple[Unit, int]]) -> str:
    """Return the kind of a product: by its factors where that is agreed, else by its dimension."""
    powers: dict[str, int] = {}
    dimension = (0,) * len(_BASES)
    for known, power in parts:
        powers[known.dimension] = powers.get(known.dimension, 0) + power
        exponents = _exponents_of(known.dimension)
        dimension = tuple(a + power * b for a, b in zip(dimension, exponents, strict=True))
    agreed = frozenset((kind, power) for kind, power in powers.items())
    if agreed in _PRODUCTS:
        return _PRODUCTS[agreed]
    return _KIND_OF.get(dimension) or _shortest(dimension)


def _exponents_of(kind: str) -> Exponents:
    return _EXPONENTS[kind] if kind in _EXPONENTS else _exponents(kind)


def _exponents(text: str) -> Exponents:
    """Return the exponents of an expression in base units and coherent units with a name."""
    total = [0] * len(_BASES)
    for name, power in _powers(text):
        if name in _BASES:
            total[_BASES.index(name)] += power
        else:
            (expression,) = (base for _, symbol, base in _KINDS if symbol == name)
            for index, each in enumerate(_exponents(expression)):
                total[index] += power * each
    return tuple(total)


def _shortest(dimension: Exponents) -> str:
    """Return the coherent unit of a dimension without a name: a named one and base units."""
    named = [symbol for _, symbol, _ in _KINDS if symbol.isalpha() and symbol not in _BASES]
    candidates: list[tuple[tuple[int, int], str]] = []
    for symbol, sign in [("", 0), *((each, sign) for each in named for sign in (1, -1))]:
        exponents = _exponents(symbol) if symbol else dimension
        if symbol and _KIND_OF.get(exponents) != _KIND_BY_SYMBOL[symbol]:
            continue
        rest = tuple(a - sign * b for a, b in zip(dimension, exponents, strict=True))
        factors = [(symbol, sign)] * bool(symbol)
        factors += [(base, each) for base, each in zip(_BASES, rest, strict=True) if each]
        size = sum(abs(each) for _, each in factors)
        candidates.append(((len(factors), size), _symbol(factors)))
    return min(candidates, key=lambda each: each[0])[1]


def _all_spellings() -> dict[str, Unit]:
    found = {known.symbol: known for known in UNITS}
    for symbol, prefixes in _PREFIXED.items():
        base = found[symbol]
        for prefix in prefixes:
            name = f"{prefix}{symbol}"
            made = Unit(name, base.dimension, _FACTORS[prefix] * base.factor)
            found.setdefault(name, made)
    for name in [name for name in found if name.startswith("µ")]:
        found[f"u{name[1:]}"] = found[name]
    return found


_COHERENT = {name: symbol for name, symbol, _ in _KINDS}
_KIND_BY_SYMBOL = {symbol: name for name, symbol, _ in _KINDS}
_EXPONENTS = {name: _exponents(base) for name, _, base in _KINDS}
_KIND_OF = {exponents: name for name, exponents in _EXPONENTS.items() if name not in _BY_NAME_ALONE}
_BY_SPELLING: dict[str, Unit] = _all_spellings()
_BY_SPELLING.update({spelling: unit(symbol) for spelling, symbol in _SPELLINGS.items()})
