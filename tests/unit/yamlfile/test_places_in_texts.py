"""The location in the file of a character of a text, in each YAML style."""

from __future__ import annotations

import pytest
from pydantic import field_validator

from rigrunner.api.errors import InvalidFileError
from rigrunner.api.settings import Settings
from rigrunner.signal.expression.syntax import parse as parse_formula
from rigrunner.yamlfile import parse, validate

WRITTEN = {
    "plain": "model: U + I * q",
    "in single quotes": "model: 'U + I * q'",
    "in double quotes": 'model: "U + I * q"',
    "plain, over two lines": "model: U + I\n    * q",
    "as a block": "model: |\n  U + I\n    * q\n",
    "folded": "model: >-\n  U + I\n  * q\n",
    "in a flow mapping": "{model: U + I*q}",
    "after letters of two bytes": "model:  # °Ω\n  U + I * q",
}


class Formula(Settings):
    model: str

    @field_validator("model")
    @classmethod
    def _is_read(cls, model):
        parse_formula(model, {"U", "I"})
        return model


@pytest.mark.parametrize("written", WRITTEN.values(), ids=WRITTEN)
def test_location_is_that_of_the_character(written):
    """The q is the error, and the location is its line and column in the file."""
    before = written[: written.index("q")]
    expected = before.count("\n") + 1, len(before) - before.rfind("\n")
    with pytest.raises(InvalidFileError) as caught:
        validate(Formula, parse(written, "a.yaml"))
    (problem,) = caught.value.problems
    assert "'q' is not known" in problem.message
    assert (problem.location.line, problem.location.column) == expected


def test_location_in_a_text_with_escapes_is_that_of_the_text():
    with pytest.raises(InvalidFileError) as caught:
        validate(Formula, parse('model: "U\\x2b q"', "a.yaml"))
    assert caught.value.problems[0].location.column == 8
