"""A point that was repeated: every attempt is kept, the last good one counts."""

from __future__ import annotations

import pytest

from helpers_runfile import (
    assert_same_recording,
    emitter_of,
    end_recording,
    header_of,
    recording,
    send_samples,
    start_recording,
)
from rigrunner.api.events import Outcome, RunEnded, RunStarted, StepEnded
from rigrunner.runfile import RunWriter, read, seal


def written(folder, attempts, measured=()):
    """Write a run of one step that was done several times: (name, ok) each."""
    with RunWriter(folder, header_of(folder.name)) as writer:
        emit = emitter_of(writer)
        emit(RunStarted, run_id=folder.name, steps=2, estimated_s=1.0)
        for number, (name, ok) in enumerate(attempts):
            one = recording(name, seed=number)
            start_recording(emit, one, 7)
            send_samples(emit, one, 1000)
            end_recording(emit, one, 7, ok=ok)
        for value in measured:
            emit(
                StepEnded, step="main[1]", index=8, action="measure", ok=True, measurement="table",
                setpoints={}, values={"tester.load": value}, units={"tester.load": "N"},
            )  # fmt: skip
        emit(RunEnded, outcome=Outcome.COMPLETED)
    return folder


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
def test_the_last_good_one_counts_and_the_others_are_kept(  # noqa: PLR0917  (a table)
    tmp_path, attempts, counts, former, broken, sealed
):
    folder = written(tmp_path / "run", attempts)
    before = read(folder)
    if sealed:
        seal(folder)
    run = read(folder)
    assert list(run.info.recording_names) == counts
    assert [one.name for one in run.recordings] == counts
    assert [one.name for one in run.superseded] == former
    assert [one.name for one in run.incomplete] == broken
    assert run.digest == before.digest
    names = [name for name, _ in attempts]
    for one in run.superseded:
        assert_same_recording(one, recording(one.name, seed=names.index(one.name)))


def test_a_measurement_that_was_repeated_is_one_row(tmp_path):
    run = read(written(tmp_path / "run", [("a", True)], [1.0, 2.0]))
    assert [dict(one.values) for one in run.measurements] == [{"tester.load": 2.0}]


def test_other_steps_of_the_same_name_do_not_replace_each_other(tmp_path):
    with RunWriter(tmp_path / "run", header_of("run")) as writer:
        emit = emitter_of(writer)
        for index in range(2):
            one = recording(f"{index}", seed=index)
            start_recording(emit, one, index)
            send_samples(emit, one, 1000)
            end_recording(emit, one, index)
    assert list(read(tmp_path / "run").info.recording_names) == ["0", "1"]
