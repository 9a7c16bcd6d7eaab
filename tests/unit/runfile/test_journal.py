from __future__ import annotations

import os
import shutil
import struct
import tracemalloc
import zlib
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from helpers_devices import NthCall
from helpers_thorough import examples
from rigrunner.api.data import Block
from rigrunner.api.errors import DataError
from rigrunner.api.events import Samples
from rigrunner.runfile import RunWriter, read, seal
from rigrunner.runfile.journal import MAGIC, JournalWriter, Kind, read_records, unread_bytes
from unit.runfile.helpers_runfile import (
    assert_same_recording,
    disk_full_beyond,
    emitter_of,
    end_recording,
    header_of,
    recording,
    send_samples,
    start_recording,
    write_run,
)

RECORDS = ((Kind.HEADER, b"{}"), (Kind.EVENT, b"x" * 70), (Kind.BLOCK, b""), (Kind.BLOCK, b"yz"))


@pytest.mark.skipif(os.name == "nt", reason="Windows keeps a file that is open")
@pytest.mark.parametrize("moved", [False, True])
def test_a_journal_that_lost_its_name_is_not_written_further(tmp_path, moved):
    folder = tmp_path / "run"
    folder.mkdir()
    writer = JournalWriter(folder / "a.journal")
    writer.sync()
    if moved:
        folder.rename(tmp_path / "elsewhere")
    else:
        shutil.rmtree(folder)
    with pytest.raises(FileNotFoundError):
        writer.sync()
    writer.close()


@pytest.fixture
def journal(tmp_path):
    path = tmp_path / "a.journal"
    writer = JournalWriter(path)
    for kind, payload in RECORDS:
        writer.append(kind, payload[:1], memoryview(payload[1:]))
    writer.close()
    return path


def records_in(path):
    return tuple((record.kind, record.payload) for record in read_records(path))


def test_records_come_back(journal):
    assert records_in(journal) == RECORDS
    assert unread_bytes(journal, [record.end for record in read_records(journal)][-1]) == 0


def test_what_comes_is_synced_at_least_once_a_second(tmp_path, monkeypatch):
    """As docs/reference/durability.md promises."""
    now_s, synced_s = [0.0], []
    monkeypatch.setattr("rigrunner.runfile.journal.monotonic", lambda: now_s[0])
    monkeypatch.setattr("os.fsync", lambda _: synced_s.append(now_s[0]))
    writer = JournalWriter(tmp_path / "a.journal")
    for tenth in range(50):
        now_s[0] = tenth / 10
        writer.append(Kind.BLOCK, b"x")
        writer.sync_sometimes()
    writer.close()
    gaps_s = [after - before for before, after in pairwise([0.0, *synced_s, 4.9])]
    assert max(gaps_s) <= 1.1 + 1e-9  # a second, and a block
    assert len(synced_s) <= 5


def test_a_journal_of_an_earlier_version_is_read(tmp_path):
    """Its bytes: length, kind 1 to 4, CRC-32 over both and the payload, payload."""
    old = tmp_path / "old.journal"
    content = b"RIGJ\x01\r\n\x00"
    for number, (_, payload) in enumerate(RECORDS, 1):
        crc = zlib.crc32(payload, zlib.crc32(struct.pack("<IBI", len(payload), number, 0)))
        content += struct.pack("<IBI", len(payload), number, crc) + payload
    old.write_bytes(content)
    kinds = (Kind.HEADER, Kind.EVENT, Kind.TRUTH, Kind.BLOCK)
    assert records_in(old) == tuple(zip(kinds, [record[1] for record in RECORDS], strict=True))


def test_every_prefix_gives_all_records_that_are_whole(journal):
    content = journal.read_bytes()
    ends = [record.end for record in read_records(journal)]
    for length in range(len(content)):
        journal.write_bytes(content[:length])
        assert records_in(journal) == RECORDS[: sum(end <= length for end in ends)]


def test_every_flipped_bit_ends_the_reading_where_it_is(journal):
    content = journal.read_bytes()
    ends = [len(MAGIC), *(record.end for record in read_records(journal))]
    for place in range(len(MAGIC), len(content)):
        damaged = bytearray(content)
        damaged[place] ^= 1 << (place % 8)
        journal.write_bytes(damaged)
        intact = sum(end <= place for end in ends) - 1
        assert records_in(journal) == RECORDS[:intact]


def test_lost_page_in_the_middle_hides_nothing_before_it(journal):
    content = journal.read_bytes()
    ends = [record.end for record in read_records(journal)]
    journal.write_bytes(content[: ends[1]] + bytes(len(content) - ends[1]))
    assert records_in(journal) == RECORDS[:2]


def test_damaged_length_does_not_ask_for_memory(journal):
    content = bytearray(journal.read_bytes())
    content[len(MAGIC) : len(MAGIC) + 4] = b"\xff\xff\xff\xff"
    journal.write_bytes(content)
    tracemalloc.start()
    assert records_in(journal) == ()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 1_000_000


def test_record_that_did_not_fit_is_taken_back(tmp_path):
    writer = JournalWriter(tmp_path / "a.journal")
    writer.append(Kind.EVENT, b"first")
    with disk_full_beyond(1000), pytest.raises(OSError, match="File too large"):
        writer.append(Kind.BLOCK, b"x" * 600, b"y" * 600)
    writer.append(Kind.EVENT, b"last")
    writer.close()
    assert [payload for _, payload in records_in(tmp_path / "a.journal")] == [b"first", b"last"]


def test_record_that_an_interrupt_cut_is_taken_back(tmp_path, monkeypatch):
    writer = JournalWriter(tmp_path / "a.journal")
    writer.append(Kind.EVENT, b"first")
    write = writer._write
    monkeypatch.setattr(writer, "_write", NthCall(1, KeyboardInterrupt(), then=write))
    with pytest.raises(KeyboardInterrupt):
        writer.append(Kind.BLOCK, bytes(100_000))  # too long to be copied to its head
    writer.append(Kind.EVENT, b"last")
    writer.close()
    assert [payload for _, payload in records_in(tmp_path / "a.journal")] == [b"first", b"last"]


def test_what_the_system_takes_in_pieces_is_written_whole(tmp_path):
    writer = JournalWriter(tmp_path / "a.journal")
    file = writer._file
    writer._file = ByLittle(file)
    writer.append(Kind.EVENT, b"an event of many bytes")
    writer.append(Kind.BLOCK, b"a head", bytes(5000))
    file.close()
    payloads = [payload for _, payload in records_in(tmp_path / "a.journal")]
    assert payloads == [b"an event of many bytes", b"a head" + bytes(5000)]


class ByLittle:
    """A file that takes at most 7 bytes at a time, and sometimes none."""

    def __init__(self, file):
        self.file = file
        self.calls = 0

    def write(self, data):
        self.calls += 1
        return self.file.write(bytes(data[:7])) if self.calls % 3 else None


def test_other_files_are_no_journal(tmp_path):
    path = tmp_path / "a.journal"
    path.write_bytes(b"\x89HDF\r\n\x1a\n and more")
    with pytest.raises(DataError, match="is not a journal"):
        records_in(path)


def test_journal_is_never_written_over(journal):
    with pytest.raises(FileExistsError):
        JournalWriter(journal)


@settings(deadline=None, max_examples=examples(40))
@given(st.lists(st.binary(max_size=200), max_size=6))
def test_any_payload_comes_back(tmp_path_factory, payloads):
    path = tmp_path_factory.mktemp("journal") / "a.journal"
    writer = JournalWriter(path)
    for payload in payloads:
        writer.append(Kind.BLOCK, payload)
    writer.close()
    assert [payload for _, payload in records_in(path)] == payloads


def cut(path, length):
    path.write_bytes(path.read_bytes()[:length])


def test_run_with_a_torn_journal_of_events_is_read_as_far_as_it_got(tmp_path):
    original = recording(samples=300)
    write_run(tmp_path / "run", [original])
    events = tmp_path / "run" / "journal" / "events.journal"
    content, seen = events.read_bytes(), set()
    ends = [record.end for record in read_records(events)]
    header_end = ends[1]  # after the plan
    lengths = {*range(0, len(content), 11), *ends, *(end - 1 for end in ends)} - {len(content)}
    for length in sorted(lengths):
        cut(events, length)
        if length < header_end:
            with pytest.raises(DataError, match="ends before the run's header"):
                read(tmp_path / "run")
        else:
            run = read(tmp_path / "run")
            assert_same_recording(run.recordings[0], original)
            seen.add(len(run.events))
            assert bool(run.notes) == (length not in ends)
        events.write_bytes(content)
    assert seen == set(range(5))


def test_samples_up_to_the_last_whole_block_are_saved(tmp_path):
    original = recording(samples=1000)
    with RunWriter(tmp_path / "run", header_of()) as writer:
        emit = emitter_of(writer)
        start_recording(emit, original)
        send_samples(emit, original, 100)
    (path,) = (tmp_path / "run" / "journal").glob("*.samples")
    content = path.read_bytes()
    ends = [record.end for record in read_records(path)]
    for length in range(0, len(content), 97):
        cut(path, length)
        intact = 100 * sum(end <= length for end in ends)
        incomplete = read(tmp_path / "run").incomplete
        assert [stored.samples for stored in incomplete] == ([intact] if intact else [])
        for stored in incomplete:
            torque = stored.channels["tester.torque"]
            assert (torque == original.channels["tester.torque"][:intact]).all()
        path.write_bytes(content)


@pytest.mark.parametrize("in_memory", [1 << 26, -1])
def test_a_recording_interrupted_after_an_empty_block_is_read_once_it_is_sealed(
    tmp_path, monkeypatch, in_memory
):
    """A device that is polled may have nothing yet when the run is stopped."""
    original = recording(samples=1000)
    with RunWriter(tmp_path / "run", header_of()) as writer:
        emit = emitter_of(writer)
        start_recording(emit, original)
        nothing = {name: values[:0] for name, values in original.channels.items()}
        emit(Samples, recording=original.name, block=Block(original.rate_hz, 0, 0.0, nothing))
        end_recording(emit, original, ok=False)
    (loose,) = read(tmp_path / "run").incomplete
    seal(tmp_path / "run")
    monkeypatch.setattr("rigrunner.runfile.entry.IN_MEMORY", in_memory)
    (sealed,) = read(tmp_path / "run").incomplete
    assert list(sealed.channels) == list(loose.channels) == list(original.channels)
    assert sealed.samples == loose.samples == 0


def test_recording_that_ended_but_was_not_folded_is_finished(tmp_path, monkeypatch):
    original = recording(samples=1000)
    with RunWriter(tmp_path / "run", header_of()) as writer:
        emit = emitter_of(writer)
        start_recording(emit, original)
        send_samples(emit, original, 100)
        monkeypatch.setattr("rigrunner.runfile.writer.fold", lambda *_: None)  # the kill
        end_recording(emit, original)
    assert not (tmp_path / "run" / "recordings").exists()
    before = read(tmp_path / "run")
    seal(tmp_path / "run")
    for run in (before, read(tmp_path / "run")):
        assert_same_recording(run.recordings[0], original)
        assert run.incomplete == ()
    assert read(tmp_path / "run").digest == before.digest


def test_a_journal_that_is_gone_on_with_ends_with_its_last_record(journal):
    end = max(record.end for record in read_records(journal))
    with journal.open("ab") as file:
        file.write(b"torn" * 1000)
    writer = JournalWriter(journal, end)
    writer.append(Kind.EVENT, b"after")
    writer.close()
    *_, last = read_records(journal)
    assert (last.kind, last.payload) == (Kind.EVENT, b"after")
    assert journal.stat().st_size == last.end


def test_the_numbers_of_the_kinds_of_records_stay_those_of_the_journals_that_are_there():
    assert {kind.name: int(kind) for kind in Kind} == {
        "HEADER": 1, "EVENT": 2, "TRUTH": 3, "BLOCK": 4, "ROW": 5, "PACKED": 6, "PLAN": 7,
    }  # fmt: skip
