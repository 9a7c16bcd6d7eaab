"""An analysis of hardness, which is another quantity by each scale: a limit says by which."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from rigrunner.api.findings import ResultDefinition
from rigrunner.api.hooks import AnalysisRecord, NoSettings
from rigrunner.api.settings import Force, Settings
from rigrunner.procedure.kinds import Kinds, installed_kinds


@dataclass(frozen=True)
class Hardness:
    """What a result of the analysis is."""

    scale: str

    @property
    def id(self):
        return f"hardness.{self.scale.lower()}"

    def __str__(self):
        return f"hardness {self.scale}"


class LimitOfHardness(Settings):
    """By which scale a limit is."""

    scale: Literal["HRB", "HRC"]
    """B for soft metals, C for hardened steel."""
    load: Force | None = None
    """The load of the indenter."""

    def __str__(self):
        return f"hardness {self.scale}"

    def objection(self, measurand):
        return "" if measurand == Hardness(self.scale) else f"it is {measurand}, not {self}"

    def as_written(self):
        fields = {"scale": self.scale}
        return fields if self.load is None else fields | {"load": f"{self.load!r} N"}

    def document(self):
        return {"scale": self.scale, "text": str(self)}


class LimitOfColour(Settings):
    """A key of another analysis, which has nothing in common with that of hardness."""

    illuminant: Literal["A", "D65"]
    """The light."""

    def document(self):
        return {"illuminant": self.illuminant, "text": self.illuminant}


def analysis(name="hardness", model=LimitOfHardness, settings=NoSettings):
    """Return an analysis of one result, which has its name and is of scale C."""
    definition = ResultDefinition(name=name, unit="1", measurand=Hardness("HRC"))
    return AnalysisRecord(
        name=name,
        help="Made up.",
        settings=settings,
        factory=lambda _: None,
        yields=lambda _: (definition,),
        limit_measurand=model,
    )


def kinds(*analyses):
    """Return the installed kinds of steps, and those analyses alone."""
    return Kinds(installed_kinds().steps, {record.name: record for record in analyses})
