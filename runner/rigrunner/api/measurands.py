"""Which of several quantities of one unit a result is, and which one a limit is for.

An analysis with such results names the model of the key `measurand` of their limits
(`AnalysisRecord.limit_measurand`), which is a LimitedMeasurand. The core reads the key by it, and
asks it whether the limit is for a result.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from collections.abc import Mapping


class ResultMeasurand(Protocol):
    """Which quantity a result is; prints as a description."""

    @property
    def id(self) -> str:
        """Identifier for programs."""
        ...


class LimitedMeasurand(Protocol):
    """The measurand of a limit, given by its key `measurand`; prints as a description."""

    def objection(self, measurand: ResultMeasurand) -> str:
        """Return why this is not the measurand of a result; '' if it is."""
        ...

    def as_written(self) -> Mapping[str, object]:
        """Return it as a file has it; read back, it is the same."""
        ...

    def document(self) -> Mapping[str, object]:
        """Return its part of `result.json`; plain values, with a description as 'text'."""
        ...
