"""The time until a command answers: a fresh process, from its start to its end.

The floor is a program of five commands in click that does nothing else. Both are started like the
script that pip installs, and from compiled code: if Python is told to write none
(PYTHONDONTWRITEBYTECODE), every start compiles our sources again, a fifth of the time of `check`.
"""

from __future__ import annotations

import json
from functools import partial

from benchmarks.frame import Figure, Scale, Work, at_most, fresh, paired, peer

BARE = """
import click

@click.group()
def program():
    "A program."

for name in ("one", "two", "three", "four", "five"):
    program.command(name=name, help="Do it.")(lambda: None)

program()
"""
OURS = "import re, sys; from rigrunner.cli.main import main; sys.exit(main())"
HELP, CHECK, PLAN = at_most(2.0), at_most(3.0), at_most(4.0)
MODELS = "a third is importing our modules, a fifth click and PyYAML, a seventh pydantic"
DEVICES = "numpy, for the devices"
COMMANDS = {
    "--help": (HELP, "importing click"),
    "--version": (HELP, "importing click"),
    "run --help": (HELP, "importing click"),
    "check starting_torque_1000n": (CHECK, MODELS),
    "check paper_reproduction": (CHECK, MODELS),
    "plugins": (None, MODELS),
    "check starting_torque_1000n --station simulated": (None, f"{MODELS}; {DEVICES}"),
    "plan starting_torque_1000n --station simulated": (PLAN, f"{MODELS}; {DEVICES}"),
}
MS = 1e-3
COUNT = """
import sys
from rigrunner.cli.main import main
calls = 0
def count(_frame, event, _what):
    global calls
    calls += event in ("call", "c_call")
sys.setprofile(count)
main(sys.argv[1:])
sys.setprofile(None)
print(f"[{len(sys.modules)}, {calls}]")
"""


def measure(scale: Scale) -> list[Figure]:
    times = scale.of(40, 1)
    figures: list[Figure] = []
    floor = partial(fresh, "-c", BARE, "--help")
    for args, (target, limit) in COMMANDS.items():
        pair = paired(partial(fresh, "-c", OURS, *args.split()), floor, times)
        if not figures:
            bare = pair.floor
            figures.append(Figure("click --help", bare.per(MS), "ms", "floor"))
        ours = pair.ours.per(MS)
        figures.append(Figure(f"rigrunner {args}", ours, "ms", "ours", pair.ratio, target, limit))
    for module in ("pytest", "robot"):
        script = ("start_up", module, scale.of(20, 3))
        figures.append(peer(scale, f"{module} --help", *script, unit="ms", floor=bare.per(MS)))
    return figures


def work() -> list[Work]:
    for arguments in (["--help"], ["check", "starting_torque_1000n"]):
        fresh("-c", COUNT, *arguments)  # compiles, and caches the installed packages
    of_help, of_check = (
        json.loads(fresh("-c", COUNT, *arguments).splitlines()[-1])
        for arguments in (["--help"], ["check", "starting_torque_1000n"])
    )
    return [
        Work("modules of --help", of_help[0], 220),
        # it looks through all installed packages for commands
        Work("calls of functions for --help", of_help[1], 45_000),
        Work("modules of check", of_check[0], 500),
        Work("calls of functions for check", of_check[1], 600_000),
    ]
