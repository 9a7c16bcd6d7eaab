"""Tables of units: kinds of quantities, their coherent units, what else is common, and prefixes.

Sources of the factors: SI brochure, 9th edition, tables 2 to 8; NIST SP 811, B.8, for what is not
of the SI. All are exact but mmHg.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy import float64
    from numpy.typing import NDArray

_Number = TypeVar("_Number", float, "NDArray[float64]")


@dataclass(frozen=True)
class Unit:
    """A unit of measurement; SI value = number * factor + offset."""

    symbol: str
    dimension: str
    """The kind of quantity, such as 'torque'; of a kind without a name its coherent SI unit."""
    factor: float = 1.0
    offset: float = 0.0

    def to_si(self, number: _Number) -> _Number:
        """Convert numbers of this unit to SI."""
        return number * self.factor + self.offset

    def from_si(self, si: _Number) -> _Number:
        """Convert SI values to this unit."""
        return (si - self.offset) / self.factor


@dataclass(frozen=True)
class UnitDefinition:
    """A unit that a plugin adds; SI value = number * factor + offset."""

    symbol: str
    """Letters, °, %, µ, Ω, and digits after the first character; not a power of another unit."""
    kind: str
    """The kind of quantity, such as 'power'; for a new kind the unit with factor 1 is its SI unit.
    """
    base: str
    """Its coherent SI unit in kg, m, s, A, K, mol, cd and rad, such as 'kg·m²/s³'; or '1'."""
    factor: float = 1.0
    offset: float = 0.0
    spellings: tuple[str, ...] = ()
    """Alternative spellings."""
    logarithmic: bool = False
    """Whether the kind is a level: no products or quotients are made of it."""

    @property
    def unit(self) -> Unit:
        """The unit."""
        return Unit(self.symbol, self.kind, self.factor, self.offset)

    @property
    def is_coherent(self) -> bool:
        """Whether numbers in it are SI values."""
        return (self.factor, self.offset) == (1, 0)


_LBF = 4.4482216152605
"""In N: 0.45359237 kg times 9.80665 m/s², both exact."""
_INCH = 0.0254
_DEG = math.pi / 180

KINDS: tuple[tuple[str, str, str], ...] = (
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

BY_NAME_ALONE = {
    *("torque", "torque rate", "frequency", "frequency rate", "activity", "voltage ratio"),
    *("luminous flux", "illuminance", "absorbed dose", "dose equivalent", "level", "power level"),
    "pH",
}
"""Kinds that share a dimension with another: a product or quotient is of these by its factors only.
"""
LEVELS = {"level", "power level", "pH"}
"""Logarithmic kinds, of which no products or quotients are made."""

PRODUCTS: Mapping[frozenset[tuple[str, int]], str] = {
    frozenset({("force", 1), ("length", 1)}): "torque",
    frozenset({("force", 1), ("length", 1), ("time", -1)}): "torque rate",
    frozenset({("torque", 1), ("time", -1)}): "torque rate",
    frozenset({("frequency", 1), ("time", -1)}): "frequency rate",
    frozenset({("luminous flux", 1), ("area", -1)}): "illuminance",
    frozenset({("luminous flux", 1), ("length", -2)}): "illuminance",
    frozenset({("voltage", 0)}): "voltage ratio",  # V/V: the powers add up to 0
}
"""Kind of a product by the kinds of its factors, each with its power."""

UNITS: tuple[Unit, ...] = (
    Unit("N·m", "torque"),
    Unit("mN·m", "torque", 1e-3),
    Unit("in·lbf", "torque", 0.1129848290276167),  # 0.0254 m by 4.4482216152605 N
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
    Unit("arcmin", "angle", _DEG / 60),
    Unit("arcsec", "angle", _DEG / 3600),
    Unit("rev", "angle", 2 * math.pi),
    Unit("s", "time"),
    Unit("ms", "time", 1e-3),
    Unit("min", "time", 60.0),
    Unit("h", "time", 3600.0),
    Unit("d", "time", 86400.0),
    Unit("m", "length"),
    Unit("mm", "length", 1e-3),
    Unit("µm", "length", 1e-6),
    Unit("Å", "length", 1e-10),
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
"""Units in messages and pages; prefixes, products and quotients make more."""

CUSTOMARY = {
    *("lbf", "kgf", "in", "ft", "Å", "lb", "°F", "psi", "atm", "Torr", "mmHg", "rev", "eV"),
    *("t", "ppm", "ppb", "cP", "cSt", "bar/min", "mbar"),
}
"""Accepted, but not suggested and used only if a person wrote it so."""

FACTORS = {
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
PREFIXED = {
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
"""Prefixes that a unit accepts; pH is no picohenry."""

SPELLINGS = {
    "Nm": "N·m", "N m": "N·m", "mNm": "mN·m", "kNm": "kN·m",
    "in-lb": "in·lbf", "in-lbf": "in·lbf", "in·lb": "in·lbf", "ft-lb": "ft·lbf", "lb-ft": "ft·lbf",
    "°": "deg", "degC": "°C", "degF": "°F", "kg m2": "kg·m²", "r/min": "rpm", "rev/min": "rpm",
    "Wh": "W·h", "kWh": "kW·h", "Ah": "A·h", "mAh": "mA·h", "l": "L", "ml": "mL", "l/min": "L/min",
    "Ohm": "Ω", "ohm": "Ω", "kOhm": "kΩ", "kohm": "kΩ", "MOhm": "MΩ", "Mohm": "MΩ", "mOhm": "mΩ",
    "mohm": "mΩ", "angstrom": "Å", "Angstrom": "Å",
}  # fmt: skip

MEANT = {
    "M": "mol/L", "mM": "mmol/L", "µM": "µmol/L", "uM": "µmol/L", "nM": "nmol/L",
    "RH": "%", "%RH": "%", "% RH": "%", "%rh": "%", "% rh": "%",
}  # fmt: skip
"""What is suggested for what is no unit: M is the prefix mega, and a relative humidity a ratio."""
