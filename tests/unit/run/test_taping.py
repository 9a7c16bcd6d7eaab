"""Runs on tape: a replay is identical to the last bit, and failures are repeated."""

from __future__ import annotations

import errno
import json
import os
import shutil
import threading
from dataclasses import replace

import pytest

from helpers_tester import STATION, procedure_file, station_file
from helpers_workflow import START
from helpers_workflow import registry as installed_plugins
from rigrunner.api.devices import ChannelInfo, Identity
from rigrunner.api.driver import Driver
from rigrunner.api.errors import (
    AbortedError,
    DataError,
    DeviceError,
    DeviceLostError,
    DeviceRejectedError,
    DeviceTimeoutError,
    ExitCode,
    UsageError,
)
from rigrunner.api.events import Alarm, Answer, Outcome, StepStarted
from rigrunner.api.hooks import DeviceRecord
from rigrunner.api.progress import unseen
from rigrunner.certificate.content import restrictions_of
from rigrunner.clock import SimulatedClock
from rigrunner.documents.certifying.certify import read_source
from rigrunner.engine import Choice, Decision, Override, UnattendedAnswers
from rigrunner.registry import Plugin, Provider, Registry, load_registry
from rigrunner.run.inputs import answer_inputs
from rigrunner.run.partners import partners_for
from rigrunner.run.prepare import plan_run
from rigrunner.run.record import execute
from rigrunner.run.report import AnalysedRun, report_input
from rigrunner.run.stored import open_run
from rigrunner.run.taping import inputs_on, on_tape, overrides_on, tape_for
from rigrunner.runfile import read, read_with_truth
from rigrunner.tape import RecordedTape, ReplayedTape

pytestmark = pytest.mark.usefixtures("tester")
TWO = ("[8 Hz, 15 Hz, 20 Hz, 25 Hz, 35 Hz]", "[8 Hz, 15 Hz]")


def run(tape, procedure, runs, *, station=None, registry=None, answers=None, stop=None, **people):
    """Run on a tape; `people` are listeners and pauses."""
    clock = SimulatedClock(START if isinstance(tape, RecordedTape) else tape.manifest.began_utc)
    where = station or STATION
    planned = plan_run(procedure, where, registry or installed_plugins(), clock, tape)
    answers = answers or UnattendedAnswers()
    with tape:
        return execute(
            planned,
            runs=runs,
            inputs=answer_inputs(planned.procedure, inputs_on(tape), answers),
            partners={},
            answers=answers,
            stop=stop or threading.Event(),
            **people,
        )


def both(folder, procedure, **options):
    """Record a run and replay it; return both, and the tape that was played."""
    first = run(RecordedTape(folder / "tape"), procedure, folder / "runs", **options)
    tape = ReplayedTape(folder / "tape")
    return first, run(tape, procedure, folder / "runs", **options), tape


@pytest.fixture(scope="module")
def taped(tmp_path_factory):
    folder = tmp_path_factory.mktemp("taped")
    procedure = procedure_file(folder, "idle")
    return folder, procedure, *both(folder, procedure)


def test_replay_has_identical_recordings(taped):
    _, _, first, replay, tape = taped
    assert tape.notes() == ()
    one, other = open_run(first.folder), open_run(replay.folder)
    assert one.data.digest == other.data.digest
    for a, b in zip(one.data.recordings, other.data.recordings, strict=True):
        assert {name: values.tobytes() for name, values in a.channels.items()} == {
            name: values.tobytes() for name, values in b.channels.items()
        }
        assert (a.conditions, a.setpoints, a.started_utc) == (
            b.conditions, b.setpoints, b.started_utc,
        )  # fmt: skip


def test_replay_has_same_result(taped):
    _, _, first, replay, _ = taped
    one, other = (json.loads((run.folder / "result.json").read_text()) for run in (first, replay))
    del one["run"], other["run"]
    assert one == other


def test_replay_has_same_events_at_same_times(taped):
    _, _, first, replay, _ = taped
    one, other = (read(run.folder).events for run in (first, replay))
    assert [repr(event) for event in one[1:]] == [repr(event) for event in other[1:]]


def test_replay_calls_no_device(taped, monkeypatch):
    folder, procedure, *_ = taped
    from tester_of_tests import Tester  # noqa: PLC0415  (within the fixture alone)

    def fail(*_):
        raise AssertionError("a device was asked")

    for name in ("connect", "read", "set", "read_back", "stream", "make_safe", "close"):
        monkeypatch.setattr(Tester, name, fail)
    replay = run(ReplayedTape(folder / "tape"), procedure, folder / "more")
    assert replay.outcome is Outcome.COMPLETED


def test_replay_is_marked_in_name_run_file_and_report(taped):
    folder, _, first, replay, _ = taped
    assert replay.folder.name == f"{first.folder.name}_replay"
    stored = read(replay.folder)
    replayed = stored.header.provenance["replayed"]
    assert replayed.startswith("tape, begun 2026-03-01T12:00:00.000Z, SHA-256 ")
    page = replay.report.read_text(encoding="utf-8")
    assert "Not for certification: this run is a replay, and no instrument was asked" in page
    assert replayed in page
    assert "replayed" not in read(first.folder).header.provenance
    assert "is a replay" not in first.report.read_text(encoding="utf-8")
    analysed = AnalysedRun.of(*read_with_truth(replay.folder), load_registry(), unseen)
    assert report_input(analysed, replay.folder).provenance["replayed"] == replayed
    assert folder.exists()


def test_certificate_on_replay_is_a_specimen_with_reason(taped):
    _, _, first, replay, _ = taped
    registry = load_registry()
    one, other = (read_source(run.folder, registry) for run in (first, replay))
    codes = [limit.code for limit in restrictions_of(one, requested=True)]
    assert codes == ["draft_procedure", "simulated"]
    details = {limit.code: limit.detail for limit in restrictions_of(other, requested=True)}
    assert list(details) == [*codes, "replayed"]
    assert details["replayed"] == other.stored.header.provenance["replayed"]


def test_replay_is_not_a_partner_of_a_measurement(taped):
    folder, procedure, _, replay, _ = taped
    planned = plan_run(
        procedure_file(folder, "loaded"),
        STATION,
        load_registry(),
        SimulatedClock(START),
    )
    partners = {"tare": replay.folder.name}
    with pytest.raises(DataError, match="it is the replay of a tape"):
        partners_for(planned, folder / "runs", partners)
    replayed_plan = replace(planned, tape=ReplayedTape(folder / "tape"))
    assert partners_for(replayed_plan, folder / "runs", partners) == {"tare": replay.folder}
    assert procedure.exists()


def test_changed_command_is_the_first_difference(taped, tmp_path):
    folder, *_ = taped
    changed = procedure_file(
        tmp_path, "idle",
        ("[8 Hz, 15 Hz, 20 Hz, 25 Hz, 35 Hz]", "[8 Hz, 15 Hz, 21 Hz, 25 Hz, 35 Hz]"),
    )  # fmt: skip
    finished = run(ReplayedTape(folder / "tape"), changed, tmp_path / "runs")
    assert finished.exit_code is ExitCode.DEVICE
    assert isinstance(finished.error, DeviceRejectedError)
    lines = (folder / "tape/devices/tester.jsonl").read_text().splitlines()
    number = next(n for n, line in enumerate(lines, 1) if "set frequency 20.0" in line)
    assert str(finished.error).startswith(
        f"tester: the replay differs from the tape: {folder}/tape/devices/tester.jsonl:{number}"
        " has 'set frequency 20.0', the replay asked for 'set frequency 21.0',"
        " after 'read back load',"
    )
    assert str(finished.error).endswith("(the procedure is not the one of the tape)")
    assert len(read(finished.folder).recordings) == 2


def test_remaining_exchanges_are_noted(taped, tmp_path):
    folder, procedure, *_ = taped
    tape = tmp_path / "tape"
    (tape / "devices").mkdir(parents=True)
    for name in ("tape.json", "clock.jsonl", "answers.jsonl", "devices/tester.jsonl"):
        (tape / name).write_bytes((folder / "tape" / name).read_bytes())
    with (tape / "devices/tester.jsonl").open("a") as file:
        file.write('{"seq":99999,"ask":"close","answer":null,"took_s":0}\n')
    replayed = ReplayedTape(tape)
    assert run(replayed, procedure, tmp_path / "runs").outcome is Outcome.COMPLETED
    (note,) = replayed.notes()
    assert note.endswith("one exchange is left on the tape that were not asked for")


@pytest.mark.parametrize("length", [0, 20_000, 100_000])
def test_truncated_tape_ends_replay_there(taped, tmp_path, length):
    folder, procedure, *_ = taped
    tape = tmp_path / "tape"
    (tape / "devices").mkdir(parents=True)
    for name in ("tape.json", "clock.jsonl", "answers.jsonl", "devices/tester.jsonl"):
        (tape / name).write_bytes((folder / "tape" / name).read_bytes())
    content = (tape / "devices/tester.jsonl").read_bytes()
    (tape / "devices/tester.jsonl").write_bytes(content[:length])
    if not length:
        with pytest.raises(DeviceRejectedError, match="tester: the tape is over"):
            run(ReplayedTape(tape), procedure, tmp_path / "runs")
        return
    finished = run(ReplayedTape(tape), procedure, tmp_path / "runs")
    assert "the tape is over at" in str(finished.error)
    assert finished.sealed


def test_difference_while_making_safe_is_an_error(taped, tmp_path):
    folder, procedure, *_ = taped
    tape = tmp_path / "tape"
    shutil.copytree(folder / "tape", tape)
    file = tape / "devices/tester.jsonl"
    file.write_bytes(file.read_bytes().replace(b'"make safe"', b'"hide"'))
    finished = run(ReplayedTape(tape), procedure, tmp_path / "runs")
    assert finished.outcome is Outcome.ERROR
    assert "the replay asked for 'make safe'" in finished.reason
    assert not finished.unsafe


@pytest.mark.parametrize("length", [300, 5_000, 30_000])
def test_truncated_clock_ends_replay_in_order(taped, tmp_path, length):
    folder, procedure, *_ = taped
    tape = tmp_path / "tape"
    (tape / "devices").mkdir(parents=True)
    for name in ("tape.json", "clock.jsonl", "answers.jsonl", "devices/tester.jsonl"):
        (tape / name).write_bytes((folder / "tape" / name).read_bytes())
    (tape / "clock.jsonl").write_bytes((tape / "clock.jsonl").read_bytes()[:length])
    replayed = ReplayedTape(tape)
    finished = run(replayed, procedure, tmp_path / "runs")
    assert "clock.jsonl" in str(finished.error)
    (note,) = replayed.notes()
    assert note.startswith(f"the tape is over at {tape}/clock.jsonl:")
    assert finished.outcome is Outcome.ERROR


def test_device_failure_is_replayed(tmp_path):
    faulty = "{plugin: tester_of_tests, settings: {seed: 1}, faults: [%s]}"
    lost = faulty % "{kind: lost, at: {frequency: 15 Hz}}"
    plain = "plugin: tester_of_tests\n    settings: {seed: 1}"
    wrapped = (plain, f"plugin: fault\n    settings: {lost}")
    station = station_file(tmp_path, wrapped)
    procedure = procedure_file(tmp_path, "idle", TWO)
    first, replay, tape = both(tmp_path, procedure, station=station)
    assert isinstance(first.error, DeviceLostError)
    assert (type(replay.error), str(replay.error)) == (type(first.error), str(first.error))
    assert replay.reason == first.reason
    assert read(replay.folder).digest == read(first.folder).digest
    assert tape.notes() == ()


def test_tripped_interlock_is_replayed(tmp_path):
    """Interlocks depend on time: how long a value was too high, and when it was read."""
    station = station_file(tmp_path, ("above: 60 °C, every: 1 s", "above: 22 °C, every: 0.7 s"))
    procedure = procedure_file(tmp_path, "idle", TWO)
    first, replay, tape = both(tmp_path, procedure, station=station)
    assert first.outcome is replay.outcome is Outcome.ABORTED
    assert "tester.temperature is 23" in first.reason
    assert replay.reason == first.reason
    one, other = (read(run.folder).events for run in (first, replay))
    assert [repr(event) for event in one[1:]] == [repr(event) for event in other[1:]]
    assert tape.notes() == ()


def test_answers_of_persons_are_replayed(tmp_path):
    class Person:
        by = "A. Jones"

        def confirm(self, step, question):  # noqa: ARG002  (the engine's)
            return False

        def ask(self, step, question):  # noqa: ARG002  (the engine's)
            return "B. Smith"

    procedure = procedure_file(tmp_path, "idle", TWO)
    tape = RecordedTape(tmp_path / "tape")
    first = run(tape, procedure, tmp_path / "runs", answers=Person())
    replay = run(ReplayedTape(tmp_path / "tape"), procedure, tmp_path / "runs")
    for finished in (first, replay):
        assert finished.outcome is Outcome.ABORTED
        assert finished.reason.endswith("was answered with no")
        stored = read(finished.folder)
        assert stored.header.inputs == {"operator": "B. Smith"}
        assert [event.by for event in stored.events if isinstance(event, Answer)] == ["A. Jones"]


def test_overrides_are_replayed(tmp_path):
    procedure = procedure_file(tmp_path, "idle", TWO)
    tape = RecordedTape(tmp_path / "tape")
    clock = SimulatedClock(START)
    planned = plan_run(procedure, STATION, load_registry(), clock, tape)
    overrides = (Override("overdue tester.torque", "it was due", "A. Jones", "urgent"),)
    on_tape(planned, tape, {"operator": "B. Smith"}, overrides, UnattendedAnswers())
    replayed = ReplayedTape(tmp_path / "tape")
    assert overrides_on(replayed) == overrides
    assert inputs_on(replayed) == {"operator": "B. Smith"}
    assert overrides_on(tape) == ()
    assert inputs_on(None) == {}


class StopAt:
    """A stop token that is set at the start of a recording."""

    def __init__(self, recording):
        self.recording = recording
        self.set = False

    def __call__(self, event):
        self.set |= isinstance(event, StepStarted) and event.recording.startswith(self.recording)

    def is_set(self):
        return self.set

    def reason(self):
        error = AbortedError("it sounded odd", by="A. Jones")
        error.exit_code = ExitCode.INTERRUPTED
        return error


def test_stop_is_replayed_at_same_place(tmp_path):
    procedure = procedure_file(tmp_path, "idle", TWO)
    stop = StopAt("002")
    tape = RecordedTape(tmp_path / "tape")
    first = run(tape, procedure, tmp_path / "runs", listeners=[stop], stop=stop)
    replayed = ReplayedTape(tmp_path / "tape")
    replay = run(replayed, procedure, tmp_path / "runs")
    for finished in (first, replay):
        assert (finished.outcome, finished.reason) == (Outcome.ABORTED, "it sounded odd")
        assert finished.exit_code is ExitCode.INTERRUPTED
        assert finished.error.by == "A. Jones"
    one, other = (read(run.folder) for run in (first, replay))
    assert [repr(event) for event in one.events[1:]] == [repr(event) for event in other.events[1:]]
    assert [len(stored.recordings) for stored in (one, other)] == [1, 1]
    assert replayed.notes() == ()


class Pausing:
    """Pauses once at the start of a recording, looks a few times, then decides."""

    def __init__(self, recording, *decisions):
        self.recording = recording
        self.decisions = list(decisions)
        self.is_requested = False

    def __call__(self, event):
        if isinstance(event, StepStarted) and event.recording.startswith(self.recording):
            self.is_requested = bool(self.decisions)

    def requested_by(self):
        return "keyboard" if self.is_requested else ""

    def decide(self, paused, watch):  # noqa: ARG002  (the engine's)
        self.is_requested = False
        for _ in range(3):
            watch()
        decision = self.decisions.pop(0)
        if isinstance(decision, Exception):
            raise decision
        return decision


@pytest.mark.parametrize(
    ("decisions", "outcome"),
    [
        ([Decision(Choice.RESUME, "A. Jones")], Outcome.COMPLETED),
        ([Decision(Choice.NOTE, "A. Jones", "odd"), Decision(Choice.REPEAT, "A. Jones")],
         Outcome.COMPLETED),
        ([Decision(Choice.SKIP, "A. Jones", "too hot")], Outcome.COMPLETED),
        ([Decision(Choice.ABORT, "A. Jones", "enough")], Outcome.ABORTED),
        ([AbortedError("paused, and nobody answered", by="nobody")], Outcome.ABORTED),
    ],
    ids=["resume", "note and repeat", "skip", "abort", "nobody"],
)  # fmt: skip
def test_pause_and_decision_are_replayed(tmp_path, decisions, outcome):
    procedure = procedure_file(tmp_path, "idle", TWO)
    pauses = Pausing("002", *decisions)
    tape = RecordedTape(tmp_path / "tape")
    first = run(tape, procedure, tmp_path / "runs", listeners=[pauses], pauses=pauses)
    assert pauses.decisions == []
    replayed = ReplayedTape(tmp_path / "tape")
    replay = run(replayed, procedure, tmp_path / "runs")
    assert first.outcome is replay.outcome is outcome
    assert replay.reason == first.reason
    one, other = (read(run.folder) for run in (first, replay))
    assert [repr(event) for event in one.events[1:]] == [repr(event) for event in other.events[1:]]
    assert one.digest == other.digest
    assert replayed.notes() == ()


def test_replay_can_be_stopped(taped, tmp_path):
    folder, procedure, *_ = taped
    stop = StopAt("001")
    replay = run(
        ReplayedTape(folder / "tape"), procedure, tmp_path / "runs", listeners=[stop], stop=stop
    )
    assert (replay.outcome, replay.reason) == (Outcome.ABORTED, "it sounded odd")
    assert not replay.unsafe  # there is no rig, and nobody has to go to one


def test_full_disk_loses_tape_but_not_run(tmp_path, monkeypatch):
    procedure = procedure_file(tmp_path, "idle", TWO)
    write, events = os.write, []

    def full(descriptor, line):
        if line.startswith(b'{"seq":20,'):
            raise OSError(errno.ENOSPC, "No space left on device")
        return write(descriptor, line)

    monkeypatch.setattr("rigrunner.tape.recording.os.write", full)
    tape = RecordedTape(tmp_path / "tape")
    finished = run(tape, procedure, tmp_path / "runs", listeners=[events.append])
    assert finished.outcome is Outcome.COMPLETED
    assert finished.exit_code is ExitCode.PASS
    alarms = [event.text for event in events if isinstance(event, Alarm)]
    assert len(alarms) == 1
    assert alarms[0].startswith("the tape failed and was dropped: DataError: ")
    assert alarms[0].endswith("No space left on device; the run continues without it")
    (note,) = tape.notes()
    assert "is incomplete" in note


class Thermometer(Driver):
    """A wired device: its own code runs in a replay too. The instrument is a function."""

    instrument = staticmethod(lambda request: {"ID?": "T-1", "TEMP?": "296.5"}[request])

    def __init__(self, context):
        super().__init__(context, [ChannelInfo("air", "K", "air")])

    def open(self, timeout_s):  # noqa: ARG002
        return Identity("Fakes", "thermometer", self._ask("ID?"), simulated=True)

    def get(self, channel):  # noqa: ARG002
        return float(self._ask("TEMP?"))

    def _ask(self, request):
        return self.exchange(request, lambda: type(self).instrument(request))


@pytest.fixture
def wired(tmp_path, monkeypatch):
    """A station with a wired thermometer beside the tester, and the registry that knows it."""

    def make(_, context):
        return Thermometer(context)

    record = DeviceRecord(name="thermometer", help="", factory=make, wired=True, simulated=True)
    plugins = load_registry().plugins
    registry = Registry([*plugins, Plugin("device", record, Provider("tests", "1"))])
    station = station_file(
        tmp_path,
        ("devices:\n", "devices:\n  room: {type: thermometer, plugin: thermometer}\n"),
        ("order: [", "patience: {connect: 1 s, answer: 0.3 s}\n  order: ["),
    )
    return registry, station, monkeypatch


def test_tape_of_wired_device_records_its_wire(wired, tmp_path):
    registry, station, monkeypatch = wired
    procedure = procedure_file(tmp_path, "idle", TWO)
    bench = {"station": station, "registry": registry}
    first = run(RecordedTape(tmp_path / "tape"), procedure, tmp_path / "runs", **bench)
    lines = (tmp_path / "tape/devices/room.jsonl").read_text().splitlines()
    assert [json.loads(line)["ask"] for line in lines] == ["ID?", "TEMP?", "TEMP?"]

    def fail(_):
        raise AssertionError("the instrument was asked")

    monkeypatch.setattr(Thermometer, "instrument", staticmethod(fail))
    replay = run(ReplayedTape(tmp_path / "tape"), procedure, tmp_path / "runs", **bench)
    assert replay.outcome is Outcome.COMPLETED
    assert read(replay.folder).digest == read(first.folder).digest
    assert read(replay.folder).recordings[0].conditions["room.air"] == 296.5


def test_hang_of_instrument_is_replayed(wired, tmp_path):
    registry, station, monkeypatch = wired
    procedure = procedure_file(tmp_path, "idle", TWO)
    bench = {"station": station, "registry": registry}
    answer = threading.Event()

    def hangs(request):
        if request == "TEMP?":
            answer.wait(20)
        return "T-1"

    monkeypatch.setattr(Thermometer, "instrument", staticmethod(hangs))
    first, replay, _ = both(tmp_path, procedure, **bench)
    answer.set()
    for finished in (first, replay):
        assert isinstance(finished.error, DeviceTimeoutError)
        assert str(finished.error) == "room: 'read' did not return within 0.3 s"


def test_changed_driver_command_is_the_first_difference(wired, tmp_path):
    registry, station, monkeypatch = wired
    procedure = procedure_file(tmp_path, "idle", TWO)
    bench = {"station": station, "registry": registry}
    run(RecordedTape(tmp_path / "tape"), procedure, tmp_path / "runs", **bench)
    monkeypatch.setattr(Thermometer, "get", lambda self, _: float(self._ask("T?")))
    finished = run(ReplayedTape(tmp_path / "tape"), procedure, tmp_path / "runs", **bench)
    assert str(finished.error) == (
        f"room: the replay differs from the tape: {tmp_path}/tape/devices/room.jsonl:2 has 'TEMP?',"
        " the replay asked for 'T?', after 'ID?'"
    )


def test_tape_options_are_exclusive_and_need_an_empty_folder(tmp_path):
    with pytest.raises(UsageError, match="exclude each other"):
        tape_for(tmp_path / "a", tmp_path / "b")
    with pytest.raises(DataError, match=r"holds no tape: tape.json: No such file"):
        tape_for(None, tmp_path)
    (tmp_path / "notes.txt").touch()
    with pytest.raises(DataError, match="a tape is never overwritten"):
        tape_for(tmp_path, None)
    assert tape_for(None, None) is None
    (tmp_path / "tape.json").write_text('{"rigrunner": "tape/2"}')
    with pytest.raises(DataError, match="not a tape that this Rigrunner knows: rigrunner: "):
        tape_for(None, tmp_path)


def test_unwritable_tape_prevents_run(tmp_path):
    (tmp_path / "file").touch()
    procedure = procedure_file(tmp_path, "idle", TWO)
    with pytest.raises(DataError, match="cannot make the tape"):
        run(RecordedTape(tmp_path / "file/tape"), procedure, tmp_path / "runs")
    assert not (tmp_path / "runs").exists()
    assert issubclass(DeviceRejectedError, DeviceError)
