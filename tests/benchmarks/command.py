"""Measure all benchmarks, or those named, and print their tables."""

from __future__ import annotations

import argparse
import importlib
import os
import sys
import time
import traceback
from dataclasses import replace
from inspect import getdoc
from pathlib import Path
from typing import TYPE_CHECKING

from benchmarks import machine
from benchmarks.frame import Scale
from benchmarks.page import write
from benchmarks.peer import Peers
from benchmarks.tables import table

if TYPE_CHECKING:
    from types import ModuleType

FOLDER = Path(__file__).resolve().parent
SHORT = "The short form: few turns, with little or nothing warmed, so it is held against no target."
PEERS = ["bluesky", "openhtf", "ophyd", "orjson", "pymeasure", "qcodes", "robotframework"]


def names() -> list[str]:
    """Return the names of the benchmarks: modules of this folder with `measure`."""
    files = sorted(FOLDER.glob("*.py"))
    return [path.stem for path in files if "\ndef measure(" in path.read_text(encoding="utf-8")]


def benchmark(name: str) -> ModuleType:
    return importlib.import_module(f"benchmarks.{name}")


def main(argv: list[str] | None = None) -> int:
    options = arguments(argv)
    scale = Scale(short=options.short, peers=Peers(options.peers))
    head = f"{machine.versions()}\nPeers: {scale.peers.versions(PEERS)}."
    head += f"\n{SHORT}" if options.short else ""
    say(head)
    sections, failed = {}, False
    for name in options.names or names():
        sections[name], error = section(name, scale)
        failed |= error
        say(f"## {name}\n\n{sections[name]}")
        if options.markdown:  # after each, so that an interruption loses nothing
            write(options.markdown, head, sections, names())
    return 1 if failed else 0


def arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(names())}")
    parser.add_argument("--short", action="store_true", help="seconds instead of minutes")
    parser.add_argument(
        "--markdown",
        type=Path,
        metavar="FILE",
        help="write the tables to a file too; in a page, those between its marks",
    )
    parser.add_argument(
        "--peers",
        type=Path,
        metavar="PYTHON",
        default=os.environ.get("RIGRUNNER_PEERS"),
        help="the Python of an environment with the extra `peers` (or RIGRUNNER_PEERS)",
    )
    options = parser.parse_args(argv)
    unknown = sorted(set(options.names) - set(names()))
    if unknown:
        parser.error(f"no benchmark {', '.join(unknown)}; there are {', '.join(names())}")
    if options.peers and not Path(options.peers).exists():
        parser.error(f"no program {options.peers}: give the path of that environment's python")
    options.peers = Path(options.peers) if options.peers else None
    return options


def section(name: str, scale: Scale) -> tuple[str, bool]:
    """Return a benchmark's docstring and table; an error does not stop the others."""
    load, began = machine.load(), time.perf_counter()
    try:
        module = benchmark(name)
        figures, about = module.measure(scale), getdoc(module) or ""
    except Exception as error:  # noqa: BLE001  (the others are still measured)
        traceback.print_exc()
        return f"Failed: {type(error).__name__}: {error}", True
    summary = f"{time.perf_counter() - began:.0f} s, load {load} at its start"
    summary += f" ({machine.now()}, commit {machine.commit()})."
    rows = [replace(figure, target=None) if scale.short else figure for figure in figures]
    return f"{about}\n\n{table(rows)}\n\n{summary}", False


def say(text: str) -> None:
    sys.stdout.write(f"{text}\n\n")
    sys.stdout.flush()
