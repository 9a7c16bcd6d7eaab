"""A rig as the overview shows it: what must be read across the room, and nothing else."""

from __future__ import annotations

from rigrunner_panel.view.sections import Phase, Section, StepView


class RigView(Section):
    """A summary of one rig; the rest is in its own state."""

    station: str
    """The name by which requests name the rig."""
    title: str
    problem: str = ""
    """Why its station cannot be used."""
    phase: Phase
    asked: str
    control: str
    """Who has control; '' for no one."""
    kind: str = ""
    """Of the present or last job: 'preflight', 'run' or 'manual'."""
    procedure: str = ""
    """The title of its procedure."""
    specimen: str = ""
    run: str = ""
    step: StepView | None = None
    number: int = 0
    """Which one of the steps it is, from 1."""
    steps: int = 0
    done_s: int = 0
    left_s: int = 0
    waits_for: str = ""
    """The question to a person, or why the run is paused."""
    alarms: tuple[str, ...] = ()
    """Those that are active."""
    outcome: str = ""
    verdict: str = ""
    result: str = ""
    reason: str = ""
    """Why the last run ended, or did not start."""
    waiting: int = 0
    """Entries of its queue that wait."""
    next: str = ""
    """The specimen of the next one."""
    automatic_by: str = ""


class Rigs(Section):
    """All rigs of the panel, by the names of their stations."""

    rigs: tuple[RigView, ...]
