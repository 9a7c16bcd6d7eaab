"""What must hold of the device old_device."""

from collections.abc import Callable

import pytest
from rigrunner.api.errors import PluginError
from rigrunner.testing import subject


@pytest.mark.conformance("device", "old_device")
def test_it_keeps_to_what_every_device_keeps_to(conformance: Callable[[], None]) -> None:
    """One test for each check of the conformance kit; what does not apply is skipped."""
    conformance()


def test_the_force_is_what_it_was_set_to() -> None:
    """In newtons, through the simulator."""
    device = subject("device", "old_device").make()
    device.connect(1.0)
    device.set("force", 250.0)
    assert device.read(["force"]) == {"force": 250.0}
    assert device.make_safe() == {"force": 0.0}
    device.close()


def test_a_station_must_say_where_it_is() -> None:
    """Neither an address nor 'simulated: yes'."""
    with pytest.raises(PluginError, match="host:port"):
        subject("device", "old_device", {})
