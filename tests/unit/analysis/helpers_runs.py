"""A run without recordings, for tests that bring their own data."""

from __future__ import annotations

from dataclasses import replace

from rigrunner.api.data import RunData


def run_of(*recordings, **changes) -> RunData:
    """Return a completed run of some recordings, with changes."""
    run = RunData(
        run_id="run-1",
        procedure_id="SSPB-STT-1000",
        procedure_revision="A",
        procedure_title="Starting torque",
        station_id="simulated",
        started_utc="2026-01-01T12:00:00+00:00",
        ended_utc="2026-01-01T13:00:00+00:00",
        outcome="completed",
        inputs={"specimen": "DEMO-0001"},
        instruments={},
        zeros={},
        recordings=recordings,
        digest="ab" * 32,
    )
    return replace(run, **changes)
