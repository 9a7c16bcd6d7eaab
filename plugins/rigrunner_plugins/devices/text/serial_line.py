"""The settings of a serial line."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from rigrunner.api import Settings


class SerialLine(Settings):
    """How characters are sent over a serial line; both ends have to agree."""

    baud: Annotated[int, Field(ge=50, le=4_000_000)] = 9600
    """Bits per second."""
    data_bits: Literal[5, 6, 7, 8] = 8
    """Bits per character."""
    parity: Literal["none", "even", "odd", "mark", "space"] = "none"
    """Parity."""
    stop_bits: Literal[1, 2] = 1
    """Number of stop bits."""
    flow_control: Literal["none", "xon_xoff", "rts_cts"] = "none"
    """Flow control."""
