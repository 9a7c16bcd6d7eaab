"""What a unit means with an exception code, and what to do about it.

The codes are those of MODBUS Application Protocol Specification V1.1b3, clause 7.
"""

from __future__ import annotations

from rigrunner_plugins.devices.modbus.places import Table

ILLEGAL_FUNCTION, ILLEGAL_ADDRESS, BUSY = 1, 2, 6
NO_IDENTIFICATION = "if it does not support function 43 / 14, leave `standard` out"
_DIGITS = 4
"""Of a register behind the digit of its table; more where they do not suffice."""
_UNKNOWN = ("an exception that is not in the standard", "see the instrument's manual")
_FUNCTION = (
    "the unit does not support this kind of request: is it a holding or an input register, and"
    " does it accept `write: multiple` or `single`?"
)
_FAILURE = (
    "the unit failed to execute the request: see its display, its mode (local or remote), and"
    " whether the register may be written now"
)
_MEANINGS = {
    ILLEGAL_FUNCTION: ("illegal function", _FUNCTION),
    ILLEGAL_ADDRESS: (
        "illegal data address: it has no such register, or not that many together",
        "see the manual's list of registers",
    ),
    3: (
        "illegal data value",
        "the unit refuses the value: see the limits set in the unit itself, scale, type and order",
    ),
    4: ("device failure", _FAILURE),
    5: ("acknowledge: it needs more time for this", "increase `timeout`"),
    BUSY: ("device busy", "it is busy: see `retries`"),
    8: ("memory parity error", "the unit needs repair"),
    10: ("gateway path unavailable", "see the settings of the gateway"),
    11: (
        "the gateway's target does not answer",
        "is the unit behind the gateway on, and is `unit_id` its address?",
    ),
}


def counted(table: Table, address: int) -> str:
    """Return a hint on how an address is counted, where it was copied from a manual."""
    digit = {Table.DISCRETE: "1", Table.INPUT: "3", Table.HOLDING: "4"}.get(table, "")
    reference = f", or {digit}{address + 1:0{_DIGITS}}" if digit else ""
    return (
        f"addresses count from 0: {table} {address} is number {address + 1} of manuals that count"
        f" from 1{reference}; a number such as 40001 is written as `reference: 40001`"
    )


def meaning(code: int) -> tuple[str, str]:
    """Return what an exception code says, and a hint."""
    said, hint = _MEANINGS.get(code, _UNKNOWN)
    return f"{said} (exception {code})", hint
