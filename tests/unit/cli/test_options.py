from __future__ import annotations

import pytest

from rigrunner.api.errors import UsageError
from rigrunner.cli.options import named_values


def test_inputs_are_pairs_and_a_value_may_hold_anything():
    assignments = ["specimen=SN-17", "note=a = b"]
    assert named_values(assignments) == {"specimen": "SN-17", "note": "a = b"}


@pytest.mark.parametrize("text", ["specimen", "specimen=", "specimen=  ", "=SN-17", ""])
def test_what_is_no_pair_is_refused_with_an_example(text):
    with pytest.raises(UsageError, match="--set specimen=SN-17"):
        named_values([text])


def test_an_input_that_is_given_twice_is_refused():
    with pytest.raises(UsageError, match="specimen"):
        named_values(["specimen=1", "specimen=2"])
