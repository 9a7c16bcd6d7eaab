"""Messages of drivers are kept in order, and not too many of them."""

from __future__ import annotations

from rigrunner.rig.messages import MOST, DeviceMessage, DeviceMessages


def test_messages_are_taken_in_order():
    messages = DeviceMessages()
    assert not messages
    messages.log_of("press").info("warm after %d s", 30)
    messages.log_of("oven").error("door open")
    assert messages
    assert list(messages.taken()) == [
        DeviceMessage("press", "info", "warm after 30 s"),
        DeviceMessage("oven", "error", "door open"),
    ]
    assert list(messages.taken()) == []


def test_text_that_does_not_fit_its_values_is_kept_with_them():
    messages = DeviceMessages()
    messages.log_of("press").warning("%d s", "soon")
    assert [message.text for message in messages.taken()] == ["%d s ('soon',)"]


def test_excess_messages_are_dropped_with_a_warning():
    messages = DeviceMessages()
    for number in range(2 * MOST):
        messages.take("press", "info", str(number))
    logged = list(messages.taken())
    assert [message.text for message in logged[:-1]] == [str(number) for number in range(MOST - 1)]
    assert (logged[-1].level, logged[-1].text.partition(" ")[0]) == ("warning", str(MOST - 1))
    assert len(logged) == MOST
