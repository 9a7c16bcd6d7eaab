"""Microseconds per set-point in other projects: set, read, check a limit, store.

    python setpoints.py WAY POINTS TIMES FOLDER

Prints a JSON list, one number for each time; the first, which warms caches, is left out.
"""

# ruff: noqa: PLC0415, T201  (each way imports only its project; the numbers are printed)

from __future__ import annotations

import json
import logging
import sys
import time
from pathlib import Path

HIGHEST_N, LIMIT_NM = 2000.0, 3.0


class Press:
    """The device of all ways, which only remembers its set-point."""

    def __init__(self):
        self._load_n = 0.0

    def set(self, load_n):
        self._load_n = load_n

    def read(self):
        return 1e-3 * self._load_n


def loads_n(points):
    return [HIGHEST_N * (index + 1) / points for index in range(points)]


def bluesky(points, folder):
    """A plan of the run engine; each document is a line of JSON, flushed."""
    from bluesky import RunEngine
    from bluesky import plan_stubs as do
    from ophyd import Signal
    from ophyd.sim import SynSignal

    load_n = Signal(name="load", value=0.0)
    torque_nm = SynSignal(name="torque", func=lambda: 1e-3 * load_n.get())

    def plan():
        yield from do.open_run()
        for load in loads_n(points):
            yield from do.mv(load_n, load)
            yield from do.create()
            yield from do.read(load_n)
            reading = yield from do.read(torque_nm)
            yield from do.save()
            assert reading["torque"]["value"] <= LIMIT_NM
        yield from do.close_run()

    engine = RunEngine({}, context_managers=[])
    with (folder / "documents.jsonl").open("w", encoding="utf-8") as file:

        def write(name, document):
            file.write(json.dumps([name, document], default=str) + "\n")
            file.flush()

        engine.subscribe(write)
        began = time.perf_counter()
        engine(plan())
        return time.perf_counter() - began


def openhtf_dimensioned(points, folder):
    """One phase with one measurement of all points and a validator; its JSON at the end."""
    import openhtf

    press = Press()

    def all_within(rows):
        return all(row[-1] <= LIMIT_NM for row in rows)

    torque = openhtf.Measurement("torque").with_dimensions("load").with_validator(all_within)

    @openhtf.measures(torque)
    def sweep(test):
        for load_n in loads_n(points):
            press.set(load_n)
            test.measurements.torque[load_n] = press.read()

    return _executed([sweep], folder)


def openhtf_phases(points, folder):
    """A phase with a measurement that is validated for each point; its JSON at the end."""
    import openhtf

    press = Press()

    def phase_of(load_n):
        @openhtf.PhaseOptions(name=f"at {load_n:g} N")
        @openhtf.measures(openhtf.Measurement("torque").in_range(maximum=LIMIT_NM))
        def at(test):
            press.set(load_n)
            test.measurements.torque = press.read()

        return at

    return _executed([phase_of(load_n) for load_n in loads_n(points)], folder)


def _executed(phases, folder):
    import openhtf
    from openhtf.output.callbacks import json_factory

    test = openhtf.Test(*phases)
    test.add_output_callbacks(json_factory.OutputToJSON(str(folder / "record.json")))
    began = time.perf_counter()
    passed = test.execute(test_start=lambda: "SN-1")
    seconds = time.perf_counter() - began
    assert passed
    return seconds


def pymeasure(points, folder):
    """A procedure by a worker into a file of csv, which its recorder writes in a thread."""
    from pymeasure.experiment import Procedure, Results, Worker

    class Sweep(Procedure):
        DATA_COLUMNS = ("load", "torque", "ok")

        def execute(self):
            press = Press()
            for load_n in loads_n(points):
                press.set(load_n)
                torque_nm = press.read()
                row = {"load": load_n, "torque": torque_nm, "ok": torque_nm <= LIMIT_NM}
                self.emit("results", row)
                if self.should_stop():
                    return

    path = folder / "results.csv"
    worker = Worker(Results(Sweep(), str(path)))
    began = time.perf_counter()
    worker.start()
    worker.join(600)
    seconds = time.perf_counter() - began
    lines = path.read_text(encoding="utf-8").splitlines()
    assert sum(not line.startswith("#") for line in lines) == points + 1
    return seconds


def qcodes(points, folder):
    """A data set in SQLite, written at its default interval of five seconds."""
    return _qcodes(points, folder, flush=False)


def qcodes_flushed(points, folder):
    """A data set in SQLite, each point in the database before the next."""
    return _qcodes(points, folder, flush=True)


def _qcodes(points, folder, *, flush):
    from qcodes.dataset import (
        Measurement,
        initialise_or_create_database_at,
        load_or_create_experiment,
    )
    from qcodes.parameters import ManualParameter, Parameter

    initialise_or_create_database_at(str(folder / "runs.db"))
    load_n = ManualParameter("load", unit="N", initial_value=0.0)
    torque_nm = Parameter("torque", unit="N m", get_cmd=lambda: 1e-3 * load_n.get())
    measurement = Measurement(exp=load_or_create_experiment("sweep", "SN-1"))
    measurement.register_parameter(load_n)
    measurement.register_parameter(torque_nm, setpoints=(load_n,))
    with measurement.run() as saver:
        began = time.perf_counter()
        for load in loads_n(points):
            load_n.set(load)
            torque = torque_nm.get()
            assert torque <= LIMIT_NM
            saver.add_result((load_n, load), (torque_nm, torque))
            if flush:
                saver.flush_data_to_database(block=True)
        if not flush:
            saver.flush_data_to_database(block=True)
        seconds = time.perf_counter() - began
    assert saver.dataset.number_of_results == points
    return seconds


def robot(points, folder):
    """A FOR loop of three keywords of a library; its output file is written on the way."""
    from robot import run

    (folder / "PressLibrary.py").write_text(_LIBRARY, encoding="utf-8")
    (folder / "sweep.robot").write_text(_SUITE.format(points=points), encoding="utf-8")
    sys.path.insert(0, str(folder))
    began = time.perf_counter()
    code = run(
        str(folder / "sweep.robot"), outputdir=str(folder), log=None, report=None, console="none"
    )
    seconds = time.perf_counter() - began
    assert code == 0
    return seconds


_LIBRARY = """\
load_n = 0.0


def set_load(value):
    global load_n
    load_n = float(value)


def read_torque():
    return 1e-3 * load_n


def should_be_at_most(value, limit):
    assert value <= float(limit)
"""
_SUITE = """\
*** Settings ***
Library    PressLibrary.py

*** Test Cases ***
Sweep
    FOR    ${{index}}    IN RANGE    {points}
        Set Load    ${{index}}
        ${{torque}} =    Read Torque
        Should Be At Most    ${{torque}}    3.0
    END
"""

WAYS = (
    bluesky,
    openhtf_dimensioned,
    openhtf_phases,
    pymeasure,
    qcodes,
    qcodes_flushed,
    robot,
)


def main():
    way, points, times, folder = sys.argv[1:]
    logging.disable(logging.CRITICAL)
    work = next(function for function in WAYS if function.__name__ == way)
    microseconds = []
    for number in range(int(times) + 1):
        way_folder = Path(folder) / f"{way}{number}"
        way_folder.mkdir(parents=True)
        microseconds.append(1e6 * work(int(points), way_folder) / int(points))
    print(json.dumps(microseconds[1:]))


if __name__ == "__main__":
    main()
