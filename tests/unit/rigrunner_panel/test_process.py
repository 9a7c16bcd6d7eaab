"""Messages between a panel and the process of its run: in order, and never blocking the run."""

from __future__ import annotations

import io
import os
import signal
import threading
import time
from contextlib import suppress
from types import SimpleNamespace

import numpy as np
import pytest

from helpers_waiting import wait_until
from rigrunner.api.data import Block
from rigrunner.api.errors import AbortedError
from rigrunner.api.events import Note, Outcome, RunEnded, Samples, Scanned
from rigrunner.ending import ENDING, SUSPENDING, signal_name
from rigrunner.engine import Choice, Decision, Interference, Paused, StopNow
from rigrunner.engine.pausing import PauseRequestedError
from rigrunner.steps.confirm import Confirm
from rigrunner_panel.live.watcher import ANALYST
from rigrunner_panel.process.channel import Channel, ChannelClosedError
from rigrunner_panel.process.launch import Process
from rigrunner_panel.process.link import MOST_BLOCKS, Commands, Link, Sender
from rigrunner_panel.process.messages import Abort, Answer, Decide, Pause, PutOnRecord, Show, Stop
from rigrunner_panel.process.person import PanelAnswers, PanelPauses
from rigrunner_panel.process.switch import Switch

STAMP = {"monotonic_s": 1.0, "utc": "2026-03-01T12:00:00.000Z"}
BY, WHY = "Ann", "because"


class Ends:
    """Both ends of a channel, over real pipes."""

    def __init__(self):
        pipes = [os.pipe(), os.pipe()]
        files = [(os.fdopen(r, "rb"), os.fdopen(w, "wb")) for r, w in pipes]
        self.panel = Channel(files[0][0], files[1][1])
        self.run = Channel(files[1][0], files[0][1])
        self.files = [file for pair in files for file in pair]

    def close(self):
        for file in self.files[1::2]:
            file.close()
        time.sleep(0.05)
        for file in self.files[::2]:
            file.close()


@pytest.fixture
def ends():
    ends = Ends()
    yield ends
    ends.close()


@pytest.fixture
def commands(ends):
    commands = Commands(ends.run, Switch())
    commands.start()
    return commands


def test_messages_arrive_in_order_and_a_closed_channel_raises(ends):
    for number in range(100):
        ends.panel.send(Answer(number, "x" * number, BY))
    assert [ends.run.receive().prompt for _ in range(100)] == list(range(100))
    ends.panel.close()
    with pytest.raises(ChannelClosedError):
        ends.run.receive()
    with pytest.raises(ChannelClosedError):
        ends.panel.send(1)


@pytest.mark.parametrize("torn", [b"", b"\x80", b"\x80\x05\x95\x10", b"nonsense"])
def test_torn_message_closes_the_channel(torn):
    with pytest.raises(ChannelClosedError):
        Channel(io.BytesIO(torn), io.BytesIO()).receive()


def test_loss_of_the_panel_aborts_the_run(ends):
    switch = Switch()
    Commands(ends.run, switch).start()
    ends.panel.close()
    wait_until(switch.is_set)
    assert "the panel is gone" in str(switch.reason())


def link_of(commands, sent, switch=None):
    return Link(commands, SimpleNamespace(send=sent.append), switch or Switch())


def confirm(commands, sent, switch=None):
    answers = PanelAnswers(link_of(commands, sent, switch), "Bob")
    return answers.confirm("s", Confirm("Ready?", None)), answers.by


def test_answer_is_awaited_and_names_its_author(ends, commands):
    sent = []
    ends.panel.send(Answer(99, "no", "an older prompt's"))
    ends.panel.send(Answer(1, "yes", BY))
    assert confirm(commands, sent) == (True, BY)
    shown, hidden = sent
    prompt = shown.sections["prompt"]
    assert (prompt.id, prompt.choices) == (1, ("yes", "no"))
    assert prompt.accepts.accept("YES") == "yes"
    assert hidden == Show({"prompt": None})


def test_stop_and_pause_interrupt_a_prompt(ends, commands):
    switch, sent = Switch(), []
    switch.abort(BY, WHY)
    with pytest.raises(AbortedError, match=WHY):
        confirm(commands, sent, switch)
    ends.panel.send(Pause(BY))
    with pytest.raises(PauseRequestedError):
        confirm(commands, sent)
    assert sent[-1] == Show({"prompt": None})  # the question has left the screen, too


PAUSED = Paused("s", "p", "why", (), (Choice.RESUME, Choice.SKIP, Choice.ABORT))


def test_second_click_does_not_end_the_next_pause(ends, commands):
    sent, looks = [], []
    pauses = PanelPauses(link_of(commands, sent))
    ends.panel.send(Pause(BY))
    wait_until(pauses.requested_by)
    ends.panel.send(Decide(Decision(Choice.RESUME, BY)))
    ends.panel.send(Decide(Decision(Choice.RESUME, BY)))
    wait_until(lambda: commands._decisions.qsize() == 2)
    skip = threading.Timer(0.3, lambda: ends.panel.send(Decide(Decision(Choice.SKIP, BY, WHY))))
    skip.start()
    assert pauses.decide(PAUSED, lambda: looks.append(1)).choice is Choice.SKIP
    (paused, resumed) = (message.sections for message in sent)
    assert paused["pause"].choices == ("resume", "skip", "abort")
    assert resumed == {"pause": None}
    assert (pauses.requested_by(), len(looks) > 1) == ("", True)
    skip.join()


def test_decision_sent_with_the_pause_is_taken_if_possible(ends, commands):
    pauses = PanelPauses(link_of(commands, []))
    ends.panel.send(Pause(BY, Decision(Choice.SKIP, BY, WHY)))
    wait_until(pauses.requested_by)
    assert pauses.decide(PAUSED, lambda: None) == Decision(Choice.SKIP, BY, WHY)
    ends.panel.send(Pause(BY, Decision(Choice.REPEAT, BY)))  # cannot be done here
    wait_until(pauses.requested_by)
    ends.panel.send(PutOnRecord(Interference("take over", BY)))
    wait_until(lambda: not commands._records.empty())
    assert list(pauses.new_actions()) == [Interference("take over", BY)]
    later = threading.Timer(0.2, lambda: ends.panel.send(Decide(Decision(Choice.RESUME, BY))))
    later.start()
    assert pauses.decide(PAUSED, lambda: None).choice is Choice.RESUME
    later.join()


@pytest.fixture
def installed():
    """Return a switch that handles the signals of this process."""
    former = {number: signal.getsignal(number) for number in (signal.SIGINT, *ENDING, *SUSPENDING)}
    switch = Switch()
    switch.install()
    yield switch
    for number, handler in former.items():
        signal.signal(number, handler)


@pytest.mark.skipif(os.name == "nt", reason="a thread cannot be interrupted so there")
def test_stop_interrupts_the_main_thread_once(ends, installed):
    Commands(ends.run, installed).start()
    os.kill(os.getpid(), signal.SIGINT)  # from the terminal, not from the panel
    began_s = time.monotonic()
    threading.Timer(0.1, lambda: ends.panel.send(Stop(BY, WHY))).start()
    with pytest.raises(StopNow) as stopped, installed.interruptible():
        time.sleep(60)
    assert time.monotonic() - began_s < 30
    assert (stopped.value.by, WHY in stopped.value.reason) == (BY, True)
    ends.panel.send(Stop(BY, "again"))
    time.sleep(0.1)  # the rig is being made safe: a second stop must not interrupt that


@pytest.mark.skipif(os.name == "nt", reason="a thread cannot be interrupted so there")
def test_stop_before_the_job_interrupts_it_at_its_start(installed):
    installed.stop(BY, WHY)
    time.sleep(0.05)  # a signal that is still on its way
    done = []
    with pytest.raises(StopNow, match=WHY), installed.interruptible():
        done.append("the job")
    assert done == []
    time.sleep(0.05)  # it is raised once


@pytest.mark.skipif(os.name == "nt", reason="a thread cannot be interrupted so there")
def test_second_stop_does_not_interrupt(installed):
    def stopped():
        installed.stop(BY, WHY)
        time.sleep(60)

    with installed.interruptible():
        with pytest.raises(StopNow):
            stopped()
        installed.stop("Bob", "again")
        time.sleep(0.05)
    assert installed.reason().by == BY


@pytest.mark.skipif(os.name == "nt", reason="a thread cannot be interrupted so there")
def test_stop_after_the_job_interrupts_nothing(installed):
    with installed.interruptible():
        pass
    installed.stop(BY, WHY)
    time.sleep(0.05)
    assert installed.is_set()


@pytest.mark.skipif(os.name == "nt", reason="POSIX signals")
@pytest.mark.parametrize("number", [*ENDING, *SUSPENDING], ids=signal_name)
def test_every_ending_or_suspending_signal_aborts_the_run(installed, number):
    os.kill(os.getpid(), number)
    wait_until(installed.is_set)  # another thread may have taken the signal
    assert signal_name(number) in installed.reason().message
    assert installed.reason().by == "signal"


def test_stop_after_the_end_of_the_run_interrupts_nothing():
    switch = Switch()
    switch(RunEnded(seq=1, outcome=Outcome.COMPLETED, **STAMP))
    switch.stop(BY, WHY)
    assert switch.is_set()


def test_stop_does_not_interrupt_making_the_rig_safe():
    switch = Switch()
    switch.stop_interrupting()
    switch.stop(BY, WHY)
    assert switch.is_set()


def test_first_abort_gives_author_and_reason(ends):
    switch = Switch()
    Commands(ends.run, switch).start()
    ends.panel.send(Abort(BY, WHY))
    ends.panel.send(Abort("Bob", "too"))
    wait_until(switch.is_set)
    assert (switch.reason().by, switch.reason().message) == (BY, f"aborted at the panel: {WHY}")


class StuckPipe:
    """A panel that does not read."""

    def __init__(self):
        self.free = threading.Event()
        self.sent = []

    def write(self, content):
        self.free.wait()
        self.sent.append(content)

    def flush(self):
        pass


def test_stuck_panel_loses_curves_but_no_events_and_never_blocks():
    pipe = StuckPipe()
    sender = Sender(Channel(io.BytesIO(), pipe))
    block = Block(1000.0, 0, 1.0, {"t.torque": np.zeros(1000)})
    began_s = time.monotonic()
    for number in range(1000):
        sender(Samples(seq=number, recording="r", block=block, **STAMP))
        sender(Note(seq=number, step="s", text="t", **STAMP))
    assert time.monotonic() - began_s < 10
    pipe.free.set()
    sender.close()
    sizes = [len(message) for message in pipe.sent]
    assert sum(size > 4000 for size in sizes) <= MOST_BLOCKS + 1
    assert sum(size < 4000 for size in sizes) == 1000


def test_fast_scan_is_thinned_but_keeps_its_last_point(monkeypatch):
    now_s = iter(np.arange(0.0, 10.0, 0.001))
    monkeypatch.setattr("rigrunner_panel.process.link.monotonic", lambda: next(now_s))
    pipe = io.BytesIO()
    sender = Sender(Channel(io.BytesIO(), pipe))
    for point in range(1000):
        row = {"step": "s", "point": point, "measurement": "m", "setpoints": {}, "values": {}}
        sender(Scanned(seq=point, **row, **STAMP))
    sender(Note(seq=1000, step="s", text="t", **STAMP))
    sender.close()
    numbers, channel = [], Channel(io.BytesIO(pipe.getvalue()), io.BytesIO())
    with suppress(ChannelClosedError):
        while True:
            numbers.append(channel.receive().seq)
    assert (numbers[0], numbers[-2:]) == (0, [999, 1000])
    assert numbers == sorted(numbers)
    assert len(numbers) == pytest.approx(1000 * 0.001 / 0.05 + 2, abs=1)


def test_samples_are_sent_as_float32():
    pipe = io.BytesIO()
    sender = Sender(Channel(io.BytesIO(), pipe))
    values = np.linspace(-1, 1, 50)
    sender(Samples(seq=1, recording="r", block=Block(1e3, 100, 1.0, {"t.a": values}), **STAMP))
    sender.close()
    curve = Channel(io.BytesIO(pipe.getvalue()), io.BytesIO()).receive()
    assert isinstance(curve, Samples)
    assert (curve.recording, curve.block.first_sample, curve.monotonic_s) == ("r", 100, 1.0)
    assert curve.block.channels["t.a"].dtype == np.float32
    assert curve.block.channels["t.a"] == pytest.approx(values, abs=1e-7)


def test_file_in_working_directory_does_not_shadow_a_module(tmp_path, monkeypatch):
    (tmp_path / "numpy.py").write_text("raise SystemExit(3)", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    assert Process(ANALYST).close() == 0
