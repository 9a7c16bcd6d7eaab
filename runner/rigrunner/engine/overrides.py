"""Overrides of failed checks before a run, which the run records at its start."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Override:
    """A failed check before the start, and who overrode it."""

    what: str
    """Short name, such as 'overdue tester.torque'."""
    subject: str
    """The failed check in a sentence."""
    by: str
    reason: str
