from __future__ import annotations

import hashlib
import json
from dataclasses import fields, replace
from typing import TYPE_CHECKING

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst

from helpers_thorough import examples
from rigrunner.api.data import Recording, ZeroReading
from rigrunner.api.events import (
    Alarm,
    Answer,
    Intervention,
    Outcome,
    Prompt,
    RunEnded,
    RunStarted,
    StepEnded,
)
from rigrunner.runfile import (
    RunHeader,
    RunWriter,
    read,
    read_info,
    read_truth,
    read_with_truth,
    seal,
    zero_counts,
)
from rigrunner.runfile.compressed import LongText
from rigrunner.runfile.hdf5 import read_text
from unit.runfile.helpers_runfile import (
    DOCUMENT,
    PLOT,
    TRUTH,
    TWO,
    assert_same_recording,
    emit_zero,
    emitter_of,
    end_recording,
    header_of,
    recording,
    send_samples,
    start_recording,
    write_run,
)

if TYPE_CHECKING:
    from pathlib import Path


@pytest.mark.parametrize("sealed", [False, True])
def test_run_header_round_trips(tmp_path, sealed):
    texts = {field.name: {field.name: f"N·m {field.name}"} for field in fields(RunHeader)}
    names = ("called_texts", "people", "approval", "imported", "salvaged")
    header = header_of(mapping_text="m: [1]\r\n", **{name: texts[name] for name in names})
    writer = RunWriter(tmp_path / "run", header)
    emit_zero(emitter_of(writer))
    writer.close()
    if sealed:
        writer.seal(None)
    assert read(tmp_path / "run").header == header
    assert read_info(tmp_path / "run").header == header


def test_events_and_recordings_are_readable_with_h5py(tmp_path):
    writer = write_run(tmp_path / "run", TWO)
    writer.seal(DOCUMENT, PLOT)
    run = read(tmp_path / "run")
    with h5py.File(tmp_path / "run" / "run.h5") as file:
        (entry,) = (item for item in file.values() if isinstance(item, h5py.Group))
        events = entry["events"]
        assert events["monotonic_s"].attrs["units"] == "s"
        columns = {name: list(events[name].asstr()[()]) for name in ("kind", "step", "text", "utc")}
        assert read_text(entry, "title") == header_of().procedure_title
        groups: list[h5py.Group] = []
        file.visititems(
            lambda _, item: groups.append(item) if isinstance(item, h5py.Group) else None
        )
        assert {str(group.attrs["NX_class"])[:2] for group in groups} == {"NX"}
        stored = entry["recordings"]["_001_10Hz"]
        attributes = dict(stored.attrs)
        signal = stored[attributes["signal"]].attrs["name"]
        columns_of = [column.attrs for column in stored.values() if "column" in column.attrs]
        labels = {attrs["name"]: attrs["long_name"] for attrs in columns_of}
    assert columns == {
        "kind": [type(event).__name__ for event in run.events],
        "step": [getattr(event, "step", "") for event in run.events],
        "text": [getattr(event, "text", "") for event in run.events],
        "utc": [event.utc for event in run.events],
    }
    assert "main[0]" in columns["step"]
    assert (signal, list(attributes["axes"])) == ("tester.torque", ["time"])
    assert labels == {"tester.angle": "tester.angle / rad", "tester.torque": "tester.torque / N·m"}


def test_long_plan_round_trips_and_is_stored_as_text(tmp_path):
    text = "".join(f"step {number}: ünïcode\n" for number in range(30_000))
    header = header_of(plan_text=LongText.of(text))
    writer = write_run(tmp_path / "run", [], header=header)
    assert str(read(tmp_path / "run").header.plan_text) == text
    writer.seal()
    stored = read(tmp_path / "run").header
    assert (stored, str(stored.plan_text)) == (header, text)
    with h5py.File(tmp_path / "run" / "run.h5") as file:
        column = file["entry/texts/plan_text"]
        assert (column.dtype, bytes(column[()]).decode()) == (np.uint8, text)


@pytest.mark.parametrize("sealed", [False, True])
def test_run_round_trips(tmp_path, sealed):
    folder = tmp_path / "run"
    writer = write_run(folder, TWO)
    if sealed:
        writer.seal(DOCUMENT, PLOT)
    run = read(folder)
    for stored, original in zip(run.recordings, TWO, strict=True):
        assert_same_recording(stored, original)
        assert stored.started_utc == "2026-03-01T12:00:00.000Z"
    assert run.header == header_of()
    assert run.zeros == {"tester.torque": 0.0123}
    assert (run.info.outcome, run.info.reason, run.info.sealed) == ("completed", "", sealed)
    assert run.info.ended_utc == "2026-03-01T12:00:00.000Z"
    assert run.info.recording_names == ("001_10Hz", "002_20Hz")
    assert run.incomplete == ()
    assert run.notes == ()
    assert run.result_document == (DOCUMENT if sealed else None)
    assert type(run.events[0]) is RunStarted
    assert type(run.events[-1]) is RunEnded
    assert read_info(folder) == run.info


def test_sealing_does_not_change_the_content(tmp_path):
    writer = write_run(tmp_path / "run", TWO)
    before = read(tmp_path / "run")
    path = writer.seal()
    after = read(path)
    assert after.digest == before.digest
    assert [*after.events] == [*before.events]
    assert after.zeros == before.zeros
    assert after.header == before.header
    assert sorted(item.name for item in (tmp_path / "run").iterdir()) == ["run.h5"]


@pytest.mark.parametrize("sealed", [False, True])
def test_truth_is_stored_separately(tmp_path, sealed):
    writer = write_run(tmp_path / "run", TWO)
    if sealed:
        writer.seal()
    run = read(tmp_path / "run")
    truth = {"001_10Hz": TRUTH, "002_20Hz": TRUTH}
    assert read_truth(tmp_path / "run") == truth
    run_with_truth, stored_truth = read_with_truth(tmp_path / "run")
    assert stored_truth == truth
    assert run_with_truth.digest == run.digest
    assert "starting_torque_nm" not in repr(run)
    assert all(not getattr(event, "truth", None) for event in run.events)


@pytest.mark.parametrize("sealed", [False, True])
def test_failed_zero_and_failed_measurement_are_ignored(tmp_path, sealed):
    writer = RunWriter(tmp_path / "run", header_of())
    emit = emitter_of(writer)
    emit_zero(emit)
    fields = {"index": 0, "values": {"tester.torque": 9.0}, "units": {"tester.torque": "N·m"}}
    emit(StepEnded, step="main[0]", action="zero", ok=False, **fields)
    for ok in (True, False):
        emit(StepEnded, step="main[1]", action="measure", measurement="table", ok=ok, **fields)
    emit(RunEnded, outcome=Outcome.COMPLETED)
    writer.close()
    if sealed:
        writer.seal()
    run = read(tmp_path / "run")
    assert run.zeros == {"tester.torque": 0.0123}
    assert [measurement.name for measurement in run.measurements] == ["table"]


def test_digest_matches_its_description(tmp_path):
    write_run(tmp_path / "run", TWO)
    lines = ""
    for original in TWO:
        description = {
            "name": original.name,
            "rate_hz": original.rate_hz,
            "setpoints": original.setpoints,
            "units": {name: original.units[name] for name in original.channels},
            "channels": {
                name: hashlib.sha256(values.tobytes()).hexdigest()
                for name, values in original.channels.items()
            },
        }
        text = json.dumps(description, sort_keys=True, separators=(",", ":"))
        lines += hashlib.sha256(text.encode()).hexdigest() + "\n"
    assert read(tmp_path / "run").digest == hashlib.sha256(lines.encode()).hexdigest()


def test_digest_depends_on_every_sample_but_not_on_block_size(tmp_path):
    write_run(tmp_path / "a", TWO, block=7)
    write_run(tmp_path / "b", TWO, block=30_000)
    changed = recording()
    changed.channels["tester.torque"][7] = np.nextafter(changed.channels["tester.torque"][7], 9)
    write_run(tmp_path / "c", (changed, TWO[1]))
    first, second, third = (read(tmp_path / name).digest for name in "abc")
    assert first == second != third


def test_no_load_run_is_embedded_with_its_texts_but_without_its_truth(tmp_path):
    no_load = write_run(tmp_path / "no_load", TWO, header=header_of("no_load", inputs={}))
    no_load.seal({"no": "load"})
    path = write_run(tmp_path / "run", [recording(seed=3)]).seal(
        DOCUMENT, PLOT, partners={"no_load": tmp_path / "no_load"}
    )
    embedded, original = read(path).partners["no_load"], read(tmp_path / "no_load")
    assert embedded.digest == original.digest
    assert embedded.header == original.header
    assert [*embedded.events] == [*original.events]
    assert embedded.zeros == original.zeros
    for stored, original in zip(embedded.recordings, TWO, strict=True):
        assert_same_recording(stored, original)
    assert read_truth(path) == {"001_10Hz": TRUTH}
    with h5py.File(path, "r") as file:
        assert "verification" not in file["entry/no_load"]


def test_unsealed_no_load_run_is_embedded(tmp_path):
    write_run(tmp_path / "no_load", TWO)
    path = write_run(tmp_path / "run", TWO[:1]).seal({}, partners={"no_load": tmp_path / "no_load"})
    assert read(path).partners["no_load"].digest == read(tmp_path / "no_load").digest
    with h5py.File(path, "r") as file:
        assert "verification" not in file["entry/no_load"]


def test_all_kinds_of_events_round_trip(tmp_path):
    writer = RunWriter(tmp_path / "run", header_of())
    emit = emitter_of(writer)
    emit(Prompt, step="setup[0]", text="Bereit für µ?", choices=("yes", "no"))
    emit(Answer, step="setup[0]", text="DEMO\0-0001", by="operator", into="specimen")
    emit(Alarm, source="make safe", text="line\nbreak")
    emit(Intervention, action="abort", by="keyboard", reason="")
    emit(RunEnded, outcome=Outcome.ABORTED, reason="stopped on request")
    before = read(tmp_path / "run")
    writer.seal()
    after = read(tmp_path / "run")
    assert [*before.events] == [*after.events]
    prompt, answer, alarm, intervention, ended = after.events
    assert prompt.choices == ("yes", "no")
    assert prompt.text == "Bereit für µ?"
    assert (answer.text, answer.into) == ("DEMO\0-0001", "specimen")
    assert alarm.text == "line\nbreak"
    assert intervention.by == "keyboard"
    assert ended.outcome is Outcome.ABORTED
    assert after.info.outcome == "aborted"


def test_answers_become_inputs(tmp_path):
    writer = RunWriter(tmp_path / "run", header_of(inputs={"specimen": "old", "operator": "Zoë"}))
    emitter_of(writer)(Answer, step="setup[0]", text="DEMO-2", by="operator", into="specimen")
    writer.seal()
    assert read(tmp_path / "run").header.inputs == {"specimen": "DEMO-2", "operator": "Zoë"}


def test_latest_zero_is_used(tmp_path):
    writer = RunWriter(tmp_path / "run", header_of())
    emit = emitter_of(writer)
    emit_zero(emit, 0.5)
    emit_zero(emit, -0.25)
    writer.close()
    assert read(tmp_path / "run").zeros == {"tester.torque": -0.25}


def test_interrupted_recording_is_incomplete(tmp_path):
    writer = RunWriter(tmp_path / "run", header_of())
    emit = emitter_of(writer)
    start_recording(emit, TWO[0])
    send_samples(emit, TWO[0], 100, until=700)
    end_recording(emit, TWO[0], ok=False)
    start_recording(emit, TWO[1], 1)
    send_samples(emit, TWO[1], 1000)
    end_recording(emit, TWO[1], 1)
    before = read(tmp_path / "run")
    writer.seal()
    for run in (before, read(tmp_path / "run")):
        assert run.info.recording_names == ("002_20Hz",)
        (incomplete,) = run.incomplete
        assert (incomplete.name, incomplete.samples) == ("001_10Hz", 700)
        torque = incomplete.channels["tester.torque"]
        assert (torque == TWO[0].channels["tester.torque"][:700]).all()
        assert incomplete.setpoints == TWO[0].setpoints


def test_run_that_never_ended_is_an_error(tmp_path):
    writer = RunWriter(tmp_path / "run", header_of())
    emitter_of(writer)(RunStarted, run_id="run", steps=1, estimated_s=1.0)
    writer.close()
    seal(tmp_path / "run")
    info = read_info(tmp_path / "run")
    assert (info.outcome, info.reason) == (
        "error",
        "the run has not ended, or its program was killed",
    )


NAMES = st.text(st.characters(codec="utf-8", exclude_characters="\0"), min_size=1, max_size=12)
NUMBERS = st.floats(allow_nan=False)


@st.composite
def recordings(draw):
    rows = draw(st.integers(1, 40))
    values = npst.arrays(np.float64, rows, elements=st.floats(width=64))
    channels = draw(st.dictionaries(NAMES, values, min_size=1, max_size=4))
    setpoints = draw(st.dictionaries(NAMES, NUMBERS, max_size=3))
    conditions = draw(st.dictionaries(NAMES, NUMBERS, max_size=3))
    named = [*channels, *setpoints, *conditions]
    return Recording(
        name=draw(NAMES),
        rate_hz=draw(st.floats(1e-3, 1e7)),
        started_utc="",
        setpoints=setpoints,
        channels=channels,
        units=dict.fromkeys(named, draw(NAMES)),
        conditions=conditions,
    )


@settings(deadline=None, max_examples=examples(60))
@given(originals=st.lists(recordings(), max_size=3, unique_by=lambda x: x.name), data=st.data())
def test_any_recordings_round_trip(tmp_path_factory, originals, data):
    folder: Path = tmp_path_factory.mktemp("runs") / "run"
    texts = st.text(st.characters(codec="utf-8"), max_size=20)
    header = RunHeader(
        run_id="run",
        started_utc="2026-03-01T12:00:00.000Z",
        procedure_id=data.draw(texts),
        procedure_revision=data.draw(texts),
        procedure_title=data.draw(texts),
        station_id=data.draw(texts),
        procedure_text=data.draw(texts) * 5000,
        station_text=data.draw(texts),
        inputs=data.draw(st.dictionaries(texts, texts, max_size=3)),
        provenance=data.draw(st.dictionaries(texts, texts, max_size=3)),
    )
    writer = write_run(folder, originals, header=header, block=data.draw(st.integers(1, 50)))
    loose = read(folder)
    writer.seal()
    sealed = read(folder)
    for run in (loose, sealed):
        assert run.header == header
        for stored, original in zip(run.recordings, originals, strict=True):
            assert_same_recording(stored, original)
    assert loose.digest == sealed.digest


def test_channels_may_have_the_names_of_groups(tmp_path):
    channels = {"values": np.ones(3), "coordinates": np.zeros(3), "setpoints": np.arange(3.0)}
    units = dict.fromkeys([*channels, *TWO[0].setpoints, *TWO[0].conditions], "V")
    named = replace(TWO[0], channels=channels, units=units)
    write_run(tmp_path / "run", [named], block=3).seal()
    assert_same_recording(read(tmp_path / "run").recordings[0], named)


def test_each_recording_keeps_the_zero_in_force(tmp_path):
    with RunWriter(tmp_path / "run", header_of()) as writer:
        emit = emitter_of(writer)
        for index, (zero, original) in enumerate(zip((0.01, 0.05), TWO, strict=True)):
            # the first one as in a run of before 0.2
            emit_zero(emit, zero, scatter={"tester.torque": (1e-3, 9.0)} if index else {})
            start_recording(emit, original, index)
            send_samples(emit, original, 1000)
            end_recording(emit, original, index)
        loose = read(tmp_path / "run")
        writer.seal()
    expected = {
        TWO[0].name: {"tester.torque": ZeroReading(0.01, 1)},
        TWO[1].name: {"tester.torque": ZeroReading(0.05, 2, 1e-3, 9.0)},
    }
    assert loose.recording_zeros == expected
    assert read(tmp_path / "run").recording_zeros == expected
    assert loose.zeros == {"tester.torque": 0.05}


def test_equal_zeros_are_numbered_apart(tmp_path):
    with RunWriter(tmp_path / "run", header_of()) as writer:
        emit = emitter_of(writer)
        for index, (zero, original) in enumerate(zip((0.02, 0.02), TWO, strict=True)):
            emit_zero(emit, zero, scatter={"tester.torque": (1e-3, 9.0)})
            start_recording(emit, original, index)
            send_samples(emit, original, 1000)
            end_recording(emit, original, index)
    run = read(tmp_path / "run")
    numbers = [zeros["tester.torque"].number for zeros in run.recording_zeros.values()]
    assert numbers == [1, 2]
    assert zero_counts(run.outline) == {"tester.torque": 2}


def test_torn_journal_is_continued_after_its_last_record(tmp_path):
    writer = write_run(tmp_path / "run", TWO[:1])
    journal = writer.folder / "journal" / "events.journal"
    before = read(tmp_path / "run")
    with journal.open("ab") as file:
        file.write(b"torn")
    with RunWriter(tmp_path / "run") as resumed:
        emit = emitter_of(resumed)
        start_recording(emit, TWO[1], 1)
        send_samples(emit, TWO[1], 1000)
        end_recording(emit, TWO[1], 1)
    after = read(tmp_path / "run")
    assert [recording.name for recording in after.recordings] == [
        recording.name for recording in TWO
    ]
    assert [*after.events][: len(before.events)] == [*before.events]
    assert after.notes == ()
    assert (tmp_path / "run" / "recordings" / "000002.h5").exists()
