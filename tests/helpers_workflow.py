"""Runs through the whole workflow on the simulated station, in simulated time."""

from __future__ import annotations

import sys
import threading
from datetime import UTC, datetime
from functools import lru_cache

from rigrunner.clock import SimulatedClock
from rigrunner.engine import UnattendedAnswers
from rigrunner.registry import load_registry
from rigrunner.run.inputs import answer_inputs
from rigrunner.run.locate import find_procedure, find_station, shipped_folder
from rigrunner.run.partners import partners_for
from rigrunner.run.prepare import plan_run
from rigrunner.run.record import execute

START = datetime(2026, 3, 1, 12, 0, tzinfo=UTC)
ALL_FREQUENCIES = "[1 Hz, 3 Hz, 5 Hz, 8 Hz, 10 Hz, 15 Hz, 18 Hz, 20 Hz, 25 Hz, 30 Hz, 33 Hz, 35 Hz]"
FEW_FREQUENCIES = "[8 Hz, 15 Hz, 20 Hz, 25 Hz, 35 Hz]"


def registry():
    """Return the plugins that are installed, loaded once for each sys.path.

    A plugin that defines a unit defines it for its test alone: it is loaded each time.
    """
    installed = _registry((*sys.path,))
    return (
        load_registry() if any(plugin.kind == "unit" for plugin in installed.plugins) else installed
    )


@lru_cache
def _registry(_path):
    return load_registry()


def edited(source, target, **replacements):
    """Write a copy of a shipped file with texts replaced; each must be there."""
    text = source.read_text(encoding="utf-8")
    for old, new in replacements.values():
        assert old in text, old
        text = text.replace(old, new)
    target.write_text(text, encoding="utf-8")
    return target


def quick_procedure(folder, name, *changes):
    """Write a shipped procedure with fewer frequencies and cycles, and further changes."""
    replacements = [
        (ALL_FREQUENCIES, FEW_FREQUENCIES),
        ("cycles: 30}", "cycles: 12}"),
        *changes,
    ]
    return edited(
        find_procedure(name),
        folder / f"{name}.yaml",
        **{str(index): pair for index, pair in enumerate(replacements)},
    )


def station_file(folder, *changes):
    source = shipped_folder() / "stations" / "simulated.yaml"
    return edited(
        source, folder / "station.yaml", **{str(i): pair for i, pair in enumerate(changes)}
    )


def run(
    procedure,
    runs,
    *,
    station=None,
    clock=None,
    no_load=None,
    partners=None,
    listeners=(),
    stop=None,
    given=None,
):
    """Plan and execute one procedure, unattended; return the FinishedRun.

    `partners` are runs by their names; `no_load` is the one of that name.
    """
    partners = partners or ({"no_load": str(no_load)} if no_load else {})
    clock = clock or SimulatedClock(START)
    answers = UnattendedAnswers()
    planned = plan_run(procedure, station or find_station("simulated"), registry(), clock)
    return execute(
        planned,
        runs=runs,
        inputs=answer_inputs(planned.procedure, given or {}, answers),
        partners=partners_for(planned, runs, partners),
        answers=answers,
        stop=stop or threading.Event(),
        listeners=listeners,
    )
