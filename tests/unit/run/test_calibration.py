"""A missing or overdue calibration, or one of a too narrow range, prevents a run."""

from __future__ import annotations

import threading
from dataclasses import replace

import pytest

from helpers_any_quantity import written
from helpers_language import problems_of
from helpers_thorough import first
from helpers_workflow import START, quick_procedure, station_file
from rigrunner.api.errors import InvalidFileError, UsageError
from rigrunner.api.events import Intervention
from rigrunner.clock import SimulatedClock
from rigrunner.engine import UnattendedAnswers
from rigrunner.registry import load_registry
from rigrunner.run.calibration import calibration_findings, entering_channels
from rigrunner.run.inputs import answer_inputs
from rigrunner.run.locate import find_procedure
from rigrunner.run.overrides import overrides_for
from rigrunner.run.prepare import plan_run
from rigrunner.run.record import execute
from rigrunner.runfile import read

BENCH_PLUGIN = """
from dataclasses import replace

from rigrunner.api.hooks import hookimpl
from rigrunner_bearings import hooks

api_version = 1


@hookimpl
def rigrunner_devices():
    sim = next(record for record in hooks.rigrunner_devices() if record.name == "swing_tester_sim")
    return [replace(sim, name="bench_tester", simulated=False)]
"""
TORQUE = """
    id: TQ-7
    certificate: D-K-1
    laboratory: A lab
    calibrated: 2025-06-01
    due: 2026-06-01
"""
OTHERS = """
  - channel: tester.angle
    measures: angle
    serial: A-1
    certificate: D-K-2
    due: 2026-06-01
    range: {min: -5 deg, max: 5 deg}
    accuracy: 0.01 deg
  - channel: tester.load
    measures: force
    id: LC-3
    serial: L-1
    certificate: D-K-3
    due: 2026-06-01
    range: {min: 100 N, max: 5 kN}
    accuracy: 0.1 % FS
"""


def bench(folder, *changes):
    """Write a station with a real tester and calibrated instruments, with changes."""
    (folder / "lab").mkdir(exist_ok=True)
    (folder / "lab" / "bench.py").write_text(BENCH_PLUGIN)
    path = station_file(
        folder,
        ("id: simulated\n", "id: bench\nplugins: lab\n"),
        ("plugin: swing_tester_sim", "plugin: bench_tester"),
    )
    lines = path.read_text(encoding="utf-8").rstrip().splitlines()
    base = "\n".join(line for line in lines if not line.strip().startswith("calibration:"))
    text = base.replace("\n    serial: SIM-TQ-01", f"\n    serial: T-1{TORQUE.rstrip()}") + OTHERS
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new)
    path.write_text(text, encoding="utf-8")
    return path


def planned(folder, station, name="starting_torque_1000n", *changes):
    """Plan a shipped procedure in its quick form on that station, on the day of START."""
    procedure = quick_procedure(folder, name, *changes)
    return plan_run(procedure, station, load_registry(), SimulatedClock(START))


# change of the register, what is lacking, message, field
CASES = {
    "overdue": (
        ("due: 2026-06-01\n    full_scale", "due: 2026-02-28\n    full_scale"),
        "overdue", "the calibration of TQ-7 (tester.torque) was due on 2026-02-28, 1 day before",
        "instruments[0].due",
    ),
    "no due date": (
        ("    due: 2026-06-01\n    full_scale", "    full_scale"),
        "missing", "TQ-7 (tester.torque) has no due", "instruments[0]",
    ),
    "no certificate": (
        ("    certificate: D-K-2\n    due: 2026-06-01\n", ""),
        "missing", "A-1 (tester.angle) has no certificate and no due", "instruments[1]",
    ),
    "not in the register": (
        (OTHERS[OTHERS.index("  - channel: tester.load") :], ""),
        "missing", "there is no instrument for tester.load, whose value enters the result",
        "instruments",
    ),
    "entered as simulated": (
        ("    due: 2026-06-01\n    full_scale", "    calibration: simulated\n    full_scale"),
        "missing",
        "TQ-7 (tester.torque) is entered as simulated, but what 'bench_tester' gives was measured",
        "instruments[0].calibration",
    ),
    "calibrated tomorrow": (
        ("calibrated: 2025-06-01", "calibrated: 2026-03-02"),
        "missing", "was calibrated on 2026-03-02, after this run",
        "instruments[0].calibrated",
    ),
    "torque beyond": (
        ("full_scale: 10 N·m", "full_scale: 10 N·m\n    range: {max: 5 N·m}"),
        "range", "is calibrated from -5 N·m to 5 N·m, but recording", "instruments[0].range",
    ),
    "one direction only": (
        ("full_scale: 10 N·m", "full_scale: 10 N·m\n    range: {min: 0 N·m, max: 10 N·m}"),
        "range", "is calibrated from 0 N·m to 10 N·m, but recording", "instruments[0].range",
    ),
    "load below": (
        ("min: 100 N", "min: 1500 N"),
        "range", "(tester.load) is calibrated from 1500 N to 5 kN, but tester.load is set to 1 kN",
        "instruments[2].range",
    ),
    "swing beyond": (
        ("{min: -5 deg, max: 5 deg}", "{min: -2 deg, max: 2 deg}"),
        "range", "A-1 (tester.angle) is calibrated from -2 deg to 2 deg, but the swing goes to",
        "instruments[1].range",
    ),
    "no range": (
        ("    range: {min: 100 N, max: 5 kN}\n", ""),
        "range", "LC-3 (tester.load) has no calibrated range", "instruments[2]",
    ),
}  # fmt: skip


def test_channels_of_torque_analysis_enter_result(tmp_path):
    plan = planned(tmp_path, bench(tmp_path))
    assert set(entering_channels(plan)) == {"tester.angle", "tester.torque", "tester.load"}


@pytest.mark.parametrize(
    ("limits", "entering"),
    [
        ("", {"bench.voltage"}),
        (", limits: {bench.ripple: {max: 20 mV}}", {"bench.voltage", "bench.ripple"}),
    ],
)
def test_channels_that_are_analysed_or_have_limits_enter_result(tmp_path, limits, entering):
    channels = "{channels: [bench.voltage, bench.ripple]"
    files = written(tmp_path, (channels, channels + limits))
    plan = plan_run(*files, load_registry(), SimulatedClock())
    assert set(entering_channels(plan)) == entering


def test_calibrated_instruments_have_no_findings(tmp_path):
    assert calibration_findings(planned(tmp_path, bench(tmp_path))) == ()


def test_instrument_is_valid_on_its_due_date(tmp_path):
    station = bench(tmp_path, ("due: 2026-06-01", "due: 2026-03-01"))
    assert calibration_findings(planned(tmp_path, station)) == ()


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_deficient_calibration_is_reported(tmp_path, case):
    change, lack, message, field = case
    (finding,) = calibration_findings(planned(tmp_path, bench(tmp_path, change)))
    assert finding.lack == lack
    assert message in finding.problem.message
    assert finding.problem.field == field
    assert finding.problem.location.file == str(tmp_path / "station.yaml")
    assert "or start with --override" in finding.problem.hint


def scanning(over, channels):
    scan = f"main:\n  - scan: {{set: tester.load, over: {over}, channels: {channels}}}\n"
    return "\nmain:\n", f"\n{scan}"


@pytest.mark.parametrize(
    ("over", "beyond"),
    [("[200 N, 50 N, 5 kN]", "50 N"), ("[200 N, 0 N, 2 kN]", ""), ("[99 N]", "99 N")],
)
def test_every_set_point_of_scan_must_be_in_range(tmp_path, over, beyond):
    station = bench(tmp_path, ("{seed: 1}", "{seed: 1, max_load: 5 kN}"))
    change = scanning(over, "[tester.temperature]")
    findings = calibration_findings(planned(tmp_path, station, "starting_torque_1000n", change))
    message = f"(tester.load) is calibrated from 100 N to 5 kN, but tester.load is set to {beyond}"
    assert [message in finding.problem.message for finding in findings] == [True] * bool(beyond)


def test_scanned_channels_enter_result_without_analysis(tmp_path):
    analysed = planned(tmp_path, bench(tmp_path))
    text = find_procedure("starting_torque_1000n").read_text(encoding="utf-8")
    no_analysis = (text[text.index("\nanalysis:") :], "\n")
    scan = scanning("[1 kN]", "[tester.load, tester.temperature]")
    plain = planned(tmp_path, bench(tmp_path), "starting_torque_1000n", scan, no_analysis)
    assert "tester.temperature" in entering_channels(plain)
    assert "tester.temperature" not in entering_channels(analysed)
    (finding,) = calibration_findings(plain)
    assert "there is no instrument for tester.temperature" in finding.problem.message


def test_trial_instrument_needs_no_calibration(tmp_path):
    certificate = "    certificate: D-K-2\n    due: 2026-06-01\n"
    trial = bench(tmp_path, (certificate, "    calibration: trial\n"))
    assert calibration_findings(planned(tmp_path, trial)) == ()


def test_simulated_device_needs_no_instruments(tmp_path):
    station = bench(tmp_path, ("plugin: bench_tester", "plugin: swing_tester_sim"))
    text = station.read_text(encoding="utf-8")
    station.write_text(text[: text.index("  - channel: tester.angle")], encoding="utf-8")
    assert calibration_findings(planned(tmp_path, station)) == ()


def test_instruments_of_simulated_device_are_checked(tmp_path):
    changes = ("plugin: bench_tester", "plugin: swing_tester_sim"), ("2026-06-01", "2026-02-01")
    findings = calibration_findings(planned(tmp_path, bench(tmp_path, *changes)))
    assert [(finding.lack, finding.channel) for finding in findings] == [
        ("overdue", "tester.torque"),
        ("overdue", "tester.angle"),
        ("overdue", "tester.load"),
    ]


def test_calibration_must_be_valid_until_end_of_run(tmp_path):
    """The run starts on the last valid day, and is planned to last beyond midnight."""
    day = START.replace(year=2026, month=6, day=1, hour=0, minute=1)
    plan = planned(tmp_path, bench(tmp_path))
    for hour, problems in ((12, 0), (23, 3)):
        clock = SimulatedClock(day.replace(hour=hour, minute=59, second=58))
        findings = calibration_findings(replace(plan, clock=clock))
        assert len(findings) == problems
    assert {finding.lack for finding in findings} == {"overdue"}
    message = findings[0].problem.message
    assert message == (
        "the calibration of TQ-7 (tester.torque) is due on 2026-06-01, and this run may last until"
        " 2026-06-02"
    )


def run_plan(plan, runs, overrides=(), partners=None):
    answers = UnattendedAnswers()
    inputs = answer_inputs(plan.procedure, {}, answers)
    stop = threading.Event()
    return execute(
        plan, runs=runs, inputs=inputs, partners=partners or {}, answers=answers, stop=stop,
        operator="B. Lee", overrides=overrides,
    )  # fmt: skip


def overdue(tmp_path):
    station = bench(tmp_path, ("due: 2026-06-01", "due: 2026-02-01"))
    return planned(tmp_path, station, "no_load_inertia_sweep")


def test_calibration_is_checked_before_connecting(tmp_path):
    with pytest.raises(InvalidFileError) as caught:
        run_plan(overdue(tmp_path), tmp_path / "runs")
    assert len(caught.value.problems) == 3
    assert not (tmp_path / "runs").exists()


@pytest.mark.parametrize(
    "names",
    first(1, [["T-1", "tester.angle", "L-1"], ["overdue"], ["tester.torque", "A-1", "LC-3"]]),
)
def test_overrides_are_in_run_file_and_report(tmp_path, names):
    plan = overdue(tmp_path)
    overrides = overrides_for(plan, names, "A. Jones", "Certificates are on their way")
    finished = run_plan(plan, tmp_path / "runs", overrides)

    stored = read(finished.folder)
    events = [event for event in stored.events if isinstance(event, Intervention)]
    assert [(event.action, event.by) for event in events] == [("override", "A. Jones")] * 3
    assert {event.reason for event in events} == {"Certificates are on their way"}
    assert any("TQ-7 (tester.torque) was due on 2026-02-01" in event.subject for event in events)
    assert stored.header.people == {"operator": "B. Lee"}
    report = finished.report.read_text(encoding="utf-8")
    assert report.count("Deviation:") == 3
    assert "OVERDUE at this run" in report
    assert finished.result.run.people == {"operator": "B. Lee"}


@pytest.mark.thorough
def test_report_lists_overrides_of_no_load_run(tmp_path):
    plan = overdue(tmp_path)
    overrides = overrides_for(plan, ["TQ-7", "A-1", "LC-3"], "A. Jones", "why")
    no_load = run_plan(plan, tmp_path / "runs", overrides)
    loaded = planned(tmp_path, bench(tmp_path))
    finished = run_plan(loaded, tmp_path / "runs", partners={"no_load": no_load.folder})

    report = finished.report.read_text(encoding="utf-8")
    assert report.count("Deviation:</strong> no-load run: override by A. Jones") == 3
    assert "<dd>B. Lee</dd>" in report


@pytest.mark.parametrize(
    ("names", "by", "reason", "message"),
    [
        (["overdue"], "", "", "needs --by NAME and --reason TEXT"),
        (["overdue"], "A. Jones", "  ", "needs --reason TEXT"),
        (["overdue"], " ", "why", "needs --by NAME"),
        ([], "A. Jones", "", "need --override"),
        (["overdue", "range"], "A. Jones", "why", "'--override range' matches nothing"),
        (["TQ-8"], "A. Jones", "why", "'--override TQ-8' matches nothing"),
    ],
)
def test_invalid_override_is_refused(tmp_path, names, by, reason, message):
    with pytest.raises(UsageError, match=message):
        overrides_for(overdue(tmp_path), names, by, reason)


def test_remaining_problems_are_reported_despite_overrides(tmp_path):
    problems = problems_of(overrides_for, overdue(tmp_path), ["TQ-7", "LC-3"], "A. Jones", "why")
    assert [problem.field for problem in problems] == ["instruments[1].due"]
