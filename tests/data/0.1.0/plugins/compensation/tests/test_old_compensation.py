"""What must hold of the compensation old_compensation."""

from collections.abc import Callable

import pytest
from rigrunner.api.hooks import NoSettings

import rigrunner_old_compensation as plugin


@pytest.mark.conformance("compensation", "old_compensation")
def test_it_keeps_to_what_every_compensation_keeps_to(conformance: Callable[[], None]) -> None:
    """One test for each check of the conformance kit; what does not apply is skipped."""
    conformance()


def test_it_says_which_torque_it_yields() -> None:
    """Without that, no limit of a procedure can be applied to it."""
    (record,) = plugin.rigrunner_compensations()
    assert record.settings is NoSettings
    assert record.yields is not None
