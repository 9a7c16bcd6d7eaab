"""A device on a tape refuses wrong answers of its driver as the rig does."""

from __future__ import annotations

import pytest

from helpers_devices import FakeTester
from rigrunner.api.errors import DeviceRejectedError
from rigrunner.tape.device import taped


class Wire:
    """Performs each exchange, without a tape."""

    def exchange(self, _request, perform):
        return perform()


def device_that_answers(call, answer):
    inner = FakeTester()
    setattr(inner, call, lambda *_: answer)
    return taped(inner, Wire())


@pytest.mark.parametrize(
    ("call", "arguments", "answer"),
    [
        ("read_back", ("frequency",), None),
        ("read_back", ("frequency",), "5 Hz"),
        ("read", (["torque"],), None),
        ("read", (["torque"],), 0.2),
        ("make_safe", (), None),
        ("stream_conditions", (), None),
        ("stream_conditions", (), {"angle_alignment": 0.2}),
        ("stream_conditions", (), {"angle_alignment": ("good", "rad")}),
    ],
)
def test_wrong_answer_of_a_driver_is_refused(call, arguments, answer):
    device = device_that_answers(call, answer)
    with pytest.raises(DeviceRejectedError, match="the driver gave"):
        getattr(device, call)(*arguments)


def test_right_answers_are_passed_on():
    assert device_that_answers("read_back", 5).read_back("frequency") == 5.0
    assert device_that_answers("read", {"torque": 0.2}).read(["torque"]) == {"torque": 0.2}
    conditions = {"angle_alignment": (0.2, "rad")}
    assert device_that_answers("stream_conditions", conditions).stream_conditions() == conditions
