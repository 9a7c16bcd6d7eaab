"""The queue of specimens: order, states, and that nothing runs twice by mistake."""

from __future__ import annotations

import json
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime
from pathlib import Path
from types import SimpleNamespace

import pytest
from filelock import FileLock

from rigrunner.api.errors import DataError, InvalidFileError, UsageError
from rigrunner.api.events import Outcome, RunEnded, RunStarted
from rigrunner.bus import EventStamp
from rigrunner.clock import SimulatedClock
from rigrunner.procedure.questions import Input
from rigrunner.queue import Draft, Queue, accepted_inputs, list_text, read_list
from rigrunner.queue import tested_before as before
from rigrunner.runfile import RunHeader, RunWriter
from rigrunner.runfile.folder import create_run_folder

NOW = datetime(2026, 11, 23, 12, tzinfo=UTC)
STATION = "s.yaml"
ASKED = {
    "specimen": Input(ask="Serial number"),
    "type": Input(ask="Type", choices=["GE20", "GE30"]),
    "room": Input(ask="Room", unit="°C", min="15 °C", max="30 °C"),
}


def draft(specimen, procedure="p.yaml", station=STATION):
    return Draft(procedure=procedure, station=station, inputs={"specimen": specimen})


@pytest.fixture
def queue(tmp_path):
    queue = Queue(tmp_path / "runs")
    queue.add([draft("SN-1"), draft("SN-2"), draft("SN-3")], "Ann", NOW)
    return queue


def specimens(queue, *statuses):
    return [shown.entry.specimen for shown in queue.shown() if shown.status in statuses]


def test_entries_run_in_the_chosen_order(queue):
    queue.move(3, before=1)
    assert specimens(queue, "waiting") == ["SN-3", "SN-1", "SN-2"]
    queue.move(3, before=None)
    queue.move(1, before=1)
    assert specimens(queue, "waiting") == ["SN-1", "SN-2", "SN-3"]
    assert queue.next().specimen == "SN-1"


def test_interrupted_entry_is_not_restarted(queue):
    with queue.started(1, "Ann"):
        pass  # it ends without a run, as after a kill
    with pytest.raises(UsageError, match="was interrupted"), queue.started(1, "Bob"):
        raise AssertionError
    assert specimens(queue, "interrupted") == ["SN-1"]


def test_held_skipped_and_proposed_entries_do_not_start(queue):
    queue.hold(1, "Ann", "wrong ring")
    queue.skip(2, "Ann", "lost")
    queue.add([draft("SN-4")], "LIMS", NOW, proposed=True)
    assert queue.next().specimen == "SN-3"
    for number in (1, 2, 4):
        with pytest.raises(UsageError, match="expected waiting"), queue.started(number, "Ann"):
            raise AssertionError
    queue.release(4, "Ann")
    queue.release(1, "Ann")
    assert specimens(queue, "waiting") == ["SN-1", "SN-3", "SN-4"]
    assert queue.get(4).by == "Ann"


def test_entry_is_stored_as_started_before_its_run(queue):
    with queue.started(1, "Ann"):
        stored = json.loads(queue.path(STATION).read_text(encoding="utf-8"))["entries"][0]
        assert (stored["state"], stored["run"]) == ("started", "")
        assert specimens(Queue(queue.path(STATION).parent), "running") == ["SN-1"]
        with pytest.raises(UsageError, match="running"), queue.started(1, "Bob"):
            raise AssertionError
        began = RunStarted(
            seq=1, utc="", monotonic_s=0.0, run_id="20261123_X", steps=1, estimated_s=1.0
        )
        queue.began(1)(began)
    assert queue.get(1).run == "20261123_X"


def test_crashed_entry_blocks_the_queue_until_repeated(queue):
    program = f"""
import os
from pathlib import Path
from rigrunner.queue import Queue
with Queue(Path({str(queue.path(STATION).parent)!r})).started(1, "Ann"):
    os._exit(9)
"""
    done = subprocess.run([sys.executable, "-c", program], check=False, timeout=60)
    assert done.returncode == 9
    assert specimens(queue, "interrupted") == ["SN-1"]
    with pytest.raises(UsageError, match="was interrupted"):
        queue.next()
    with pytest.raises(UsageError) as refused, queue.started(1, "Ann"):
        raise AssertionError
    assert refused.value.message == "the run of entry 1 (SN-1) was interrupted"
    assert "'rigrunner queue repeat 1 --reason TEXT'" in refused.value.hint
    assert "resume" not in refused.value.hint  # there is no run yet
    queue._replace(1, run="20261123_X")
    with pytest.raises(UsageError) as refused:
        queue.next()
    assert "'rigrunner resume 20261123_X'" in refused.value.hint
    repeat = queue.repeat(1, "Ann", "the machine lost its power", NOW)
    assert queue.next() == repeat
    assert (repeat.specimen, repeat.repeats) == ("SN-1", 1)
    (remark,) = repeat.remarks()
    assert (remark.by, remark.reason) == ("Ann", "the machine lost its power")
    assert specimens(queue, "closed") == ["SN-1"]
    with pytest.raises(UsageError, match="already repeated: entry 4"):
        queue.repeat(1, "Ann", "once more", NOW)


def test_entry_with_an_ended_run_is_done(queue, monkeypatch):
    with queue.started(1, "Ann"):
        queue._replace(1, run="20261123_X")
    info = SimpleNamespace(reason="", outcome="failed", sealed=True)
    listed_run = SimpleNamespace(is_in_progress=False, info=info)
    monkeypatch.setattr("rigrunner.queue.store.listed_run", lambda *_: listed_run)
    with pytest.raises(UsageError, match="entry 1 is done"), queue.started(1, "Ann"):
        raise AssertionError


def test_concurrent_readers_see_the_same_status(queue, tmp_path):
    with queue.started(1, "Ann"):
        pass
    (tmp_path / "runs" / ".queue-1.lock").touch()  # as a kill leaves it
    runs = tmp_path / "runs"

    def look(_):
        return Queue(runs).shown()[0].status

    with ThreadPoolExecutor(4) as several:
        assert set(several.map(look, range(400))) == {"interrupted"}
    with queue.started(2, "Ann"), ThreadPoolExecutor(4) as several:
        statuses = several.map(lambda _: Queue(runs).shown()[1].status, range(40))
        assert set(statuses) == {"running"}


def test_resumed_run_has_its_latest_outcome(queue):
    """As after a lost device; the panel keeps one queue for as long as it runs."""
    folder = queue.path(STATION).parent / "20261123_X"
    ids = dict.fromkeys(("procedure_id", "procedure_revision", "procedure_title"), "p")
    texts = dict.fromkeys(("station_id", "procedure_text", "station_text"), "s")
    header = RunHeader(run_id=folder.name, started_utc="2026-11-23T12:00:00.000Z", **ids, **texts)
    stamp = EventStamp(SimulatedClock(NOW))
    began = stamp(RunStarted, run_id=folder.name, steps=1, estimated_s=1.0)
    outcomes = []
    with queue.started(1, "Ann"):
        queue.began(1)(began)
    for outcome in (Outcome.ERROR, Outcome.COMPLETED):
        with RunWriter(folder, None if outcomes else header) as writer:
            writer(began)
            writer(stamp(RunEnded, outcome=outcome, resumable=outcome is Outcome.ERROR))
        outcomes.append(queue.shown()[0].outcome)
    assert outcomes == ["error", "completed"]


def test_entry_is_held_if_its_run_could_not_begin(queue):
    with queue.started(1, "Ann"):
        queue.give_back(1, "no device answers")
    assert (queue.get(1).state, queue.get(1).reason) == ("held", "no device answers")
    with queue.started(2, "Ann"):
        queue._replace(2, run="20261123_X")
        queue.give_back(2, "its run has begun")
    assert queue.get(2).state == "started"


def leave_run(folder, specimen, procedure="P", outcome=Outcome.COMPLETED, day=1, **provenance):
    """Leave a run of a specimen in a folder of runs."""
    started = NOW.replace(day=day)
    path = create_run_folder(folder, started, procedure, specimen)
    header = RunHeader(
        run_id=path.name, started_utc=started.isoformat(), procedure_id=procedure,
        procedure_revision="1", procedure_title="", station_id="s", procedure_text="",
        station_text="", inputs={"specimen": specimen}, provenance=provenance,
    )  # fmt: skip
    stamp = EventStamp(SimulatedClock(started))
    with RunWriter(path, header) as writer:
        writer(stamp(RunStarted, run_id=path.name, steps=1, estimated_s=1.0))
        writer(stamp(RunEnded, outcome=outcome))
    return path.name


def test_tested_specimen_needs_a_reason(queue, tmp_path):
    runs = tmp_path / "runs"
    leave_run(runs, "SN 7/é", day=1)
    newest = leave_run(runs, "SN 7/é", day=2)
    leave_run(runs, "SN-8", outcome=Outcome.ABORTED)
    leave_run(runs, "SN-9", procedure="Q")
    leave_run(runs, "SN-70")
    leave_run(runs, "SN-11", replayed="tape")
    others = ["SN-8", "SN-9", "SN-7", "SN-11", ""]
    sentence = f"sn 7/É has already been tested: run {newest}"
    assert before(runs, "P", [*others, "sn 7/É"]) == {"sn 7/É": sentence}
    drafts = [draft("sn 7/É"), draft("SN-8")]
    with pytest.raises(InvalidFileError) as refused:
        queue.add(drafts, "Ann", NOW, procedure_id="P")
    assert [(problem.message, problem.field) for problem in refused.value.problems] == [
        (sentence, "again")
    ]
    again = [draft.model_copy(update={"again": "customer asks"}) for draft in drafts]
    first, second = queue.add(again, "Ann", NOW, procedure_id="P")
    queue.hold(first.id, "Bob", "dirty")
    queue.release(first.id, "Bob")
    (remark,) = queue.get(first.id).remarks()
    assert (remark.by, remark.reason) == ("Ann", "customer asks")
    assert second.remarks() == ()


def test_all_problems_of_a_list_are_reported_together(queue, tmp_path):
    run = leave_run(tmp_path / "runs", "SN-8")
    items, invalid = read_list("specimen,type\nSN-8,GE20\nSN-2,\nSN-9,GE99\nSN-10,\n", ASKED)
    drafts = [draft(item.inputs["specimen"]) for item in items]
    with pytest.raises(InvalidFileError) as refused:
        queue.add(drafts, "Ann", NOW, procedure_id="P", invalid=invalid)
    assert [
        (problem.message.partition(":")[0], problem.field) for problem in refused.value.problems
    ] == [
        ("got 'GE99', expected one of", ""),
        ("SN-8 has already been tested", "again"),
        ("SN-2 is already in the queue", ""),
    ]
    assert run in refused.value.problems[1].message
    assert len(queue.entries()) == 3
    with pytest.raises(InvalidFileError, match="GE99"):
        queue.add([], "Ann", NOW, invalid=invalid)


def test_specimen_of_an_aborted_run_needs_a_reason(queue, tmp_path):
    with queue.started(1, "Ann"):
        queue._replace(1, run=leave_run(tmp_path / "runs", "SN-1", outcome=Outcome.ABORTED))
    with pytest.raises(InvalidFileError, match="entry 1, done") as refused:
        queue.add([draft("SN-1")], "Ann", NOW, procedure_id="P")
    assert [problem.field for problem in refused.value.problems] == ["again"]
    again = draft("SN-1").model_copy(update={"again": "the fuse had blown"})
    (entry,) = queue.add([again], "Ann", NOW, procedure_id="P")
    assert entry.remarks()[0].reason == "the fuse had blown"


def test_duplicate_specimen_refuses_the_whole_list(queue):
    with pytest.raises(InvalidFileError) as refused:
        queue.add([draft("SN-9"), draft(" sn-2".strip()), draft("SN-9")], "Ann", NOW)
    assert [problem.message for problem in refused.value.problems] == [
        "SN-2 is already in the queue: entry 2, waiting",
        "SN-9 is in the list twice",
    ]
    assert len(queue.entries()) == 3
    queue.add([draft("SN-2", procedure="other.yaml")], "Ann", NOW)
    queue.skip(2, "Ann", "lost")
    queue.add([draft("SN-2")], "Ann", NOW)


def test_cleared_numbers_are_not_reused(queue):
    queue.skip(3, "Ann", "lost")
    assert queue.clear(station="other.yaml") == 0
    assert queue.clear() == 1
    assert [entry.id for entry in queue.add([draft("SN-5")], "Ann", NOW)] == [4]


def test_file_of_another_format_is_not_overwritten(queue):
    queue.path(STATION).write_text('{"rigrunner": "queue/2"}', encoding="utf-8")
    with pytest.raises(DataError, match="queue of this version"):
        queue.hold(1, "Ann")
    assert queue.path(STATION).read_text(encoding="utf-8") == '{"rigrunner": "queue/2"}'


def test_concurrent_additions_are_all_kept(queue):
    program = f"""
from datetime import UTC, datetime
from pathlib import Path
from rigrunner.queue import Draft, Queue
import sys
queue = Queue(Path({str(queue.path(STATION).parent)!r}))
for i in range(10):
    inputs = {{"specimen": f"{{sys.argv[1]}}-{{i}}"}}
    queue.add([Draft(procedure="p", station="s", inputs=inputs)], "x", datetime.now(UTC))
"""
    jobs = [subprocess.Popen([sys.executable, "-c", program, name]) for name in "AB"]
    assert [job.wait(120) for job in jobs] == [0, 0]
    numbers = [entry.id for entry in queue.entries()]
    assert len(numbers) == len(set(numbers)) == 23


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("SN-1\r\n\r\n  SN-2 \n", [(1, {"specimen": "SN-1"}), (3, {"specimen": "SN-2"})]),
        ("SN-1, left\n", [(1, {"specimen": "SN-1, left"})]),
        (
            '\ufeffspecimen;Type;room\nSN-1;ge20;\n"SN;2";GE30;20\n',
            [
                (2, {"specimen": "SN-1", "type": "GE20"}),
                (3, {"specimen": "SN;2", "type": "GE30", "room": "20 °C"}),
            ],
        ),
        ("sep=;\r\nspecimen;type;\r\nSN-1;GE20;\r\n", [(3, {"specimen": "SN-1", "type": "GE20"})]),
        ("specimen\nA;1\nB;2\n", [(2, {"specimen": "A;1"}), (3, {"specimen": "B;2"})]),
    ],
)
def test_common_list_formats_are_read(text, expected):
    items, invalid = read_list(text, ASKED)
    assert [(item.line, item.inputs) for item in items] == expected
    assert invalid == []


def test_every_invalid_line_is_reported():
    text = "specimen,type\nSN-1,GE99\nSN-2\n,GE20\nSN-4,GE20\n"
    items, invalid = read_list(text, ASKED, "list.csv")
    assert [str(problem.location) for problem in invalid] == [
        "list.csv:2",
        "list.csv:3",
        "list.csv:4",
    ]
    assert "expected one of: GE20, GE30" in invalid[0].message
    assert [item.line for item in items] == [5]


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("\n \n", "the list is empty"),
        ("specimen,typ\nSN-1,GE20\n", "got the column 'typ'"),
        ("specimen,type\n", "a header and no specimen"),
        ("x\n" * 1001, "1001 lines, expected at most 1000"),
        ("No;specimen;Type\n1;SN-1;GE20\n", "got the column 'No'"),
        ("Specimn\nSN-1\nSN-2\n", "got 'Specimn' as the first line"),
        ("SN-1\tGE20\t22\n", "the list has 3 columns without names"),
        ("SN-1;GE20\nSN-2;GE20\n", "the list has 2 columns without names"),
    ],
)
def test_invalid_list_is_refused(text, why):
    with pytest.raises(UsageError, match=why):
        read_list(text, ASKED)


@pytest.mark.parametrize("text", ["SN\x1b[2J", "SN\u202e1", "S" * 3000, "a\x00b"])
def test_hostile_specimens_are_refused(text):
    items, invalid = read_list(text, ASKED)
    assert (items, len(invalid)) == ([], 1)


def test_unknown_inputs_are_refused():
    assert accepted_inputs({"type": "ge20"}, ASKED) == {"type": "GE20"}
    with pytest.raises(UsageError, match="no input 'lot'"):
        accepted_inputs({"lot": "L"}, ASKED)


OTHER = "benches/b 2.yaml"


def files(runs):
    return sorted(path.name for path in runs.glob("queue*.json"))


def test_stations_have_files_and_numbers_are_unique(queue, tmp_path):
    entries = queue.add([draft("SN-8", station=OTHER), draft("SN-9", station=OTHER)], "Bob", NOW)
    assert [entry.id for entry in entries] == [4, 5]
    assert queue.add([draft("SN-10")], "Ann", NOW)[0].id == 6
    assert files(tmp_path / "runs") == ["queue-benches%2Fb%202.yaml.json", "queue-s.yaml.json"]
    queue.hold(5, "Bob", "dirty")
    assert [shown.entry.id for shown in queue.shown(OTHER)] == [4, 5]
    assert [shown.entry.id for shown in queue.shown(STATION)] == [1, 2, 3, 6]
    assert (queue.next(OTHER).specimen, queue.next(STATION).specimen) == ("SN-8", "SN-1")
    with pytest.raises(UsageError, match=r"2 stations wait: benches/b 2\.yaml, s\.yaml"):
        queue.next()
    with pytest.raises(UsageError, match="no entry 1"):
        queue.move(4, before=1)


def test_specimen_queued_at_another_station_is_refused(queue):
    with pytest.raises(InvalidFileError, match=r"SN-2 is already in the queue of s\.yaml: entry 2"):
        queue.add([draft("sn-2", station=OTHER)], "Ann", NOW)
    queue.skip(2, "Ann", "goes to the other rig")
    assert queue.add([draft("SN-2", station=OTHER)], "Ann", NOW)[0].station == OTHER


def test_a_specimen_twice_in_one_list_is_refused(queue):
    with pytest.raises(InvalidFileError, match="sn-7 is in the list twice"):
        queue.add([draft("SN-7"), draft("sn-7")], "Ann", NOW)
    assert len(queue.entries()) == 3


@pytest.mark.parametrize(
    ("one", "other"),
    [("SN 7", "SN\N{NO-BREAK SPACE}7"), ("SN 7", "SN  7"), ("\u00c4-7", "A\u0308-7")],
)
def test_specimens_that_look_alike_are_the_same(queue, one, other):
    queue.add([draft(one)], "Ann", NOW)
    with pytest.raises(InvalidFileError, match="already in the queue: entry 4"):
        queue.add([draft(other)], "Ann", NOW)


@pytest.mark.parametrize("coding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_list_is_read_in_encodings_of_spreadsheets(coding):
    assert list_text("specimen;type\r\nÄ-1 µ;GE20\r\n".encode(coding)).splitlines() == [
        "specimen;type",
        "Ä-1 µ;GE20",
    ]


@pytest.mark.parametrize("content", [b"PK\x03\x04\x00\x00\xff", b"a\x00b", b"%PDF-1.7\n"])
def test_workbook_is_refused_as_a_list(content):
    with pytest.raises(DataError, match="is not a text file"):
        list_text(content, "today.xlsx")


def test_unreadable_file_does_not_block_other_stations(queue):
    queue.add([draft("SN-8", station=OTHER)], "Ann", NOW)
    queue.path(STATION).write_text("{", encoding="utf-8")
    queue.hold(4, "Ann", "dirty")
    queue.release(4, "Ann")
    assert queue.next(OTHER).id == 4
    with queue.started(4, "Ann"):
        assert [shown.status for shown in queue.shown(OTHER)] == ["running"]
    with pytest.raises(DataError, match="queue-s"):
        queue.get(1)


def test_common_file_of_older_versions_is_split_by_station(queue, tmp_path):
    runs = tmp_path / "runs"
    queue.add([draft("SN-8", station=OTHER)], "Ann", NOW)
    queue.hold(2, "Ann", "dirty")
    entries = [entry.model_dump() for entry in queue.entries()]
    for file in files(runs):
        (runs / file).unlink()
    common = {"rigrunner": "queue/1", "next": 12, "entries": entries}
    (runs / "queue.json").write_text(json.dumps(common), encoding="utf-8")
    reopened = Queue(runs)
    assert [(shown.entry.id, shown.status) for shown in reopened.shown(STATION)] == [
        (1, "waiting"), (2, "held"), (3, "waiting"),
    ]  # fmt: skip
    assert files(runs) == ["queue-benches%2Fb%202.yaml.json", "queue-s.yaml.json"]
    assert reopened.add([draft("SN-9")], "Ann", NOW)[0].id == 12


def test_interrupted_split_is_completed_without_undoing_changes(queue, tmp_path):
    runs = tmp_path / "runs"
    entries = [entry.model_dump() for entry in queue.entries()]
    other = {**entries[0], "id": 4, "station": OTHER}
    queue.hold(1, "Ann", "dirty")
    common = {"rigrunner": "queue/1", "next": 5, "entries": [*entries, other]}
    (runs / "queue.json").write_text(json.dumps(common), encoding="utf-8")
    assert [shown.status for shown in Queue(runs).shown()] == [
        "waiting",
        "held",
        "waiting",
        "waiting",
    ]
    assert not (runs / "queue.json").exists()


def test_queue_that_cannot_be_locked_is_reported_and_read(queue, monkeypatch):
    """As in a folder on a disk that is read-only, or of another user."""

    def deny(_lock, *_, **__):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(FileLock, "acquire", deny)
    with pytest.raises(DataError, match=r"cannot write .*runs: Permission denied"):
        queue.hold(1, "Ann")
    with (
        pytest.raises(DataError, match=r"cannot write .*runs: Permission denied"),
        queue.started(1, "Ann"),
    ):
        pass
    assert specimens(queue, "waiting") == ["SN-1", "SN-2", "SN-3"]


def test_queue_in_a_closed_folder_is_reported(queue, monkeypatch):
    def deny(_path):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "exists", deny)
    with pytest.raises(DataError, match=r"cannot read .*runs: Permission denied"):
        queue.shown()


@pytest.mark.parametrize(("old", "new"), [('"next":4', '"next":3'), ('"id":2', '"id":1')])
def test_edited_file_in_which_a_number_is_not_unique_is_refused(queue, old, new):
    """The wrong specimen could be marked as started."""
    file = queue.path(STATION)
    file.write_text(file.read_text().replace(": ", ":").replace(old, new))
    with pytest.raises(DataError, match="unique, and less than 'next'"):
        queue.add([draft("SN-4")], "Ann", NOW)
