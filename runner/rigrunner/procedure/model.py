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
    """Symbol, such as R."""
    name: Text
    """Name in words, such as 'contact resistance'."""
    unit: UnitSymbol | None = None
    """Unit, of the dimension that the analysis yields; any unit without such an analysis."""


class Procedure(Settings):
    """A procedure: measurand, steps, analysis and limits."""

    rigrunner: Literal["procedure/2"]
    """Type and version of this file."""
    id: Identifier
    """Name of the procedure in runs and in other procedures."""
    revision: Text
    """Revision, a text; put a number in quotes."""
    title: Text
    """One line for lists and for the report."""
    description: PlainText = ""
    """Purpose and method, as a longer text."""
    automatic_start: YesNo = False
    """Whether the next run of a queue may start by itself; otherwise a person starts each one."""
    measurand: Measurand | None = None
    """Symbol and name of the result, if the analysis does not name its results itself."""
    inputs: dict[Name, Input] = Field(default_factory=dict)
    """Inputs that are asked at the start, by name."""
    uses: Annotated[dict[Name, Text], Field(min_length=1)]
    """Type of the device in each role."""
    interlocks: ListOf[Interlock] = ()
    """Interlocks throughout the run, in addition to those of the station."""
    parameters: dict[Name, Parameter] = Field(default_factory=dict)
    """Values by name, to use as `$name` elsewhere in the file."""
    setup: ListOf[Step] = ()
    """Steps before the measurement."""
    main: Annotated[ListOf[Step], Field(min_length=1)]
    """Steps of the measurement."""
    teardown: ListOf[Step] = ()
    """Steps at the end, which are always executed."""
    analysis: ListOf[AnalysisRef] = ()
    """Analyses of the recorded data; without any there are no results."""
    acceptance: Acceptance | None = None

    @property
    def analyses_at(self) -> tuple[tuple[Path, AnalysisRef], ...]:
        """All analyses, each with where its settings stand in the file."""
        return tuple((("analysis", i, ref.name), ref) for i, ref in enumerate(self.analysis))

    def with_analyses(self, analyses: tuple[AnalysisRef, ...]) -> Self:
        """Return the procedure with other analyses."""
        return self.model_copy(update={"analysis": analyses})
