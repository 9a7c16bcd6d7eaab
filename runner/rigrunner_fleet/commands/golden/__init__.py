"""`rigrunner golden`: compare new software with references, on stored raw data."""

from __future__ import annotations

from rigrunner.cli.lazy import lazy_group

SUMMARIES = {
    "record": "Record the results of runs as the reference.",
    "check": "Analyse golden runs again, and list differences.",
}

command = lazy_group(
    "golden",
    __name__,
    SUMMARIES,
    """Regression-test new software against reference runs.

Run files do not change.""",
)
