"""`rigrunner register`: entries of the register of instruments."""

from __future__ import annotations

from rigrunner.cli.lazy import lazy_group

SUMMARIES = {"from": "Make an entry of the laboratory's own calibration, a sealed run."}

command = lazy_group(
    "register",
    __name__,
    SUMMARIES,
    """Create entries for the register of instruments.

The entry is printed; copy it into the station.""",
)
