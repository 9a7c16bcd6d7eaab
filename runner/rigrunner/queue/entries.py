"""Entries of the queue: specimen, procedure and station, and their state."""

from __future__ import annotations

from typing import Literal
from unicodedata import normalize

from pydantic import BaseModel, ConfigDict, Field, model_validator

from rigrunner.api.partner_keys import ONLY
from rigrunner.engine import Interference

State = Literal["proposed", "waiting", "held", "started", "skipped", "closed"]
"""The stored state. How a started run ended is in its folder only."""
Status = Literal[
    "proposed", "waiting", "held", "running", "done", "interrupted", "skipped", "closed"
]
"""The displayed state; of a started entry it comes from the folder of its run."""
OPEN = frozenset({"proposed", "waiting", "held", "running", "interrupted"})
"""Statuses of entries that are not over."""
SPECIMEN = "specimen"
"""The input that names the specimen."""


class Draft(BaseModel):
    """The request for a run."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    procedure: str
    """The file relative to the lab folder, or the name of a shipped one."""
    station: str
    inputs: dict[str, str] = {}
    """Answers by input; others are asked for when the run starts."""
    operator: str = ""
    partners: dict[str, str] = {}
    """Partner runs by name, in place of the latest that fit."""
    realtime: bool = True
    again: str = ""
    """Why a specimen is tested again."""

    @model_validator(mode="before")
    @classmethod
    def _read_older(cls, value: object) -> object:
        """Read the key of 0.1.0 for the only partner run."""
        if isinstance(value, dict) and ONLY in value:
            run = value[ONLY]
            others = {key: item for key, item in value.items() if key != ONLY}
            return {**others, "partners": {ONLY: run}} if run else others
        return value

    @property
    def specimen(self) -> str:
        """The specimen; '' if the procedure does not ask for one."""
        return self.inputs.get(SPECIMEN, "")

    def is_same_test(self, other: Draft) -> bool:
        """Return whether both are the same specimen in the same procedure."""
        return bool(self.specimen) and (looks(self.specimen), self.procedure) == (
            looks(other.specimen),
            other.procedure,
        )


class Entry(Draft):
    """A draft with its unique number."""

    id: int
    state: State
    by: str
    """Who added it, or last changed its state."""
    added_utc: str
    reason: str = ""
    """Why it is held, skipped, closed or repeated."""
    repeats: int | None = None
    """The entry that it repeats."""
    repeated_by: str = ""
    """Who repeats the test."""
    run: str = ""
    """Id of its run, once started."""

    def remarks(self) -> tuple[Interference, ...]:
        """Return the remark for its run: why a test is repeated."""
        if self.repeats is None and not self.again:
            return ()
        what = f"tests {self.specimen} again"
        if self.repeats is not None:
            what = f"repeats entry {self.repeats}"
        subject, why = f"entry {self.id} of the queue {what}", self.again or self.reason
        return (Interference("repeat test", self.repeated_by, why, subject),)


def looks(specimen: str) -> str:
    """Return what texts have in common that look the same: case, spaces and accents aside."""
    return " ".join(normalize("NFKC", specimen).casefold().split())


class Stored(BaseModel):
    """The file."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    rigrunner: Literal["queue/1"] = "queue/1"
    next: int = Field(default=1, ge=1)
    entries: tuple[Entry, ...] = ()

    @model_validator(mode="after")
    def _check_numbers(self) -> Stored:
        """Refuse a file that was edited so that a number could stand for two entries."""
        numbers = [entry.id for entry in self.entries]
        if len({*numbers}) < len(numbers) or self.next <= max(numbers, default=0):
            raise ValueError("the numbers of entries are to be unique, and less than 'next'")
        return self
