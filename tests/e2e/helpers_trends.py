"""Archives of many runs with synthetic results."""

from __future__ import annotations

from contextlib import closing
from datetime import UTC, datetime, timedelta

from rigrunner_fleet.archive import index, open_archive
from unit.rigrunner_fleet.archive.helpers_archive import estimate, result_document, store_run

FIRST_DAY = datetime(2026, 1, 1, 12, tzinfo=UTC)


def store_results(runs, torques, *, frequencies=None, recordings=0, **inputs):
    """Store a run a day, each with its torque in N·m and its natural frequency in Hz."""
    for day, torque in enumerate(torques):
        document = result_document(torque)
        document["no_load_run"] = {"id": f"no-load {day}"}
        figures = document["compensations"]["template_inverse"]["parameters"]
        figures["inertia"] = estimate(0.00232 + 1e-7 * (7 * (day + 1) % 13), 1e-6, "kg·m²")
        if frequencies is not None:
            figures["natural frequency"] = estimate(frequencies[day], 0.07, "Hz")
        store_run(
            runs, f"day-{day:02d}", document, started_utc=on_day(day), recordings=recordings,
            inputs={"specimen": f"SN-{day}", "type": "GE20", "lot": "L1", **inputs},
        )  # fmt: skip


def on_day(day):
    return (FIRST_DAY + timedelta(days=day)).strftime("%Y-%m-%dT%H:%M:%S.000Z")


def index_all(runs):
    with closing(open_archive(runs)) as archive:
        index(archive, [runs])
