"""Units as nodes have them in their property EngineeringUnits (OPC 10000-8, clause 5.6.4.3).

Its UnitId is made of the characters of the common code of UNECE Recommendation 20, each one byte,
the first the highest.
"""

from __future__ import annotations

from rigrunner.api import QuantityError, unit

UNECE = "http://www.opcfoundation.org/UA/units/un/cefact"
_CODES = {
    "NU": "N·m",
    "D83": "mN·m",
    "NEW": "N",
    "B47": "kN",
    "HTZ": "Hz",
    "KHZ": "kHz",
    "RPM": "rpm",
    "C81": "rad",
    "C25": "mrad",
    "DD": "deg",
    "SEC": "s",
    "C26": "ms",
    "MIN": "min",
    "HUR": "h",
    "DAY": "d",
    "MTR": "m",
    "MMT": "mm",
    "4H": "µm",
    "C62": "1",
    "P1": "%",
    "KEL": "K",
    "CEL": "°C",
    "VLT": "V",
    "2Z": "mV",
    "AMP": "A",
    "4K": "mA",
    "KGM": "kg",
    "GRM": "g",
    "2A": "rad/s",
    "MTS": "m/s",
}


def unit_id(code: str) -> int:
    """Return the UnitId of a common code."""
    return int.from_bytes(code.encode("ascii"), "big")


_BY_ID = {unit_id(code): symbol for code, symbol in _CODES.items()}


def symbol_of(namespace: str | None, number: int, text: str | None) -> str:
    """Return the symbol of our unit that is meant, or nothing if it is none that is known."""
    if namespace == UNECE and number in _BY_ID:
        return _BY_ID[number]
    try:
        return unit(text or "").symbol
    except QuantityError:
        return ""
