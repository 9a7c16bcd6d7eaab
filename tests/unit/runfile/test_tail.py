"""The tail of a recording gives each block once, while another process writes it."""

from __future__ import annotations

from contextlib import closing

import numpy as np

from rigrunner.runfile import RunWriter, read_without_samples, tail_of
from rigrunner.runfile.folder import RunFolder
from rigrunner.runfile.journal import JournalWriter, Kind, read_records, skip_records
from rigrunner.runfile.loose import open_samples
from unit.runfile.helpers_runfile import (
    TWO,
    emitter_of,
    end_recording,
    header_of,
    send_samples,
    start_recording,
)

MUCH = 1 << 40


def test_each_block_comes_once_and_is_what_was_written(tmp_path):
    with RunWriter(tmp_path / "run", header_of()) as writer:
        emit = emitter_of(writer)
        assert tail_of(tmp_path / "run") is None
        start_recording(emit, TWO[1])
        send_samples(emit, TWO[1], 1000, until=3000)
        tail = tail_of(tmp_path / "run")
        blocks = list(tail.blocks(MUCH))
        assert not list(tail.blocks(MUCH))
        with RunFolder(tmp_path / "run").samples(1).open("ab") as file:
            file.write(b"\x10\x00\x00\x00torn")
        assert not list(tail.blocks(MUCH))
        send_samples(emit, TWO[1], 1000)
    assert [each.first_sample for each in blocks] == [0, 1000, 2000]
    for name, values in TWO[1].channels.items():
        assert np.array_equal(np.concatenate([b.channels[name] for b in blocks]), values[:3000])


def test_it_tells_of_the_recording_what_its_events_say(tmp_path):
    with RunWriter(tmp_path / "run", header_of()) as writer:
        emit = emitter_of(writer)
        start_recording(emit, TWO[1])
        send_samples(emit, TWO[1], 1000, until=1000)
        tail = tail_of(tmp_path / "run")
        (block,) = tail.blocks(MUCH)
        stored = read_without_samples(tmp_path / "run")
        begun = tail.begun(block, stored.events)
    assert stored.recordings == stored.incomplete == ()
    assert (begun.name, begun.rate_hz, begun.samples) == (TWO[1].name, TWO[1].rate_hz, 0)
    assert begun.setpoints == TWO[1].setpoints
    assert begun.units["tester.torque"] == "N·m"
    assert list(begun.channels) == list(TWO[1].channels)


def test_who_is_far_behind_goes_on_with_the_newest(tmp_path):
    with RunWriter(tmp_path / "run", header_of()) as writer:
        emit = emitter_of(writer)
        start_recording(emit, TWO[1])
        send_samples(emit, TWO[1], 1000, until=20_000)
        tail = tail_of(tmp_path / "run")
        firsts = [each.first_sample for each in tail.blocks(4 * 16_500)]
    assert firsts == [16_000, 17_000, 18_000, 19_000]


def test_a_folded_recording_has_no_more_blocks(tmp_path):
    with RunWriter(tmp_path / "run", header_of()) as writer:
        emit = emitter_of(writer)
        start_recording(emit, TWO[1])
        send_samples(emit, TWO[1], 1000)
        tail = tail_of(tmp_path / "run")
        end_recording(emit, TWO[1])
        writer.close()
        assert not list(tail.blocks(MUCH))
        assert tail_of(tmp_path / "run") is None


def test_records_that_are_being_written_are_not_skipped(tmp_path):
    path = tmp_path / "a"
    journal = JournalWriter(path)
    for number in range(10):
        journal.append(Kind.BLOCK, bytes([number]) * 100)
    journal.close()
    whole = path.read_bytes()
    for size in range(0, len(whole), 13):
        path.write_bytes(whole[:size])
        end = skip_records(path, None, 0)
        assert end is None or end <= size
        path.write_bytes(whole)
        left = [record.payload[0] for record in read_records(path, end)]
        assert left == list(range(10))[10 - len(left) :]
        assert len(left) >= (len(whole) - max(size, 8)) / 109


def test_the_last_record_is_skipped_too_once_it_is_whole(tmp_path):
    path = tmp_path / "a.journal"
    with closing(JournalWriter(path)) as writer:
        for payload in (b"one", b"three"):
            writer.append(Kind.BLOCK, payload)
    assert skip_records(path, None, 0) == path.stat().st_size


def test_samples_of_which_no_event_tells_keep_the_name_of_their_recording(tmp_path):
    with RunWriter(tmp_path / "run", header_of()) as writer:
        emit = emitter_of(writer)
        start_recording(emit, TWO[1])
        send_samples(emit, TWO[1], 1000)
        samples = open_samples(RunFolder(tmp_path / "run").samples(1))
        facts = samples.facts([])
    assert (facts.name, facts.number) == (TWO[1].name, 1)
