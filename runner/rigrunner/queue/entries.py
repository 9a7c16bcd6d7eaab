"""An entry of the queue: a specimen, its procedure and station, and what became of it."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from rigrunner.engine import Interference

State = Literal["proposed", "waiting", "held", "started", "skipped", "closed"]
"""What is stored. How a run that was started ended is in the run's folder, and only there."""
Status = Literal[
    "proposed", "waiting", "held", "running", "done", "interrupted", "skipped", "closed"
]
"""What a person sees: of a started entry, what its run's folder says."""
OPEN = frozenset({"proposed", "waiting", "held", "running", "interrupted"})
"""An entry of that status is not over."""
SPECIMEN = "specimen"
"""The input that names what is tested."""


class Draft(BaseModel):
    """What a run is asked for with."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    procedure: str
    """The file relative to the lab folder, or the name of a shipped one."""
    station: str
    inputs: dict[str, str] = {}
    """Answers by input; what is left out is asked when the run starts."""
    operator: str = ""
    partners: dict[str, str] = {}
    """Partner runs by name, in place of those that are found by themselves."""
    realtime: bool = True

    @model_validator(mode="before")
    @classmethod
    def _read_older(cls, value: object) -> object:
        """Read the key by which 0.1.0 named the one partner run that there was."""
        if isinstance(value, dict) and "no_load" in value:
            named = value["no_load"]
            others = {key: each for key, each in value.items() if key != "no_load"}
            return {**others, "partners": {"no_load": named}} if named else others
        return value

    @property
    def specimen(self) -> str:
        """What is tested; '' where the procedure does not ask."""
        return self.inputs.get(SPECIMEN, "")

    def is_same_test(self, other: Draft) -> bool:
        """Say whether both are the same specimen in the same procedure."""
        return bool(self.specimen) and (self.specimen.casefold(), self.procedure) == (
            other.specimen.casefold(),
            other.procedure,
        )


class Entry(Draft):
    """A draft with its number, which no other entry ever has."""

    id: int
    state: State
    by: str
    """Who added it, or who changed its state last."""
    added_utc: str
    reason: str = ""
    """Why it is held, skipped, closed or repeated."""
    repeats: int | None = None
    """The entry that it repeats."""
    repeated_by: str = ""
    """Who wanted that."""
    run: str = ""
    """The id of its run, once the run has begun."""

    def told(self) -> tuple[Interference, ...]:
        """Return what the record of its run says of the queue: why a test is made again."""
        if self.repeats is None:
            return ()
        subject = f"entry {self.id} of the queue repeats entry {self.repeats}"
        return (Interference("repeat test", self.repeated_by, self.reason, subject),)


class Stored(BaseModel):
    """The file."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    rigrunner: Literal["queue/1"] = "queue/1"
    next: int = Field(default=1, ge=1)
    entries: tuple[Entry, ...] = ()
