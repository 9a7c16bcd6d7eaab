"""What a procedure asks before it starts: given, asked, or its own unattended answer."""

from __future__ import annotations

import difflib
from typing import TYPE_CHECKING

from rigrunner.api.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.engine import AnswerSource
    from rigrunner.procedure import LoadedProcedure


def answer_inputs(
    procedure: LoadedProcedure, given: Mapping[str, str], answers: AnswerSource
) -> dict[str, str]:
    """Return a value for every input of a procedure; raise UsageError for one it does not have."""
    asked = procedure.model.inputs
    for name in given:
        if name not in asked:
            near = difflib.get_close_matches(name, asked, n=1)
            listing = f"it asks for: {', '.join(asked) or 'nothing'}"
            raise UsageError(
                f"{procedure.model.id} has no input '{name}'",
                hint=f"did you mean '{near[0]}'?" if near else listing,
            )
    return {
        name: given[name]
        if name in given
        else answers.ask(f"inputs.{name}", wanted.ask, wanted.unattended)
        for name, wanted in asked.items()
    }
