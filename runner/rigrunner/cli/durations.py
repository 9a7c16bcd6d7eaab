"""Durations as text."""

from __future__ import annotations


def steps_text(steps: int, seconds: float) -> str:
    """Return the length of a run: '45 steps, 1 min 47 s'."""
    return f"{steps} step{'' if steps == 1 else 's'}, {clock_text(seconds)}"


def clock_text(seconds: float) -> str:
    """Return a duration as text: '45 s', '3 min 05 s', '2 h 10 min'."""
    minutes, left_s = divmod(round(seconds), 60)
    hours, left_min = divmod(minutes, 60)
    if hours:
        return f"{hours} h {left_min:02d} min"
    return f"{minutes} min {left_s:02d} s" if minutes else f"{left_s} s"
