"""The next specimen of the queue starts automatically only where the procedure allows it."""

from __future__ import annotations

import time

import pytest

from e2e.helpers_panel import Screen, served
from helpers_cli import call

PROCEDURE = """\
rigrunner: procedure/2
id: FOLLOWING
revision: "A"
title: Runs that follow each other
automatic_start: yes

inputs:
  specimen: {ask: Serial number, unattended: X}

uses: {tester: swing_tester}

main:
  - set: {tester.frequency: 20 Hz}
  - settle: {cycles: 2}
  - record: {channels: [tester.angle, tester.torque], cycles: 5}

teardown:
  - set: {tester.frequency: 0 Hz}
"""


def statuses(screen):
    return [entry["status"] for entry in screen.state["queue"]["entries"]]


@pytest.mark.thorough
def test_automatic_start_runs_two_specimens_and_leaves_the_third_waiting(tmp_path):
    lab = tmp_path / "lab"
    assert call("init", lab).code == 0
    (lab / "following.yaml").write_text(PROCEDURE, encoding="utf-8")
    asked = PROCEDURE.replace("automatic_start: yes\n", "").replace("id: FOLLOWING", "id: ASKED")
    (lab / "asked.yaml").write_text(asked, encoding="utf-8")
    with served(lab, tmp_path / "runs") as server:
        screen = Screen(server, "client-ann-1")
        screen.post("control", name="Ann")
        common = {"station": "station.yaml", "realtime": False}
        screen.post("queue/add", procedure="following.yaml", list="SN-1\nSN-2", **common)
        screen.post("queue/add", procedure="asked.yaml", list="SN-3", **common)
        time.sleep(2.5)
        assert statuses(screen) == ["waiting"] * 3, "nobody has allowed it yet"
        screen.post("queue/automatic", on=True)
        screen.until(lambda _: statuses(screen)[:2] == ["done", "done"])
        runs = [entry["run"] for entry in screen.state["queue"]["entries"]]
        assert len({*runs[:2]}) == 2
        time.sleep(2.5)
        assert statuses(screen)[2] == "waiting", "its procedure does not allow it"
        items = screen.http.get("/api/v1/runs").json()["items"]
        assert sorted(item["specimen"] for item in items) == ["SN-1", "SN-2"]
        screen.close()
