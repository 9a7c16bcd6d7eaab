from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime, timedelta, timezone
from typing import TYPE_CHECKING

import pytest

from rigrunner.clock import SimulatedClock, WallClock, utc_text

if TYPE_CHECKING:
    from rigrunner.api.devices import Clock

START = datetime(2026, 3, 1, 12, 0, tzinfo=UTC)


def test_simulated_time_passes_only_in_sleep():
    clock: Clock = SimulatedClock(START)
    assert clock.monotonic_s() == 0.0
    clock.sleep(3600.0)
    clock.sleep(0.5)
    assert clock.monotonic_s() == 3600.5
    assert clock.utc() == START + timedelta(seconds=3600.5)


@pytest.mark.parametrize("seconds", [-1e-9, float("nan"), float("inf")])
def test_invalid_sleep_of_simulated_clock_is_refused(seconds):
    clock = SimulatedClock(START)
    with pytest.raises(ValueError, match="cannot sleep"):
        clock.sleep(seconds)
    assert clock.utc() == START


def test_simulated_time_adds_up_across_threads():
    clock = SimulatedClock(START)
    with ThreadPoolExecutor(4) as pool:
        list(pool.map(lambda _: clock.sleep(0.25), range(4000)))
    assert clock.monotonic_s() == 1000.0


def test_start_in_another_zone_is_converted_to_utc():
    elsewhere = START.astimezone(timezone(timedelta(hours=9)))
    assert utc_text(SimulatedClock(elsewhere).utc()) == "2026-03-01T12:00:00.000Z"


def test_wall_clock_is_aware_and_monotonic():
    clock: Clock = WallClock()
    before_s, before = clock.monotonic_s(), datetime.now(UTC)
    clock.sleep(0.01)
    assert clock.monotonic_s() - before_s >= 0.009
    assert clock.utc() >= before
    assert clock.utc().utcoffset() == timedelta(0)


def test_utc_text_has_milliseconds_and_z():
    assert utc_text(datetime(2026, 1, 2, 3, 4, 5, 678901, tzinfo=UTC)) == "2026-01-02T03:04:05.678Z"


def test_utc_text_converts_other_zones():
    zone = timezone(timedelta(hours=5, minutes=30))
    assert utc_text(START.astimezone(zone)) == "2026-03-01T12:00:00.000Z"
