from __future__ import annotations

import pytest

from rigrunner.api.errors import UsageError
from rigrunner.cli.options import named_values


def test_value_may_contain_an_equals_sign():
    assignments = ["specimen=SN-17", "note=a = b"]
    assert named_values(assignments) == {"specimen": "SN-17", "note": "a = b"}


@pytest.mark.parametrize("text", ["specimen", "specimen=", "specimen=  ", "=SN-17", ""])
def test_assignment_without_name_or_value_is_refused(text):
    with pytest.raises(UsageError, match="--set specimen=SN-17"):
        named_values([text])


def test_duplicate_input_is_refused():
    with pytest.raises(UsageError, match="specimen"):
        named_values(["specimen=1", "specimen=2"])
