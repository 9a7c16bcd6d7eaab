"""What drivers tell beside their answers is kept in order, and never too much of it."""

from __future__ import annotations

from rigrunner.rig.messages import MOST, DeviceMessage, DeviceMessages


def test_messages_wait_in_order_until_they_are_taken():
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


def test_a_text_that_does_not_fit_its_values_is_told_with_them_beside_it():
    messages = DeviceMessages()
    messages.log_of("press").warning("%d s", "soon")
    assert [message.text for message in messages.taken()] == ["%d s ('soon',)"]


def test_of_very_many_messages_the_first_ones_are_kept_and_that_is_told():
    messages = DeviceMessages()
    for number in range(2 * MOST):
        messages.take("press", "info", str(number))
    logged = list(messages.taken())
    assert [message.text for message in logged[:-1]] == [str(number) for number in range(MOST - 1)]
    assert (logged[-1].level, logged[-1].text.partition(" ")[0]) == ("warning", str(MOST - 1))
    assert len(logged) == MOST
