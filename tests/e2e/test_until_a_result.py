"""A loop that ends by a result of the measurements so far; also after kill -9."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from itertools import accumulate
from pathlib import Path

import pytest

from e2e.helpers_resume import resume_run
from helpers_any_quantity import STATION, written
from helpers_cli import call
from helpers_thorough import first
from helpers_workflow import run
from rigrunner.api.events import Note
from rigrunner.run.locate import find_procedure
from rigrunner.runfile import read

TESTS = Path(__file__).parents[1]
LIMIT_NM = 0.036
PROCEDURE = """\
rigrunner: procedure/2
id: UNTIL
revision: "A"
title: Measured until the highest is above a value
uses: {tester: swing_tester}
main:
  - repeat:
      until: {result: highest, above: 36 mN·m}
      at_most: 40
      as: block
      steps:
        - wait: {time: 1 s}
        - measure: {channels: [tester.torque], name: rest}
  - note: {text: the end}
analysis:
  - readings: {of: tester.torque, statistic: maximum, result: {name: highest, unit: N·m}}
"""
KILLED_AT = 4
"""The pass in which the run is killed; the loop takes more, see `passes_due`."""
PROGRAM = """\
import os, signal, sys
from pathlib import Path
from helpers_workflow import run
from rigrunner.api.events import StepStarted

def kill(event):
    if isinstance(event, StepStarted) and event.step == sys.argv[3]:
        os.kill(os.getpid(), signal.SIGKILL)

run(Path(sys.argv[1]), Path(sys.argv[2]), listeners=[kill])
"""


@pytest.fixture
def procedure(tmp_path):
    path = tmp_path / "until.yaml"
    path.write_text(PROCEDURE, encoding="utf-8")
    return path


def values(folder):
    return [row.values["tester.torque"] for row in read(folder).measurements]


def passes_due(measured):
    """Return the pass, from 1, in which the highest measured value is first above the limit."""
    highest = list(accumulate(measured, max))
    return next(n for n, value in enumerate(highest, 1) if value > LIMIT_NM)


def test_loop_ends_with_the_pass_that_reaches_the_result(procedure, tmp_path):
    notes = []
    done = run(procedure, tmp_path / "runs", listeners=[notes.append])
    measured = values(done.folder)
    assert KILLED_AT < len(measured) < 40
    assert passes_due(measured) == len(measured)
    texts = [note.text for note in notes if isinstance(note, Note)]
    assert len(texts) == len(measured) + 1, "one for each pass, and the procedure's own"
    assert texts[0].endswith("not above 36 mN·m after 1 of 40 times")
    assert texts[-2] == (
        f"highest is {1000 * max(measured):.6g} mN·m: above 36 mN·m after {len(measured)} of 40"
        " times"
    )
    assert texts[-1] == "the end"


def test_plan_has_the_worst_case(procedure):
    planned = call("plan", procedure, "--station", "simulated")
    assert planned.out.count("Measure tester.torque, once") == 40
    assert "Until highest is above 36 mN·m: 40 of at most 40 times" in planned.out


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="kill -9 needs a Unix")
@pytest.mark.parametrize("step", first(1, ["until", "steps[1].measure"]))
def test_resumed_run_ends_by_the_same_rule(procedure, tmp_path, step):
    at = f"main[0].repeat[{KILLED_AT - 1}].{step}"
    killed = subprocess.run(
        [sys.executable, "-c", PROGRAM, procedure, tmp_path / "runs", at],
        env={**os.environ, "PYTHONPATH": f"{TESTS}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"},
        check=False,
        capture_output=True,
        text=True,
    )
    assert killed.returncode == -signal.SIGKILL, killed.stderr
    (folder,) = (tmp_path / "runs").iterdir()
    before = values(folder)
    assert len(before) == KILLED_AT - (step != "until")
    done = resume_run(folder)
    assert done.outcome == "completed"
    measured = values(folder)
    assert measured[: len(before)] == before
    assert passes_due(measured) == len(measured)


SEVERAL = PROCEDURE.replace(
    "until: {result: highest, above: 36 mN·m}",
    "until: [{channel: tester.torque, below: -1 N·m}, {result: highest, above: 36 mN·m}]",
)


AT_A_PLACE_BEFORE = """\
rigrunner: procedure/2
id: PSU
revision: "A"
title: A place that was measured before another one
uses: {bench: supply_bench}
main:
  - sweep: {set: bench.current, over: [5 A, 0 A], steps: [measure: {channels: [bench.voltage]}]}
  - set: {bench.current: 5 A}
  - repeat:
      until: {result: voltage, below: 12 V}
      at_most: 3
      steps: [measure: {channels: [bench.voltage]}]
analysis:
  - readings: {of: bench.voltage, per: bench.current, result: {name: voltage, unit: V}}
"""


def test_place_measured_last_counts(tmp_path):
    """Earlier it was the place measured first, seen last: 0 A, with 12.031 V."""
    procedure, station = written(tmp_path, procedure=AT_A_PLACE_BEFORE)
    notes = []
    run(procedure, tmp_path / "runs", station=station, listeners=[notes.append])
    (text,) = [note.text for note in notes if isinstance(note, Note)]
    assert text == "voltage is 11.987 V: below 12 V after 1 of 3 times"


def test_run_without_a_value_says_why(tmp_path):
    divided = "of: bench.voltage, divided_by: bench.ripple, per"
    text = AT_A_PLACE_BEFORE.replace("of: bench.voltage, per", divided)
    text = text.replace("[bench.voltage]", "[bench.voltage, bench.ripple]")
    text = text.replace("unit: V", 'unit: "%"').replace("below: 12 V", "below: 12 %")
    procedure, station = written(tmp_path, procedure=text, station=STATION.replace("9 mV", "0 mV"))
    done = run(procedure, tmp_path / "runs", station=station)
    assert done.outcome == "error"
    assert "There is no value of voltage at bench.current = 5 A: bench.ripple is 0" in done.reason


def test_first_condition_met_of_several_ends_the_loop(procedure, tmp_path):
    assert SEVERAL != PROCEDURE
    procedure.write_text(SEVERAL, encoding="utf-8")
    measured = values(run(procedure, tmp_path / "runs").folder)
    assert passes_due(measured) == len(measured) < 40
    first = SEVERAL.replace("below: -1 N·m", "below: 1 N·m")
    procedure.write_text(first, encoding="utf-8")
    assert len(values(run(procedure, tmp_path / "others").folder)) == 1


def test_mistake_in_one_of_several_conditions_is_located(procedure):
    wrong = SEVERAL.replace("result: highest, above", "result: higest, above")
    procedure.write_text(wrong.replace("channel: tester.torque", "channel: tester.tork"), "utf-8")
    checked = call("check", procedure, "--station", "simulated")
    assert checked.code == 3
    assert "until[0].channel: the device in the role 'tester' has no channel 'tork'" in checked.err
    assert "until[1].result: there is no result 'higest'" in checked.err


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("result: highest", "result: higest", "until.result: there is no result 'higest' of what"),
        ("above: 36 mN·m", "above: 36 mN", "until.above: '36 mN' is a force; highest is a torque"),
        (
            "above: 36 mN·m",
            "above: 36 mJ",
            "until.above: '36 mJ' is an energy; highest is a torque",
        ),
        ("result: highest,", "result: highest, channel: a.b,", "expected one of: channel, result"),
        ("result: highest,", "of: highest,", "unknown key 'of'"),
    ],
)
def test_impossible_end_of_a_loop_is_refused(procedure, old, new, words):
    procedure.write_text(PROCEDURE.replace(old, new), encoding="utf-8")
    checked = call("check", procedure)
    assert checked.code == 3
    assert words in checked.err


def test_loop_can_end_by_a_torque(tmp_path):
    """A torque is computed from the recordings so far, like any other result."""
    shipped = find_procedure("no_load_breakaway")
    starts = "  - repeat:\n      times: 10\n      steps:\n"
    text = shipped.read_text(encoding="utf-8").replace("rest: 30 s", "rest: 1 s")
    assert starts in text
    loop = "  - repeat:\n      until: {result: torque, LIMIT}\n      at_most: 2\n      steps:\n"
    inner = text.partition(starts)[2].partition("\n\n")[0]
    indented = "".join(f"    {line}\n" for line in (starts + inner).splitlines())
    looped = text.replace(starts + inner, loop + indented.rstrip())
    path = tmp_path / "until.yaml"
    path.write_text(looped.replace("LIMIT", "below: 10 N"), encoding="utf-8")
    checked = call("check", path)
    assert checked.code == 3
    assert "until.below: '10 N' is a force; torque is a torque" in checked.err
    path.write_text(looped.replace("LIMIT", "below: 10 N·m"), encoding="utf-8")
    runs = tmp_path / "runs"
    done = call("run", path, "--station", "simulated_bench", "--unattended", "--runs", runs)
    assert done.code == 0, done.err
    (folder,) = runs.iterdir()
    assert len(read(folder).recordings) == 10
