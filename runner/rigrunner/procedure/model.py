"""A procedure as frozen models, in SI units where a dimension is known."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal, Self

from pydantic import AfterValidator, Field

from rigrunner.api.settings import ListOf, PlainText, Settings, YesNo
from rigrunner.api.units import unit
from rigrunner.interlock import Interlock
from rigrunner.procedure.acceptance import Acceptance
from rigrunner.procedure.analyses import AnalysisRef
from rigrunner.procedure.analysis_spec import AnalysisSpec, NamedAnalysisRef
from rigrunner.procedure.questions import Input
from rigrunner.procedure.steps import Parameter, Step
from rigrunner.yamlfile.names import Identifier, Name, Text

if TYPE_CHECKING:
    from rigrunner.yamlfile.document import Path


def _known_unit(symbol: str) -> str:
    return unit(symbol).symbol


class Measurand(Settings):
    """What is measured: its symbol, its name in words, its unit."""

    symbol: Text
    """Such as Td."""
    name: Text
    """In words, such as 'starting torque'."""
    unit: Annotated[str, AfterValidator(_known_unit)] | None = None
    """Of the analysis of torque a unit of torque; otherwise any."""


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
    """Of the analysis of torque; others name their results themselves."""
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
    def torque_analysis(self) -> AnalysisSpec:
        """What is asked of the analysis of torque; of a procedure without one: nothing."""
        index = self._torque_index
        return AnalysisSpec() if index is None else self.analysis[index].settings

    @property
    def torque_analysis_at(self) -> Path:
        """Where the analysis of torque stands in the file."""
        index = self._torque_index
        return ("analysis",) if index is None else ("analysis", index, self.analysis[index].name)

    @property
    def asks_nothing(self) -> bool:
        """Whether nothing is analysed: what is recorded is kept, and that is all."""
        return self.torque_analysis.asks_nothing and not self.named_analyses

    @property
    def analyses_at(self) -> tuple[tuple[Path, NamedAnalysisRef], ...]:
        """All analyses, each with where its settings stand in the file."""
        found: list[tuple[Path, NamedAnalysisRef]] = []
        for index, each in enumerate(self.analysis):
            at: Path = ("analysis", index, each.name)
            refs = each.settings.as_named if each.plugin is None else (each.plugin,)
            found += [(at, ref) for ref in refs]
        return tuple(found)

    @property
    def named_analyses(self) -> tuple[NamedAnalysisRef, ...]:
        """The analyses that name their results."""
        return tuple(plugin for _, plugin in self.named_analyses_at)

    @property
    def named_analyses_at(self) -> tuple[tuple[Path, NamedAnalysisRef], ...]:
        """The same, each with where it stands in the file."""
        return tuple(
            (("analysis", index), each.plugin)
            for index, each in enumerate(self.analysis)
            if each.plugin is not None
        )

    @property
    def _torque_index(self) -> int | None:
        return next((i for i, each in enumerate(self.analysis) if each.plugin is None), None)

    def with_named_analyses(self, named: tuple[AnalysisRef, ...]) -> Self:
        """Return the procedure with other analyses that name their results."""
        of_torque = tuple(each for each in self.analysis if each.plugin is None)
        return self.model_copy(update={"analysis": (*of_torque, *named)})

    def with_torque_analysis(self, spec: AnalysisSpec) -> Self:
        """Return the procedure with another analysis of torque; it has one."""
        changed = tuple(
            each if each.plugin is not None else AnalysisRef(each.name, spec)
            for each in self.analysis
        )
        return self.model_copy(update={"analysis": changed})
