"""`rigrunner jog`: set and read one device manually."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from rigrunner.cli.completing import stations
from rigrunner.cli.options import (
    debugger_option,
    json_option,
    named_values,
    record_option,
    replay_option,
)
from rigrunner.cli.output import message, no_time_limits, result_json
from rigrunner.run.locate import find_station

if TYPE_CHECKING:
    from rigrunner.api.events import Event
    from rigrunner.tools.by_hand.jog import Jog


@click.command(name="jog")
@click.argument("station", shell_complete=stations)
@click.argument("role")
@click.option(
    "--set",
    "assignments",
    multiple=True,
    metavar="DRIVE=VALUE",
    help="Set a drive, such as --set frequency='5 Hz'; may be repeated.",
)
@click.option(
    "--read", "names", multiple=True, metavar="CHANNEL", help="Read a channel after that."
)
@click.option(
    "--log",
    type=click.Path(path_type=Path, dir_okay=False),
    default=Path("jog.log"),
    show_default=True,
    help="Add a log of all actions to this file.",
)
@click.option("--realtime", is_flag=True, help="Run a simulated rig in real time.")
@debugger_option
@record_option
@replay_option
@json_option
def command(  # noqa: PLR0917  (click hands over each option)
    station: str,
    role: str,
    assignments: tuple[str, ...],
    names: tuple[str, ...],
    log: Path,
    record: Path | None,
    replay: Path | None,
    *,
    realtime: bool,
    debugger: bool,
    as_json: bool,
) -> None:
    """Set and read one device manually, within the limits of its station.

    Without --set and --read it has a prompt. Limits, combinations and interlocks apply as in a
    run; however it ends, the rig is made safe.
    """
    from rigrunner.cli.jogging import run_prompt
    from rigrunner.cli.left_rig import TerminalPerson
    from rigrunner.cli.stopping import stop_on_signals
    from rigrunner.run.taping import tape_for
    from rigrunner.tools.by_hand.jog import jogging
    from rigrunner.tools.by_hand.settling import settle_left
    from rigrunner.tools.by_hand.station import ready_station

    set_points = named_values(assignments)
    if debugger:
        message(no_time_limits())
    tape = tape_for(record, replay)
    if replay is not None:
        message(f"Replaying the tape {replay}: no instrument is used.")
    person, file = TerminalPerson(attended=not set_points and not names), find_station(station)
    if replay is None:
        settle_left(file, person, always=record is not None)
    ready = ready_station(file, realtime=realtime, tape=tape, time_limits=not debugger)
    listeners = [_show]
    with (
        stop_on_signals() as stop,
        jogging(ready, role, log, stop, listeners, person=person) as jog,
    ):
        if set_points or names:
            _once(jog, set_points, names, as_json=as_json)
        else:
            run_prompt(jog, stop)
    for text in tape.notes() if tape else ():
        message(f"note: {text}")


def _once(jog: Jog, set_points: dict[str, str], names: tuple[str, ...], *, as_json: bool) -> None:
    from rigrunner.cli.jogging import show_set, show_values

    actual = {}
    for drive, text in set_points.items():
        actual[drive] = jog.set(drive, text)
        if not as_json:
            show_set(jog, drive, actual[drive])
    values = jog.read(names) if names else {}
    if as_json:
        result_json({"set": actual, "read": values})
    else:
        show_values(jog, values)


def _show(event: Event) -> None:
    """Print what the rig does by itself: alarms, interlocks, and how it was made safe."""
    from rigrunner.api.events import InterlockCleared, InterlockTripped, MadeSafe
    from rigrunner.run.log import event_text

    is_one_drive = isinstance(event, MadeSafe) and "." in event.what and not event.problems
    if isinstance(event, (InterlockTripped, InterlockCleared, MadeSafe)) and not is_one_drive:
        message(event_text(event))
