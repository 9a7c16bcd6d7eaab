"""What a unit means with an exception code, and what to do about it.

The codes are those of MODBUS Application Protocol Specification V1.1b3, clause 7.
"""

from __future__ import annotations

BUSY = 6
_UNKNOWN = ("an exception that the standard does not know", "see the instrument's manual")
_COUNTING = (
    "manuals often count registers from 1 or as 40001, the keys holding, input, coil and discrete"
    " from 0: `reference: 40003` takes a number as the manual has it"
)
_FUNCTION = (
    "the unit does not know this kind of request: is it a holding or an input register, and does it"
    " take `write: multiple` or `single`?"
)
_FAILURE = (
    "the unit failed while it did what was asked: see its display, its mode (local or remote), and"
    " whether the register may be written now"
)
_MEANINGS = {
    1: ("illegal function", _FUNCTION),
    2: ("illegal data address: it has no such register, or not that many together", _COUNTING),
    3: (
        "illegal data value",
        "the unit refuses the value: see the limits set in the unit itself, scale, type and order",
    ),
    4: ("device failure", _FAILURE),
    5: ("acknowledge: it needs long for this", "give it time, and see `timeout`"),
    BUSY: ("device busy", "it is occupied with something else: see `retries`"),
    8: ("memory parity error", "the unit needs repair"),
    10: ("gateway path unavailable", "see the settings of the gateway"),
    11: (
        "the gateway's target does not answer",
        "is the unit behind the gateway on, and is `unit_id` its address?",
    ),
}


def meaning(code: int) -> tuple[str, str]:
    """Return what an exception code says, and a hint."""
    said, hint = _MEANINGS.get(code, _UNKNOWN)
    return f"{said} (exception {code})", hint
