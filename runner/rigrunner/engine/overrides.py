"""What a person lets pass before a run, so that it can be put on record as the run begins."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Override:
    """Something that stood against the start, and who let it pass."""

    what: str
    """Its short name, such as 'overdue tester.torque'."""
    subject: str
    """In a sentence."""
    by: str
    reason: str
