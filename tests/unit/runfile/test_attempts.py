"""Repeated steps: every attempt is kept, the last completed one counts."""

from __future__ import annotations

import h5py
import pytest

from rigrunner.api.data import ZeroReading
from rigrunner.api.errors import DataError
from rigrunner.api.events import Outcome, RunEnded, RunStarted, Scanned, StepEnded, StepStarted
from rigrunner.api.limits import ValueLimit
from rigrunner.runfile import RunWriter, read, read_info, seal, stored_events
from rigrunner.runfile.attempts import superseded
from rigrunner.runfile.stored_events import StoredEvents
from unit.runfile.helpers_runfile import (
    assert_same_recording,
    emitter_of,
    end_recording,
    header_of,
    recording,
    send_samples,
    start_recording,
)


def write_attempts(folder, attempts, measured=()):
    """Write a run of one step with several attempts: (name, ok) of each."""
    with RunWriter(folder, header_of(folder.name)) as writer:
        emit = emitter_of(writer)
        emit(RunStarted, run_id=folder.name, steps=2, estimated_s=1.0)
        for number, (name, ok) in enumerate(attempts):
            original = recording(name, seed=number)
            start_recording(emit, original, 7)
            send_samples(emit, original, 1000)
            end_recording(emit, original, 7, ok=ok)
        for value in measured:
            emit(
                StepEnded, step="main[1]", index=8, action="measure", ok=True, measurement="table",
                setpoints={}, values={"tester.load": value}, units={"tester.load": "N"},
            )  # fmt: skip
        emit(RunEnded, outcome=Outcome.COMPLETED)
    return folder


def test_sealed_rows_can_be_checked_without_keeping_them(tmp_path):
    folder = write_attempts(tmp_path / "run", [("a", True), ("b", True)], measured=[1.0, 2.0, 3.0])
    seal(folder)
    stored = read(folder)
    assert read_info(folder) == stored.info
    # The digest of the file is over the rows: with one more it would be another.
    seal(write_attempts(tmp_path / "other", [("a", True), ("b", True)], measured=[1.0, 2.0, 3.5]))
    assert read_info(tmp_path / "other").digest != stored.digest


def test_rows_that_differ_from_their_digest_are_refused(tmp_path, monkeypatch):
    folder = write_attempts(tmp_path / "run", [("a", True)], measured=[1.0, 2.0])
    seal(folder)
    monkeypatch.setattr(stored_events, "measurement_digest", lambda *_, **__: 64 * "0")
    with pytest.raises(DataError, match="SHA-256 over all differs"):
        read_info(folder)


@pytest.mark.parametrize("sealed", [False, True])
@pytest.mark.parametrize(
    ("attempts", "counts", "former", "broken"),
    [
        ([("a", True), ("b", True)], ["b"], ["a"], []),
        ([("a", True), ("b", True), ("c", True)], ["c"], ["a", "b"], []),
        ([("a", True), ("b", False)], ["a"], [], ["b"]),
        ([("a", False), ("b", True)], ["b"], [], ["a"]),
    ],
)
def test_last_completed_attempt_counts_and_others_are_kept(  # noqa: PLR0917  (a table)
    tmp_path, attempts, counts, former, broken, sealed
):
    folder = write_attempts(tmp_path / "run", attempts)
    before = read(folder)
    if sealed:
        seal(folder)
    run = read(folder)
    assert list(run.info.recording_names) == counts
    assert [recording.name for recording in run.recordings] == counts
    assert [recording.name for recording in run.superseded] == former
    assert [recording.name for recording in run.incomplete] == broken
    assert run.digest == before.digest
    names = [name for name, _ in attempts]
    for stored in run.superseded:
        assert_same_recording(stored, recording(stored.name, seed=names.index(stored.name)))


def test_repeated_measurement_is_one_row(tmp_path):
    run = read(write_attempts(tmp_path / "run", [("a", True)], [1.0, 2.0]))
    assert [dict(measurement.values) for measurement in run.measurements] == [{"tester.load": 2.0}]


def test_different_steps_do_not_supersede_each_other(tmp_path):
    with RunWriter(tmp_path / "run", header_of("run")) as writer:
        emit = emitter_of(writer)
        for index in range(2):
            original = recording(f"{index}", seed=index)
            start_recording(emit, original, index)
            send_samples(emit, original, 1000)
            end_recording(emit, original, index)
    assert list(read(tmp_path / "run").info.recording_names) == ["0", "1"]


SCAN = {"step": "main[0].scan", "index": 3}
LOADS = (10.0, 20.0, 30.0)
UNITS = {"tester.load": "N", "tester.torque": "N·m", "tester.frequency": "Hz"}


def emit_scan(emit, *, points=3, begun=True, ok=None, by=0.0):
    """Emit the events of a scan; `ok`: how it ended, or None if it did not end."""
    if begun:
        emit(StepStarted, **SCAN, action="scan", text="Scan", units=UNITS)
    for point, load in enumerate(LOADS[:points]):
        emit(
            Scanned, step=SCAN["step"], point=point, measurement="friction",
            setpoints={"tester.frequency": 2.0, "tester.load": load},
            values={"tester.torque": load / 1000 + by},
        )  # fmt: skip
    if ok is not None:
        emit(StepEnded, **SCAN, action="scan", ok=ok)


def write_scans(folder, *attempts, over=True):
    with RunWriter(folder, header_of(folder.name)) as writer:
        emit = emitter_of(writer)
        emit(RunStarted, run_id=folder.name, steps=1, estimated_s=1.0)
        for number, attempt in enumerate(attempts):
            emit_scan(emit, by=float(number), **attempt)
        if over:
            emit(RunEnded, outcome=Outcome.COMPLETED)
    return folder


def torques(run):
    return [measurement.values["tester.torque"] for measurement in run.measurements]


@pytest.mark.parametrize(
    ("attempts", "counts"),
    [
        ([{"ok": True}], [0.01, 0.02, 0.03]),
        ([{"ok": False, "points": 2}, {"ok": True}], [1.01, 1.02, 1.03]),
        ([{"ok": True}, {"ok": True}], [1.01, 1.02, 1.03]),
        ([{"ok": True}, {"ok": False, "points": 1}], [0.01, 0.02, 0.03]),
        ([{"ok": True}, {"points": 2}], [0.01, 0.02, 0.03]),
        ([{"ok": False}, {"ok": False, "points": 2}], [1.01, 1.02]),
        ([{"points": 2}], [0.01, 0.02]),
        ([{"ok": False, "points": 2}, {"points": 0}], []),
    ],
)
def test_last_completed_attempt_of_a_scan_counts(tmp_path, attempts, counts):
    folder = write_scans(tmp_path / "run", *attempts)
    before = read(folder)
    seal(folder)
    after = read(folder)
    assert torques(before) == torques(after) == pytest.approx(counts)
    assert before.digest == after.digest
    assert before.measurements == after.measurements
    with h5py.File(folder / "run.h5") as file:
        tables = file["entry/measurements"]
        assert list(tables) == (["friction"] if counts else [])
        if counts:
            values = tables["friction/values/tester_torque"]
            assert list(values[()]) == pytest.approx(counts)
            assert values.attrs["units"] == "N·m"
            loads = tables["friction/setpoints/tester_load"][()]
            assert list(loads) == list(LOADS[: len(counts)])
            times = [time.decode() for time in tables["friction/utc"][()]]
            assert times == [measurement.utc for measurement in after.measurements]


def test_killed_scan_keeps_its_points(tmp_path):
    folder = write_scans(tmp_path / "run", {"points": 2}, over=False)
    run = read(folder)
    assert torques(run) == pytest.approx([0.01, 0.02])
    assert run.measurements[0].units == UNITS


def test_digest_covers_each_value_of_a_scan(tmp_path):
    digests = {
        read(write_scans(tmp_path / name, *attempts)).digest
        for name, attempts in {
            "whole": [{"ok": True}],
            "less": [{"points": 2, "ok": True}],
            "other": [{"ok": False}, {"ok": True}],
        }.items()
    }
    assert len(digests) == 3


def test_scan_has_the_digest_of_equal_single_measurements(tmp_path):
    """The digest is that of the measured values, not of the kind of step."""
    with RunWriter(tmp_path / "run", header_of("run")) as writer:
        emit = emitter_of(writer)
        for number, load in enumerate(LOADS):
            emit(
                StepEnded, step=f"main[{number}]", index=number, action="measure", ok=True,
                measurement="friction", units=UNITS,
                setpoints={"tester.frequency": 2.0, "tester.load": load},
                values={"tester.torque": load / 1000},
            )  # fmt: skip
    one_by_one = read(tmp_path / "run")
    scan = read(write_scans(tmp_path / "scan", {"ok": True}))
    assert one_by_one.digest == scan.digest


def test_repeated_step_without_a_recording_supersedes_nothing():
    fields = {"monotonic_s": 0.0, "utc": "", "step": "main[0]", "index": 0, "ok": True}
    events = [StepEnded(seq=n, action="settle", **fields) for n in range(2)]
    assert superseded(events) == frozenset()


def test_limited_statistic_has_the_unit_of_its_channel(tmp_path):
    limit = ValueLimit("tester.torque.maximum", None, 5.0, "N·m")
    fields = {"step": "main[0]", "index": 0, "action": "record", "recording": "a"}
    units = {"tester.torque": "N·m", "tester.load": "N"}
    with RunWriter(tmp_path / "run", header_of()) as writer:
        emit = emitter_of(writer)
        emit(RunStarted, run_id="run", steps=1, estimated_s=1.0)
        emit(
            StepStarted, **fields, text="record a", setpoints={"tester.load": 1000.0}, units=units,
            limits=(limit,),
        )  # fmt: skip
        original = recording("a")
        send_samples(emit, original, 1000)
        emit(
            StepEnded, **fields, ok=True, values={}, units=units,
            statistics={"tester.torque.maximum": 4.5},
        )  # fmt: skip
        emit(RunEnded, outcome=Outcome.COMPLETED)
    (row,) = read(tmp_path / "run").measurements
    assert row.values == {"tester.torque.maximum": 4.5}
    assert row.units == {"tester.load": "N", "tester.torque.maximum": "N·m"}


def test_recording_without_limits_has_a_row_of_its_statistics():
    fields = {"monotonic_s": 0.0, "utc": "", "step": "main[0]", "index": 0, "recording": "a"}
    fields |= {"action": "record", "units": {"tester.torque": "N·m"}}
    mean = {"tester.torque.mean": 4.5}
    events = [
        StepStarted(seq=0, text="", **fields),
        StepEnded(seq=1, ok=True, statistics=mean, **fields),
    ]
    (row,) = StoredEvents(events).measured.rows
    assert (row.recording, row.values) == ("a", mean)
    assert row.units == {"tester.torque.mean": "N·m"}
    assert StoredEvents(events[:1]).measured.rows == ()


def test_value_keeps_the_unit_in_which_it_is_written():
    fields = {"monotonic_s": 0.0, "utc": "", "step": "main[0]", "index": 0, "action": "measure"}
    values = {"tester.load": 1000.0, "tester.torque": 0.5}
    events = [
        StepStarted(seq=0, text="", written_in={"tester.load": "kN"}, **fields),
        StepEnded(seq=1, ok=True, measurement="m", values=values, **fields),
    ]
    (row,) = StoredEvents(events).measured.rows
    assert row.written_in == {"tester.load": "kN"}


def test_repeated_step_is_ordered_by_its_last_attempt():
    events = [
        StepEnded(
            seq=seq, monotonic_s=float(seq), utc="", step=f"main[{index}]", index=index,
            action="measure", ok=True, measurement="table", values={"tester.load": float(seq)},
            units={"tester.load": "N"},
        )
        for seq, index in enumerate([0, 1, 0])
    ]  # fmt: skip
    measured = StoredEvents(events).measured
    assert [row.values["tester.load"] for row in measured.rows] == [1.0, 2.0]
    assert [row.values["tester.load"] for row in measured.superseded] == [0.0]


def test_rows_share_only_identical_values():
    """0.0 and -0.0, and 1, 1.0 and true, are different texts in the digest."""
    events = []
    for number, count in enumerate([1, 1, 1.0, True]):
        fields = {"monotonic_s": 0.0, "utc": "", "step": f"main[{number}]", "index": number}
        fields |= {"action": "measure", "units": {"tester.load": "N"}}
        limits = (ValueLimit("tester.load", None, -0.0 if number else 0.0, "N"),)
        events += [
            StepStarted(seq=0, text="", limits=limits, coordinates={"pass": count}, **fields),
            StepEnded(seq=1, ok=True, measurement="m", values={"tester.load": 1.0}, **fields),
        ]
    first, second, third, last = StoredEvents(events).measured.rows
    assert first.units is second.units is third.units is last.units
    assert second.limits is third.limits is last.limits
    assert [repr(row.limits[0].maximum) for row in (first, second)] == ["0.0", "-0.0"]
    assert first.coordinates is second.coordinates
    assert [repr(row.coordinates["pass"]) for row in (second, third, last)] == [
        "1",
        "1.0",
        "True",
    ]


def test_each_row_has_the_zero_in_force():
    """Zeroed before each specimen, rows once had the last zero of the run; row 1 has the first."""

    def ended(action, **values):
        nonlocal seq
        seq += 1
        return StepEnded(
            seq=seq, monotonic_s=float(seq), utc="2026-03-01T12:00:00.000Z", step=f"main[{seq}]",
            index=seq, action=action, ok=True, measurement="table" if action == "measure" else "",
            setpoints={}, values={f"cell.{name}": value for name, value in values.items()},
            units={f"cell.{name}": "N" for name in values},
        )  # fmt: skip

    seq = 0
    events = [
        ended("measure", force=1.0), ended("zero", force=0.1), ended("measure", force=2.0),
        ended("zero", force=0.2), ended("zero", other=5.0), ended("measure", force=3.0),
    ]  # fmt: skip
    first, second, other = ZeroReading(0.1, 1), ZeroReading(0.2, 2), ZeroReading(5.0, 1)
    assert [row.zeros for row in StoredEvents(events).measured.rows] == [
        {"cell.force": first, "cell.other": other},
        {"cell.force": first, "cell.other": other},
        {"cell.force": second, "cell.other": other},
    ]
