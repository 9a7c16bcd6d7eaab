"""A procedure as frozen models, in SI units where a dimension is known."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal, Self

from pydantic import Field

from rigrunner.api.names import Identifier, Name, Text
from rigrunner.api.settings import ListOf, PlainText, Settings, UnitSymbol, YesNo
from rigrunner.interlock import Interlock
from rigrunner.procedure.acceptance import Acceptance
from rigrunner.procedure.analyses import AnalysisRef
from rigrunner.procedure.questions import Input
from rigrunner.procedure.steps import Parameter, Step

if TYPE_CHECKING:
    from rigrunner.yamlfile.document import Path


class Measurand(Settings):
    """What is measured: its symbol, its name in words, its unit."""

    symbol: Text
    """Such as Td."""
    name: Text
    """In words, such as 'starting torque'."""
    unit: UnitSymbol | None = None
    """Of the dimension that the analysis gives; without such an analysis any."""


class Procedure(Settings):
    """A procedure: what is measured, what is done, how it is analysed, what is acceptable."""

    rigrunner: Literal["procedure/2"]
    """What this file is, and its version of the language."""
    id: Identifier
    """How runs and other procedures name it."""
    revision: Text
    """A text: put a number in quotes."""
    title: Text
    """One line for lists and for the report."""
    description: PlainText = ""
    """Why, and how, in as many words as it takes."""
    automatic_start: YesNo = False
    """Whether the next run of a queue may start by itself; otherwise a person starts each one."""
    measurand: Measurand | None = None
    """What the analysis gives that has no name of its own; others name their results themselves."""
    inputs: dict[Name, Input] = Field(default_factory=dict)
    """What is asked at the start, by name."""
    uses: Annotated[dict[Name, Text], Field(min_length=1)]
    """Role to the type of device that fills it."""
    interlocks: ListOf[Interlock] = ()
    """What is watched throughout the run, beside the station's own interlocks."""
    parameters: dict[Name, Parameter] = Field(default_factory=dict)
    """Values by name; `$name` stands for one anywhere else in the file."""
    setup: ListOf[Step] = ()
    """What is done before anything is measured."""
    main: Annotated[ListOf[Step], Field(min_length=1)]
    """What is measured."""
    teardown: ListOf[Step] = ()
    """What is done at the end, whatever happened before."""
    analysis: ListOf[AnalysisRef] = ()
    """What is computed of what was recorded; without any, nothing."""
    acceptance: Acceptance | None = None

    @property
    def analyses_at(self) -> tuple[tuple[Path, AnalysisRef], ...]:
        """All analyses, each with where its settings stand in the file."""
        return tuple(
            (("analysis", index, each.name), each) for index, each in enumerate(self.analysis)
        )

    def with_analyses(self, analyses: tuple[AnalysisRef, ...]) -> Self:
        """Return the procedure with other analyses."""
        return self.model_copy(update={"analysis": analyses})
