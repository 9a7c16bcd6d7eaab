"""Register, approval and comparison by the command line, with their exact messages."""

from __future__ import annotations

import json
import shutil
from datetime import UTC, datetime, timedelta

import pytest

from helpers_cli import call
from rigrunner.api.errors import ExitCode
from rigrunner.run.locate import find_procedure
from rigrunner.runfile import read

ENTRY = """
  - channel: room.temperature
    measures: temperature
    id: TH-4
    serial: "9"
    certificate: K-1
    due: {due}
    range: {{min: 10 °C, max: 40 °C}}
"""


@pytest.fixture
def lab(tmp_path):
    """A lab folder whose thermometer counts as real, and whose calibration was due yesterday."""
    folder = tmp_path / "lab"
    assert call("init", folder).code == ExitCode.PASS
    plugin = folder / "plugins" / "room_thermometer.py"
    text = plugin.read_text(encoding="utf-8")
    real = text.replace("            simulated=True,\n", "")
    assert real != text
    plugin.write_text(real, encoding="utf-8")
    yesterday = (datetime.now(UTC) - timedelta(days=1)).date().isoformat()
    with (folder / "station.yaml").open("a", encoding="utf-8") as file:
        file.write(ENTRY.format(due=yesterday).lstrip("\n"))
    return folder, yesterday


def measure(folder, *options):
    return call(
        "run",
        folder / "procedures" / "room_temperature.yaml",
        *("--station", folder / "station.yaml", "--unattended", "--runs", folder / "runs"),
        *options,
    )


def test_overdue_calibration_is_refused_with_its_place_and_a_hint(lab):
    folder, yesterday = lab
    station = folder / "station.yaml"
    line = station.read_text(encoding="utf-8").splitlines().index(f"    due: {yesterday}") + 1
    expected = (
        f"{station}:{line}:10: error: instruments[1].due: the calibration of TH-4"
        f" (room.temperature) was due on {yesterday}, 1 day before this run\n"
        "  hint: have it calibrated and enter the new certificate;"
        " or start with --override TH-4 --by NAME --reason TEXT\n"
    )
    for called in (
        measure(folder),
        call("check", folder / "procedures" / "room_temperature.yaml", "--station", station),
    ):
        assert called.code == ExitCode.INVALID
        assert called.err == expected
    assert not (folder / "runs").exists()


def test_overdue_calibration_can_be_overridden_on_record(lab):
    folder, _ = lab
    called = measure(
        folder, "--override", "TH-4", "--by", "A. Jones", "--reason", "sent in", "--operator", "Lee"
    )  # fmt: skip
    assert called.code == ExitCode.PASS
    assert "ROOM is a draft, not for certification" in called.err
    assert "override by A. Jones: the calibration of TH-4" in called.err
    (stored,) = map(read, (folder / "runs").iterdir())
    assert stored.header.people == {"operator": "Lee"}
    assert stored.header.approval["state"] == "draft"


def test_edit_ends_an_approval(lab):
    folder, _ = lab
    procedure = folder / "procedures" / "room_temperature.yaml"
    day = "2026-01-02"
    assert call("approve", procedure, "--show").out == (
        "ROOM, revision 1: draft, not for certification\n"
    )
    approved = call("approve", procedure, "--by", "A. Jones", "--date", day)
    assert approved.out == f"ROOM, revision 1: approved by A. Jones on {day}\n"
    text = procedure.read_text(encoding="utf-8")
    procedure.write_text(text.replace("Temperature of the room", "A room"), encoding="utf-8")
    assert call("approve", procedure, "--show").out == (
        "ROOM, revision 1: draft, not for certification: the procedure was changed after its"
        f" approval by A. Jones on {day}\n"
    )
    assert "changed after its approval" in call("check", procedure).out


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ([], "name the approver with --by, or give --show"),
        (["--by", "X", "--show"], "name the approver with --by, or give --show"),
        (["--by", " "], "an approval needs a name"),
        (["--by", "X", "--date", "2999-01-01"], "2999-01-01 is in the future"),
        (["--by", "X", "--date", "tomorrow"], "does not match the format"),
    ],
)
def test_invalid_approval_is_refused(lab, options, message):
    folder, _ = lab
    called = call("approve", folder / "procedures" / "room_temperature.yaml", *options)
    assert called.code == ExitCode.USAGE
    assert message in called.err
    assert not list((folder / "procedures").glob("*.approval.json"))


def test_two_operators_are_refused():
    words = ("--station", "simulated", "--unattended", "--set", "operator=A", "--operator", "B")
    called = call("run", "no_load_inertia_sweep", *words)
    assert called.code == ExitCode.USAGE
    assert "two operators are given: 'A' and 'B'" in called.err


def test_difference_is_printed_and_exits_with_1(tmp_path):
    shipped = find_procedure("starting_torque_1000n")
    other = tmp_path / "other.yaml"
    shutil.copyfile(shipped, other)
    assert call("compare", shipped, other).code == ExitCode.PASS
    text = other.read_text(encoding="utf-8").replace("max: 0.95 N·m", "max: 0.90 N·m")
    other.write_text(text, encoding="utf-8")
    called = call("compare", shipped, other)
    assert called.code == ExitCode.FAIL
    assert called.out.splitlines()[3:] == [
        "acceptance",
        "  limits 1 > max was lowered from 0.95 N·m to 0.9 N·m",
        "",
        "1 difference",
    ]
    comparison = json.loads(call("compare", shipped, other, "--json").out)
    assert comparison["same"] is False
    assert [change["section"] for change in comparison["changes"]] == ["acceptance"]


def test_two_runs_of_the_demo_differ_in_their_procedure(demo):
    called = call("compare", demo.no_load, demo.loaded)
    assert called.code == ExitCode.FAIL
    assert "id was changed from 'SSPB-NLI' to 'SSPB-STT-1000'" in called.out
    same = call("compare", demo.loaded, demo.loaded.name, "--runs", demo.folder)
    assert (same.code, same.out.splitlines()[-1]) == (ExitCode.PASS, "no relevant difference")
