"""Unmet needs of an analysis are refused before the rig moves, each with its place.

The property at the end tests the converse: each accepted procedure has its result.
"""

from __future__ import annotations

import random

import pytest

from helpers_thorough import first
from helpers_workflow import (
    ALL_FREQUENCIES,
    FEW_FREQUENCIES,
    START,
    edited,
    quick_procedure,
    run,
    station_file,
)
from rigrunner.api.errors import DataError, ExitCode, InvalidFileError
from rigrunner.clock import SimulatedClock
from rigrunner.registry import load_registry
from rigrunner.run.locate import find_procedure, find_station
from rigrunner.run.prepare import plan_run
from rigrunner_bearings.api.torque import TorqueDetails

NO_LOAD = "no_load_inertia_sweep"
LOADED = "starting_torque_1000n"
STARTS = "no_load_breakaway"
RULE = "      outliers: {grubbs: {alpha: 0.05}}\n"
CHANNELS = "[tester.angle, tester.torque]"
NO_LOAD_FITS = """\
      fits:                               # of the peak over frequency; the first one is the paper's
        - polynomial: {degree: 2}
        - inertia_physical
"""
LOADED_FITS = """\
      fits:                               # of the no-load peaks; the first one serves paper_peak
        - polynomial: {degree: 2}
        - inertia_physical
"""
LATEST = "{from: latest, procedure: SSPB-NLI, max_age: 8 h, same: [station, mandrel]}"
SWEEP = """\
  - sweep:
      set: tester.frequency
      over: $frequencies
      steps:
        - settle: {cycles: 5}
        - record: {channels: [tester.angle, tester.torque], cycles: 30}
"""
UNLOADED_SWEEP = "main:\n" + SWEEP.replace("$frequencies", "[10 Hz, 20 Hz]")
OWN = (LATEST, "{from: this run}")
BREAKAWAY = "breakaway_peak: {fixture_friction: 0.008 N·m}"

# procedure, its changes, the text at the place of the problem, the message
REFUSED = [
    (NO_LOAD, [(NO_LOAD_FITS, "")], "swing_torque:",
     "the analysis names neither a fit nor a compensation, so it has no result"),
    (NO_LOAD, [(RULE, ""), ("cycles: 30}", "cycles: 3}")], "3}",
     "the analysis needs at least 6 cycles in each recording, got 3"),
    (NO_LOAD, [("cycles: 30}", "cycles: 9}")], "9}",
     "the analysis, with the rule 'grubbs', needs at least 10 cycles in each recording, got 9"),
    (NO_LOAD, [("grubbs: {alpha: 0.05}", "pauta: {}"), ("cycles: 30}", "cycles: 11}")], "11}",
     "the rule 'pauta' needs at least 12 cycles in each recording, got 11"),
    (NO_LOAD, [("cycles: 30}", "duration: 2 s}")], "2 s}",
     ("the analysis, with the rule 'grubbs', needs at least 10 cycles in each recording, "
     "got 1 at 1 Hz")),
    (LOADED, [("set: {tester.load: 0 N, tester.frequency", "set: {tester.frequency"),
              ("  - set: {tester.load: $load}\n", ""), ("tester.angle, tester", "tester")],
     CHANNELS.replace("tester.angle, ", ""),
     "the compensation 'template_inverse' needs the crank phase, and no recorded channel shows it"),
    (LOADED, [(LOADED_FITS, ""), ("primary: template_inverse", "primary: paper_peak")],
     "paper_peak: {co",
     "the compensation 'paper_peak' takes the first fit, and the procedure names none"),
    (LOADED, [("  - swing_torque:", "  - breakaway:"), ("cycles: 30}", "duration: 1 s}")],
     "template_inverse\n        - energy",
     "the compensation 'template_inverse' needs swings, and these are starts from rest"),
    (LOADED, [("        - energy\n", f"        - {BREAKAWAY}\n"),
              ("primary: template_inverse", "primary: breakaway_peak"),
              ("load_induced, condition: at_reversal", "total, condition: from_rest")],
     "breakaway_peak: {fix",
     "the compensation 'breakaway_peak' needs starts from rest, and these are swings"),
    (LOADED, [OWN], "{from: this run}",
     "the run is to be its own no-load run, and has no set-point without load"),
    (LOADED, [OWN, ("main:\n", UNLOADED_SWEEP)], "template_inverse\n        - energy",
     ("the compensation 'template_inverse' needs 4 different frequencies without load, "
     "got 10 Hz, 20 Hz")),
    (LOADED, [OWN, ("main:\n", UNLOADED_SWEEP)], "template_inverse\n        - energy",
     ("the compensation 'template_inverse' needs set-points without load for 1 Hz, 3 Hz, 5 Hz, "
     "8 Hz, 15 Hz, 18 Hz, 25 Hz, 30 Hz, 33 Hz, 35 Hz")),
    (LOADED, [OWN, ("main:\n", UNLOADED_SWEEP),
              ("primary: template_inverse", "primary: paper_peak")],
     "polynomial: {degree: 2}",
     "the fit 'polynomial' needs 4 different frequencies without load, got 10 Hz, 20 Hz"),
    (STARTS, [("times: 10", "times: 2")], "record:",
     "the analysis needs at least 3 starts at each speed and load, got 2 at 0.0333333 Hz and 0 N"),
    (STARTS, [("grubbs: {alpha: 0.05}", "pauta: {}")], "record:",
     ("the rule 'pauta' needs at least 11 starts at each speed and load, "
     "got 10 at 0.0333333 Hz and 0 N")),
    (STARTS, [("duration: 1.5 s", "duration: 0.5 s")], "0.5 s",
     "a start at 0.0333333 Hz needs more than 0.517 s, got 0.5 s"),
    (STARTS, [(CHANNELS, "[tester.torque]")], "[tester.torque]",
     "a start from rest needs an angle, and none is recorded"),
    (STARTS, [("start_frequency: $start}", "start_frequency: 0 Hz}")], "record:",
     "the analysis needs a start, and no speed is set here"),
    (STARTS, [("  - breakaway:\n      window: 5 deg\n      smoothing: 5 ms\n",
               "  - swing_torque:\n      no_load: {from: this run}\n")], "record:",
     "the analysis needs a cycle frequency, and none is set here"),
    ("paper_reproduction", [("primary: paper_peak", "primary: template_inverse")],
     "template_inverse  ",
     ("the compensation 'template_inverse' needs recorded swings, "
     "and only single values are measured")),
]  # fmt: skip
STATIONS = {STARTS: "simulated_bench", "paper_reproduction": "paper"}


def refusals(path, station):
    with pytest.raises(InvalidFileError) as caught:
        plan_run(path, station, load_registry(), SimulatedClock(START))
    return caught.value.problems


@pytest.mark.parametrize("case", REFUSED, ids=lambda case: f"{case[0]}-{case[3][:70]}")
def test_unmet_needs_of_analysis_are_refused_in_the_plan_with_place(case, tmp_path):
    name, changes, place, message = case
    path = edited(
        find_procedure(name),
        tmp_path / "p.yaml",
        **{str(i): change for i, change in enumerate(changes)},
    )
    problems = refusals(path, find_station(STATIONS.get(name, "simulated")))
    by_message = {problem.message: problem for problem in problems}

    assert message in by_message, list(by_message)
    text = path.read_text(encoding="utf-8")
    before = text[: text.index(place)]
    line, column = before.count("\n") + 1, len(before) - before.rfind("\n")
    assert str(by_message[message].location) == f"{path}:{line}:{column}"
    assert by_message[message].hint


def test_too_few_samples_per_cycle_are_refused(tmp_path):
    station = station_file(tmp_path, ("{seed: 1}", "{seed: 1, sensors: {rate: 100 Hz}}"))
    path = quick_procedure(tmp_path, NO_LOAD, (FEW_FREQUENCIES, "[5 Hz, 20 Hz]"))
    (problem,) = refusals(path, station)
    assert problem.message == (
        "the analysis needs at least 16 samples in a cycle, got 5: 100 Hz at 20 Hz"
    )
    assert str(problem.location).endswith(":31:11")


def test_secondary_compensation_may_be_inapplicable():
    path, station = find_procedure("paper_reproduction"), find_station("paper")
    assert "template_inverse " in path.read_text(encoding="utf-8")
    assert plan_run(path, station, load_registry(), SimulatedClock(START))


def test_no_load_run_without_crank_phase_is_refused_before_the_run(tmp_path):
    runs = tmp_path / "runs"
    run(quick_procedure(tmp_path, NO_LOAD, (CHANNELS, "[tester.torque]")), runs)
    with pytest.raises(DataError, match="needs the crank phase, and without load nothing shows it"):
        run(quick_procedure(tmp_path, LOADED), runs)


def test_no_load_run_with_too_few_frequencies_is_refused_before_the_run(tmp_path):
    runs, few = tmp_path / "runs", (FEW_FREQUENCIES, "[10 Hz, 20 Hz]")
    run(quick_procedure(tmp_path, NO_LOAD, few), runs)
    message = "needs 4 different frequencies without load, got 10 Hz, 20 Hz"
    with pytest.raises(DataError, match=message):
        run(quick_procedure(tmp_path, LOADED, few), runs)


def test_no_load_run_with_too_few_cycles_is_refused_before_the_run(tmp_path):
    runs = tmp_path / "runs"
    run(quick_procedure(tmp_path, NO_LOAD, ("cycles: 12}", "cycles: 10}")), runs)
    with pytest.raises(DataError, match="has 10 cycles, but 11 are needed"):
        run(quick_procedure(tmp_path, LOADED, ("grubbs: {alpha: 0.05}", "pauta: {}")), runs)


RULES = ["", *(f"      outliers: {name}\n" for name in (
    "none", "grubbs", "chauvenet", "mad", "pauta", "generalized_esd"))]  # fmt: skip
METHODS_OF_LOADED = """\
        - paper_peak: {coefficients: refit}
        - template_inverse
        - energy
"""
METHODS = ["paper_peak", "peak_same_frequency", "template_inverse", "model_inverse", "energy"]
FITS = ["", *(f"      fits: [{name}]\n" for name in (
    "polynomial", "inertia_physical", "pchip", "aicc", "{polynomial: {degree: 5}}"))]  # fmt: skip


def random_files(rng, folder):
    """Write a random no-load and a random loaded procedure, and a station."""
    cycles = rng.choice([3, 5, 6, 8, 10, 12])
    hertz = sorted(rng.sample([1, 2, 5, 8, 10, 15, 20, 30, 35], rng.randint(1, 6)))
    frequencies = "[" + ", ".join(f"{hz} Hz" for hz in hertz) + "]"
    channels = rng.choice([CHANNELS, "[tester.index, tester.torque]", "[tester.torque]", CHANNELS])
    common = [
        (RULE, rng.choice(RULES)),
        (ALL_FREQUENCIES, frequencies),
        ("cycles: 30}", f"cycles: {cycles}}}"),
        (CHANNELS, channels),
    ]
    primary = rng.choice(METHODS)
    methods = sorted({primary, rng.choice(METHODS)})
    method_lines = "".join(f"        - {name}\n" for name in methods)
    acceptance = find_procedure(LOADED).read_text(encoding="utf-8").partition("acceptance:")[2]
    no_load = [*common, (NO_LOAD_FITS, rng.choice(FITS))]
    loaded = [
        *common,
        (LOADED_FITS, rng.choice(FITS)),
        (METHODS_OF_LOADED, method_lines),
        ("primary: template_inverse", f"primary: {primary}"),
        ("acceptance:" + acceptance, ""),
    ]
    rate = rng.choice(["10 kHz", "2 kHz", "400 Hz"])
    error = rng.choice(["0 %", "-0.3 %", "0.3 %"])
    settings = (
        f"{{seed: {rng.randint(1, 99)}, frequency_error: {error}, sensors: {{rate: {rate}}}}}"
    )
    station = station_file(folder, ("{seed: 1}", settings))
    files = [
        edited(find_procedure(name), folder / f"{name}.yaml",
               **{str(i): change for i, change in enumerate(changes)})
        for name, changes in ((NO_LOAD, no_load), (LOADED, loaded))
    ]  # fmt: skip
    return station, files


@pytest.mark.parametrize("seed", first(8, range(24)))
def test_accepted_procedures_never_fail_in_analysis(seed, tmp_path):
    rng = random.Random(seed)  # noqa: S311  (variations, not secrets)
    station, files = random_files(rng, tmp_path)
    for path in files:
        try:
            finished = run(path, tmp_path / "runs", station=station)
        except (InvalidFileError, DataError):
            continue  # before the run: nothing was connected
        assert finished.error is None, finished.error
        assert finished.exit_code not in {ExitCode.DATA, ExitCode.BUG}
        assert finished.report is not None
        if TorqueDetails.of(finished.result).primary:
            assert finished.result.headline is not None, finished.result.notes
