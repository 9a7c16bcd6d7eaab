"""The prompt of `rigrunner jog`: one command a line, until quit, end of input, or Ctrl-C."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from rigrunner.api.errors import AbortedError, DataError, RigrunnerError, UsageError, did_you_mean
from rigrunner.api.quantity import entered_si, legible
from rigrunner.cli.boundary import show_error
from rigrunner.cli.keyboard import wait_for_line
from rigrunner.cli.output import message, prompt, result, unsafe_rig

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from rigrunner.cli.stopping import SignalStop
    from rigrunner.tools.by_hand.jog import Jog

LOOK_EVERY_S = 0.5
_WATCH_S = 10.0
HELP: Mapping[str, str] = {
    "set DRIVE VALUE": "such as 'set frequency 5 Hz'; waits until it is there",
    "read [CHANNEL ...]": "all channels if none is named",
    "watch CHANNEL [TIME]": "its value again and again, for 10 s if no time is given",
    "zero CHANNEL": "takes its present value as zero, for the values shown from now on",
    "positions": "the read-backs of all drives",
    "safe": "sets every drive to its safe value",
    "help": "shows this",
    "quit": "makes the rig safe and ends",
}


def run_prompt(jog: Jog, stop: SignalStop) -> None:
    """Read commands and execute them. After an error of the rig, the rig was made safe.

    An abort ends this, and so does a log that cannot be written.
    """
    _show_help(jog)
    while True:
        try:
            line = _answer(f"{jog.role}> ", jog, stop)
            words = line.split() if line is not None else ["quit"]
            if not words:
                continue
            name = words[0]
            if name in _QUIT:
                return
            if name not in _COMMANDS:
                hint = did_you_mean(name, (*_COMMANDS, *_QUIT), "'help' lists the commands")
                raise UsageError(f"there is no command '{name}'", hint=hint)
            _COMMANDS[name](jog, words[1:])
        except (AbortedError, DataError):
            raise
        except RigrunnerError as error:
            show_error(error)
            if not isinstance(error, UsageError):
                message(unsafe_rig(jog.unsafe) if jog.unsafe else "The rig was made safe.")


def show_values(jog: Jog, values: Mapping[str, float]) -> None:
    """Print values with their units, and which are relative to a zero."""
    for name, value in values.items():
        symbol = jog.channels[name].unit
        if name in jog.zeros:  # a difference, also of two temperatures
            result(f"{name} {value:.6g} {symbol}  (less its zero)")
        else:
            result(f"{name} {legible(value, symbol)}")


def show_set(jog: Jog, drive: str, actual: float) -> None:
    """Print the read-back of a drive."""
    result(f"{drive} reads back {legible(actual, jog.drives[drive].unit)}")


def _set(jog: Jog, words: list[str]) -> None:
    if len(words) < 2:  # noqa: PLR2004  (drive and value)
        raise UsageError("'set' needs a drive and a value", hint="such as 'set frequency 5 Hz'")
    show_set(jog, words[0], jog.set(words[0], " ".join(words[1:])))


def _watch(jog: Jog, words: list[str]) -> None:
    if not words:
        raise UsageError("watch what?", hint=f"one of: {', '.join(jog.channels)}")
    name, seconds = words[0], _WATCH_S
    if len(words) > 1:
        seconds = _duration(" ".join(words[1:]))
    unit = jog.channels[name].unit if name in jog.channels else ""
    values: list[float] = []
    for value in jog.watch(name, seconds):
        values.append(value)
        prompt(f"\r{name} {value:<12.6g} {unit}  " if sys.stderr.isatty() else "")
    if sys.stderr.isatty():
        message("")
    mean = sum(values) / len(values)
    result(
        f"{name} mean {mean:.6g}, from {min(values):.6g} to {max(values):.6g} {unit},"
        f" {len(values)} readings in {seconds:g} s"
    )


def _duration(text: str) -> float:
    seconds = entered_si("watch", text, "time")
    if seconds <= 0:
        raise UsageError(f"watch: got {text}, expected more than 0 s")
    return seconds


def _zero(jog: Jog, words: list[str]) -> None:
    if len(words) != 1:
        raise UsageError("zero what?", hint=f"one of: {', '.join(jog.channels)}")
    value = jog.zero(words[0])
    result(f"the zero of {words[0]} is {value:.6g} {jog.channels[words[0]].unit}")


def _positions(jog: Jog, _: list[str]) -> None:
    for drive, value in jog.read_backs().items():
        show_set(jog, drive, value)


def _show_help(jog: Jog) -> None:
    for words, text in HELP.items():
        message(f"  {words:22} {text}")
    for info in jog.drives.values():
        span, safe = info.range_text, legible(info.safe_value, info.unit)
        message(f"  drive {info.name}: {span}, safe at {safe}")
    message(f"  channels: {', '.join(jog.channels) or 'none'}")


def _answer(question: str, jog: Jog, stop: SignalStop) -> str | None:
    """Return a line, or None at the end of the input. Interlocks are monitored meanwhile."""
    prompt(question)
    with stop.while_asking(), jog.person():
        while not wait_for_line(LOOK_EVERY_S):
            jog.check_interlocks()
        line = sys.stdin.readline()
    if not sys.stdin.isatty():
        message(line.rstrip("\n"))  # show piped input like typed input
    return line or None


_QUIT = ("quit", "exit")
_COMMANDS: Mapping[str, Callable[[Jog, list[str]], object]] = {
    "set": _set,
    "read": lambda jog, names: show_values(jog, jog.read(names)),
    "watch": _watch,
    "zero": _zero,
    "positions": _positions,
    "safe": lambda jog, _: jog.safe(),
    "help": lambda jog, _: _show_help(jog),
}
