"""Messages are sent in order, retried where that helps, and never delay the run."""

from __future__ import annotations

import logging
import threading
import time

import pytest

from helpers_waiting import wait_until
from rigrunner.api.events import Answer, Prompt
from rigrunner_plugins.listeners import notifier
from rigrunner_plugins.listeners.notifier import MOST_WAITING, DeliveryError, Notifier
from rigrunner_plugins.listeners.settings import RuleSettings
from unit.rigrunner_plugins.listeners.helpers_listeners import alarm, event, run_events


@pytest.fixture(autouse=True)
def short_pauses(monkeypatch):
    monkeypatch.setattr(notifier, "FIRST_PAUSE_S", 0.01)
    monkeypatch.setattr(notifier, "LAST_WORDS_S", 30.0)


def notifier_of(deliver, **settings):
    return Notifier(
        "test", RuleSettings(on=["alarm", "run_ended", "waits_for_answer"], **settings), deliver
    )


class Flaky:
    """Fails a number of times, then accepts every message."""

    def __init__(self, times, error):
        self.left, self.error = times, error
        self.attempts, self.got = 0, []

    def __call__(self, message):
        self.attempts += 1
        if self.left:
            self.left -= 1
            raise self.error
        self.got.append(message.text)


def test_messages_are_sent_in_order_and_the_thread_ends(tmp_path):
    flaky = Flaky(0, None)
    sink = notifier_of(flaky)
    for run_event in run_events(tmp_path):
        sink(run_event)
    sink.close()
    assert flaky.got == ["interlock hot: too hot", "The run ended: completed. Verdict: pass."]
    assert sink.lost == 0
    wait_until(lambda: not threads_of_the_sink())


def threads_of_the_sink():
    return [thread for thread in threading.enumerate() if thread.name == "to test"]


@pytest.mark.parametrize("error", [DeliveryError("500"), ConnectionRefusedError(), TimeoutError()])
def test_failed_message_is_sent_again(error):
    flaky = Flaky(3, error)
    sink = notifier_of(flaky, attempts=4)
    sink(alarm())
    wait_until(lambda: flaky.got)
    sink.close()
    assert (flaky.attempts, sink.lost) == (4, 0)


def test_end_of_the_run_is_retried_too(tmp_path):
    flaky = Flaky(3, DeliveryError("the receiver answered 503"))
    sink = notifier_of(flaky)
    for run_event in run_events(tmp_path)[-1:]:
        sink(run_event)
    sink.close()
    assert (flaky.attempts, sink.lost) == (4, 0)
    assert flaky.got == ["The run ended: completed. Verdict: pass."]


def test_unreachable_receiver_is_not_waited_for_beyond_the_limit(monkeypatch):
    monkeypatch.setattr(notifier, "FIRST_PAUSE_S", 60.0)
    flaky = Flaky(99, DeliveryError("the receiver answered 503"))
    sink = notifier_of(flaky)
    sink(alarm())
    sink.close()
    assert (flaky.attempts, sink.lost) == (1, 1)
    wait_until(lambda: not threads_of_the_sink())


def test_pause_that_has_passed_already_is_not_slept(monkeypatch):
    """A suspended program goes on after the time at which it wanted to try again."""
    times_s = iter([0.0, 0.0, 5.0])
    monkeypatch.setattr(notifier.time, "monotonic", lambda: next(times_s, 5.0))
    sink = notifier_of(Flaky(0, None))
    sink.close()
    assert sink._may_again(1.0)


def test_lost_message_is_counted_and_logged_after_the_last_attempt(caplog):
    flaky = Flaky(99, DeliveryError("the receiver answered 503"))
    sink = notifier_of(flaky, attempts=3)
    with caplog.at_level(logging.WARNING):
        sink(alarm())
        wait_until(lambda: sink.lost)
        sink.close()
    assert flaky.attempts == 3
    assert "test: 'alarm' was not delivered: the receiver answered 503" in caplog.text
    assert "test: 1 messages were not delivered" in caplog.text


@pytest.mark.parametrize("error", [DeliveryError("404", again=False), ZeroDivisionError("bug")])
def test_permanent_failure_is_not_retried_and_the_next_message_is_sent(error):
    flaky = Flaky(1, error)
    sink = notifier_of(flaky)
    sink(alarm("first"))
    sink(alarm("second"))
    wait_until(lambda: flaky.got)
    assert (flaky.attempts, sink.lost, flaky.got) == (2, 1, ["interlock hot: second"])


def test_text_of_a_library_error_is_not_logged(caplog):
    flaky = Flaky(1, ValueError("https://user:s3cret@host"))
    sink = notifier_of(flaky)
    with caplog.at_level(logging.DEBUG):
        sink(alarm())
        wait_until(lambda: sink.lost)
    assert "ValueError" in caplog.text
    assert "s3cret" not in caplog.text


def test_hanging_receiver_delays_nothing_and_the_oldest_messages_are_dropped(caplog, monkeypatch):
    monkeypatch.setattr(notifier, "LAST_WORDS_S", 0.5)
    released, texts = threading.Event(), []

    def hang(message):
        released.wait()
        texts.append(message.text)

    sink = notifier_of(hang)
    start_s = time.monotonic()
    for number in range(10 * MOST_WAITING):
        sink(alarm(str(number)))
    assert time.monotonic() - start_s < 10
    assert len(sink._waiting) == MOST_WAITING
    assert sink.lost == pytest.approx(9 * MOST_WAITING, abs=1)
    with caplog.at_level(logging.WARNING):
        sink.close()
    assert time.monotonic() - start_s < 20
    assert sink.lost == 10 * MOST_WAITING
    assert f"{10 * MOST_WAITING} messages were not delivered" in caplog.text
    released.set()


def test_prompt_is_sent_after_a_time_unless_it_is_answered():
    flaky = Flaky(0, None)
    sink = notifier_of(flaky, wait="1 s")
    sink(event(Prompt, step="a", text="first"))
    sink(event(Answer, step="a", text="yes", by="Ann"))
    asked_s = time.monotonic()
    sink(event(Prompt, step="b", text="second"))
    wait_until(lambda: flaky.got)
    assert time.monotonic() - asked_s >= 1.0
    sink(alarm())
    wait_until(lambda: len(flaky.got) == 2)
    assert flaky.got == ["The run waits for an answer: second (b)", "interlock hot: too hot"]
    sink.close()


def test_end_of_the_run_does_not_wait_for_a_prompt():
    flaky = Flaky(0, None)
    sink = notifier_of(flaky, wait="1 h")
    sink(event(Prompt, step="a", text="first"))
    start_s = time.monotonic()
    sink.close()
    assert time.monotonic() - start_s < 10
    assert (flaky.got, sink.lost) == ([], 0)
