"""The queue as it goes to the screen."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict


class EntryView(BaseModel):
    """One entry; `outcome` and `verdict` are those of its run, once that is over."""

    model_config = ConfigDict(frozen=True)

    id: int
    specimen: str
    procedure: str
    station: str
    inputs: dict[str, str]
    realtime: bool
    status: Literal[
        "proposed", "waiting", "held", "running", "done", "interrupted", "skipped", "closed"
    ]
    outcome: str
    verdict: str
    by: str
    reason: str
    repeats: int | None
    run: str


class QueueView(BaseModel):
    """The entries in the order of their runs."""

    model_config = ConfigDict(frozen=True)

    entries: tuple[EntryView, ...] = ()
    left_out: int = 0
    """Number of finished entries that are not listed here."""
    next: int | None = None
    """The entry that would start next; None if none waits, or one is interrupted."""
    starting: int | None = None
    """The entry whose preflight is being done."""
    automatic_by: str = ""
    """Who let runs start by themselves; '' if each start needs a person."""
    problem: str = ""
    """Why the last one did not start."""
