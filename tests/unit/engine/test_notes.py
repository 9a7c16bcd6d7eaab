"""Errors of a run are recorded as such, and an interrupt is not one of them."""

from __future__ import annotations

import threading

import pytest

from rigrunner.api.events import Note
from rigrunner.bus import Bus
from rigrunner.engine.notes import Notes


def notes_with(error):
    """Return notes whose first event cannot be emitted, and the kinds of those that follow."""
    kinds = []

    def emit(kind, *_whole, **_fields):
        kinds.append(kind.__name__)
        if len(kinds) == 1:
            raise error

    return Notes(Bus([]), emit, threading.Event()), kinds


def test_failing_sink_is_an_error_of_the_run():
    error = RuntimeError("disk")
    notes, kinds = notes_with(error)
    notes.try_emit(Note, step="main[0]", text="marginal")
    assert notes.first is error
    assert kinds == ["Note", "Alarm"]


def test_ctrl_c_during_emit_is_not_a_failing_sink():
    notes, kinds = notes_with(KeyboardInterrupt())
    with pytest.raises(KeyboardInterrupt):
        notes.try_emit(Note, step="main[0]", text="marginal")
    assert notes.first is None
    assert kinds == ["Note"]
