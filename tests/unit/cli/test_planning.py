from __future__ import annotations

import pytest

from rigrunner.api.hooks import DeviceRecord
from rigrunner.cli.planning import clock_for
from rigrunner.clock import SimulatedClock, WallClock
from rigrunner.registry import Plugin, Provider, Registry
from rigrunner.station import parse_station
from rigrunner.workflow.locate import find_station

STATION = find_station("simulated").read_text(encoding="utf-8")
REAL = "devices:\n  balance: {type: balance, plugin: real_balance}\n"


def record(name, *, simulated):
    def factory(settings, context):
        raise NotImplementedError

    made = DeviceRecord(name=name, help="", factory=factory, simulated=simulated)
    return Plugin("device", made, Provider("lab", ""))


REGISTRY = Registry(
    [record("swing_tester_sim", simulated=True), record("real_balance", simulated=False)]
)


@pytest.mark.parametrize(
    ("text", "realtime", "kind"),
    [
        (STATION, False, SimulatedClock),
        (STATION, True, WallClock),
        (STATION.replace("devices:\n", REAL), False, WallClock),
        (STATION.replace("swing_tester_sim", "no_such_plugin"), False, WallClock),
    ],
    ids=["simulated", "realtime", "one real device", "unknown plugin"],
)
def test_only_a_wholly_simulated_station_runs_in_simulated_time(text, realtime, kind):
    station = parse_station(text, "test").model
    assert isinstance(clock_for(station, REGISTRY, realtime=realtime), kind)
