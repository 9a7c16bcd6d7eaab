"""The notes that are printed before a run starts."""

from __future__ import annotations

from unittest.mock import Mock

import pytest

from rigrunner.cli import attending
from rigrunner.engine import Interference
from rigrunner.run.locate import find_procedure, find_station
from rigrunner.run.planning import planned_run

REPEAT = (Interference("repeat test", "Ann", "customer asks", "entry 1 of the queue"),)


@pytest.mark.parametrize(
    ("specimen", "before", "is_noted"),
    [("demo-0001", (), True), ("demo-0001", REPEAT, False), ("DEMO-0002", (), False)],
)
def test_previously_tested_specimen_is_noted_and_the_run_starts(  # noqa: PLR0917  (fixtures)
    monkeypatch, capsys, demo, specimen, before, is_noted
):
    execute = Mock()
    monkeypatch.setattr(attending, "execute", execute)
    planned = planned_run(find_procedure("starting_torque_1000n"), find_station("simulated"))
    attending.attended_run(
        planned,
        {"specimen": specimen},
        runs=demo.folder,
        partners={},
        operator="Ann",
        unattended=True,
        person=Mock(),
        before=before,
    )
    execute.assert_called_once()
    note = f"note: demo-0001 has already been tested: run {demo.loaded.name}\n"
    assert capsys.readouterr().err == (note if is_noted else "")
