"""Tries a random sample of mutants, and prints the score and the mutants that survived."""
# ruff: noqa: T201  (a command: this is its output)

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
import tomllib
from collections import Counter
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from mutation.mutants import Mutant, mutated, sample
from mutation.record import RecordedTest, record
from mutation.trial import SURVIVED, UNTESTED, Change, Collected, Patience, Verdict, try_module

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

SOURCES = (
    "runner/rigrunner/rig",
    "runner/rigrunner/rig_state",
    "runner/rigrunner/engine",
    "runner/rigrunner/steps",
    "runner/rigrunner/interlock.py",
    "runner/rigrunner/ending.py",
    "runner/rigrunner/plan/drives.py",
    "runner/rigrunner/plan/interlocks.py",
    "runner/rigrunner/plan/limits.py",
    "runner/rigrunner/plan/safety.py",
    "runner/rigrunner/station",
    "runner/rigrunner/run/guardian",
    "runner/rigrunner/run/left_energised.py",
    "runner/rigrunner/run/rig_lock.py",
    "plugins/rigrunner_plugins/decision_rules.py",
    "runner/rigrunner/analysis/verdict",
    "runner/rigrunner/run/decisions.py",
    "runner/rigrunner/certificate/validity.py",
    "runner/rigrunner/documents/certifying/certify.py",
    "runner/rigrunner/documents/verifying",
    "runner/rigrunner/proof",
    "runner/rigrunner/runfile",
    "runner/rigrunner/api/calling.py",
    "runner/rigrunner/api/cleanup.py",
    "runner/rigrunner/api/driver.py",
    "runner/rigrunner/api/limits.py",
    "runner/rigrunner/api/line_link.py",
    "runner/rigrunner/api/lines.py",
    "runner/rigrunner/api/verdict.py",
)
TESTS = (
    "tests/unit/analysis/test_decision.py",
    "tests/unit/analysis/test_details.py",
    "tests/unit/analysis/test_evidence.py",
    "tests/unit/analysis/test_following.py",
    "tests/unit/analysis/test_limits.py",
    "tests/unit/analysis/test_rules.py",
    "tests/unit/api",
    "tests/unit/certificate",
    "tests/unit/documents",
    "tests/unit/engine",
    "tests/unit/plan",
    "tests/unit/proof",
    "tests/unit/rig",
    "tests/unit/rig_state",
    "tests/unit/runfile",
    "tests/unit/station",
    "tests/unit/steps",
    "tests/unit/rigrunner_fleet/reanalysis/test_selection.py",
    "tests/unit/run/guardian",
    "tests/unit/run/test_decisions.py",
    "tests/unit/run/test_resume.py",
    "tests/unit/run/test_left_energised.py",
    "tests/unit/run/test_rig_lock.py",
    "tests/unit/run/test_salvaging.py",
    "tests/unit/run/test_shared_instruments.py",
    "tests/unit/test_ending.py",
)
"""The tests of these modules. Tests of whole commands take a hundred times as long, and run lines
without checking their effect."""
PACKAGES = ("runner", "plugins", "reports")
"""Folders of the packages that tests import."""
UNCHANGED = 50
"""Number of tests that must pass without a change first."""
EQUIVALENT = Path(__file__).with_name("equivalent.toml")


def main(arguments: Sequence[str] | None = None) -> int:
    """Return 1 if a mutant survived that is not listed as equivalent."""
    options = _parser().parse_args(arguments)
    root = options.root.resolve()
    os.chdir(root)
    package_paths = [str(root / package) for package in options.packages]
    sys.path[:0] = package_paths
    os.environ["PYTHONPATH"] = os.pathsep.join(package_paths)  # for programs that tests start
    options.tests = [test for test in options.tests if Path(test).exists()]
    paths = [path for source in options.sources for path in _modules(root / source)]
    mutants = sample(root, paths, options.mutants, options.seed)
    numbered = {n: mutant for n, mutant in enumerate(mutants, 1) if n in (options.only or [n])}
    recorded = _recorded_tests(paths, options.tests, options.keep)
    equivalent = _equivalent(options.equivalent)
    print(f"commit {_commit()}, seed {options.seed}, {len(mutants)} mutants, {len(recorded)} tests")
    began_s = time.monotonic()
    outcomes = _try_all(numbered, recorded, root, options, equivalent)
    _summarise(outcomes, equivalent, time.monotonic() - began_s)
    return int(any(not v.is_found and (m.path, m.change) not in equivalent for m, v in outcomes))


def _try_all(
    numbered: Mapping[int, Mutant],
    recorded: Sequence[RecordedTest],
    root: Path,
    options: argparse.Namespace,
    equivalent: Mapping[tuple[str, str], str],
) -> list[tuple[Mutant, Verdict]]:
    """Try all mutants: first those that change a function, in a process with the tests collected.

    Other mutants, and those that survive, are tried with the sources imported again: a change that
    acts during the import is detected only by that.
    """
    patience = Patience(options.times, options.more)
    functions: dict[int, Any] = {}
    changes: dict[int, Change] = {}
    for number, mutant in numbered.items():
        tree = mutated(mutant, (root / mutant.path).read_text(encoding="utf-8"))
        changes[number] = Change(_module(mutant.path, options.packages), root / mutant.path, tree)
        changed = changes[number].functions()
        if changed is not None:
            functions[number] = changed

    def tests_of(number: int) -> list[RecordedTest]:
        mutant = numbered[number]
        lines = mutant.lines if number in functions else (1, sys.maxsize)
        candidates = (test for test in recorded if test.runs(str(root / mutant.path), *lines))
        return _within(candidates, options.budget)

    def try_functions(collected: Collected) -> Iterator[tuple[int, Verdict]]:
        _must_pass(collected, recorded[:UNCHANGED], patience)
        killers = set[str]()
        for number, changed in functions.items():
            verdict = collected.try_functions(changed, tests_of(number), patience)
            if verdict.is_found:
                killers.add(verdict.by)
                _print_verdict(number, numbered[number], verdict, "", shown=options.verbose)
            yield number, verdict
        _must_pass(collected, [test for test in recorded if test.name in killers], patience)

    quick = dict(_run_in_fork(lambda: _collect_and_try(try_functions, options.tests)))
    verdicts = {number: Verdict(*quick[number]) for number in functions}
    for number, mutant in numbered.items():
        if number not in verdicts or verdicts[number].outcome == SURVIVED:
            verdict = verdicts[number] = try_module(changes[number], tests_of(number), patience)
            shown = options.verbose or not verdict.is_found
            _print_verdict(number, mutant, verdict, _why(equivalent, mutant), shown=shown)
        elif not verdicts[number].is_found:
            _print_verdict(number, mutant, verdicts[number], _why(equivalent, mutant), shown=True)
    return [(mutant, verdicts[number]) for number, mutant in numbered.items()]


def _collect_and_try(
    try_mutants: Callable[[Collected], Iterator[tuple[int, Verdict]]], tests: Sequence[str]
) -> list[Any]:
    """Collect the tests and return the verdicts; [] if the tests cannot be collected."""
    verdicts: list[Any] = []

    def use(collected: Collected) -> None:
        for number, verdict in try_mutants(collected):
            verdicts.append((number, [verdict.outcome, verdict.by, verdict.tests]))

    with tempfile.TemporaryDirectory() as folder:
        os.environ["HYPOTHESIS_STORAGE_DIRECTORY"] = folder
        options = ["-qq", "-s", "-n0", "-p", "no:cacheprovider", f"--basetemp={folder}/pytest"]
        sys.dont_write_bytecode = True
        if pytest.main([*options, *tests], plugins=[Collected(use)]):
            return []
    return verdicts


def _must_pass(collected: Collected, tests: Sequence[RecordedTest], patience: Patience) -> None:
    """Run tests without a change: a test that fails without one proves nothing.

    These tests do not hang, so they may take longer.
    """
    longer = replace(patience, more_s=patience.between_s)
    verdict = collected.try_functions([], tests, longer)
    if tests and verdict.outcome != SURVIVED:
        print(verdict.output)
        pytest.exit(f"without a change: {verdict.outcome} {verdict.by}", returncode=70)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m tests.mutation",
        description="Changes the sources in small ways, one at a time, and lists the changes"
        " that make no test fail.",
    )
    add = parser.add_argument
    add("--mutants", type=int, default=400, help="number of mutants (400)")
    add("--seed", type=int, default=18, help="seed of the sample (18)")
    add("--only", type=int, nargs="+", help="only these numbers, as printed")
    add("--verbose", action="store_true", help="also print mutants that a test detected")
    add("--root", type=Path, default=Path(), help="the checkout (the current folder)")
    add("--packages", nargs="+", default=PACKAGES, help="its folders of packages")
    add("--sources", nargs="+", default=SOURCES, help="files and folders to change")
    add("--tests", nargs="+", default=TESTS, help="files and folders of tests")
    add("--equivalent", type=Path, default=EQUIVALENT, help="mutants that no test can detect")
    add("--keep", type=Path, help="a cache file of the lines that each test runs")
    add("--budget", type=float, default=60.0, help="maximum seconds of tests for a mutant (60)")
    add("--times", type=float, default=10.0, help="time limit of a test: its time x this (10)")
    add(
        "--more",
        type=float,
        default=2.0,
        help="plus these seconds of processor time, or ten times as many by the clock (2)",
    )
    return parser


def _modules(path: Path) -> Iterable[Path]:
    return [path] if path.is_file() else sorted(path.rglob("*.py"))


def _module(path: str, packages: Sequence[str]) -> str:
    """Return the name by which a file is imported."""
    package = next(package for package in packages if path.startswith(f"{package}/"))
    parts = Path(path).relative_to(package).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _recorded_tests(
    paths: Sequence[Path], tests: Sequence[str], keep: Path | None
) -> list[RecordedTest]:
    """Return the tests, fastest first, from the cache file or recorded now."""
    contents = [*(path.read_bytes() for path in paths), *(test.encode() for test in tests)]
    digest = sha256(b"".join(contents)).hexdigest()
    if keep and keep.exists():
        stored = json.loads(keep.read_text(encoding="utf-8"))
        if stored["sources"] == digest:
            return [_test_from_json(*entry) for entry in stored["tests"]]
    stored = {"sources": digest, "tests": _run_in_fork(lambda: _recorded(paths, tests))}
    if keep:
        keep.write_text(json.dumps(stored), encoding="utf-8")
    return [_test_from_json(*entry) for entry in stored["tests"]]


def _test_from_json(name: str, seconds: float, lines: Mapping[str, Iterable[int]]) -> RecordedTest:
    return RecordedTest(name, seconds, {file: set(numbers) for file, numbers in lines.items()})


def _recorded(paths: Sequence[Path], tests: Sequence[str]) -> list[Any]:
    """Run the tests, and return name, time and lines of each."""
    sys.dont_write_bytecode = True
    recorded = record([str(path) for path in paths], ["-n0", "-p", "no:cacheprovider", *tests])
    return [
        (test.name, test.seconds, {file: sorted(n) for file, n in test.lines.items()})
        for test in recorded
    ]


def _run_in_fork(work: Callable[[], Any]) -> Any:
    """Return the result of a function, as JSON, from a forked process.

    This process must not import the sources.
    """
    read_end, write_end = os.pipe()
    sys.stdout.flush()
    child = os.fork()
    if child == 0:
        os.close(read_end)
        with os.fdopen(write_end, "w", encoding="utf-8") as pipe:
            json.dump(work(), pipe)
        sys.stdout.flush()
        os._exit(0)
    os.close(write_end)
    with os.fdopen(read_end, encoding="utf-8") as pipe:
        text = pipe.read()
    os.waitpid(child, 0)
    content = json.loads(text)
    if not content:
        sys.exit("no score: the tests fail without a change")
    return content


def _within(tests: Iterable[RecordedTest], budget_s: float) -> list[RecordedTest]:
    """Return the first tests that fit into the budget, at least one."""
    chosen, spent_s = list[RecordedTest](), 0.0
    for test in tests:
        spent_s += test.seconds
        if chosen and spent_s > budget_s:
            break
        chosen.append(test)
    return chosen


def _equivalent(path: Path) -> dict[tuple[str, str], str]:
    if not path.exists():
        return {}
    entries = tomllib.loads(path.read_text(encoding="utf-8")).get("mutant", [])
    return {(entry["file"], entry["change"]): entry["why"] for entry in entries}


def _commit() -> str:
    process = subprocess.run(
        ["git", "describe", "--always", "--dirty"], capture_output=True, text=True, check=False
    )
    return process.stdout.strip() or "unknown"


def _why(equivalent: Mapping[tuple[str, str], str], mutant: Mutant) -> str:
    return equivalent.get((mutant.path, mutant.change), "")


def _print_verdict(number: int, mutant: Mutant, verdict: Verdict, why: str, *, shown: bool) -> None:
    if not shown:
        return
    by = f" ({verdict.by})" if verdict.by else f" ({verdict.tests} tests)"
    outcome = f"equivalent: {why}" if why and not verdict.is_found else f"{verdict.outcome}{by}"
    print(f"{number} {mutant.path}:{mutant.lines[0]} {mutant.operator}: {outcome}")
    print(f"    {mutant.change}", flush=True)


def _summarise(
    outcomes: Sequence[tuple[Mutant, Verdict]],
    equivalent: dict[tuple[str, str], str],
    seconds: float,
) -> None:
    counts = Counter[str]()
    for mutant, verdict in outcomes:
        is_listed = (mutant.path, mutant.change) in equivalent and not verdict.is_found
        counts["equivalent" if is_listed else verdict.outcome] += 1
    detected = sum(verdict.is_found for _, verdict in outcomes)
    counted = len(outcomes) - counts["equivalent"]
    print(", ".join(f"{count} {name}" for name, count in counts.most_common()))
    missed = counts[SURVIVED] + counts[UNTESTED]
    share = f"{detected / counted:.1%}" if counted else "none"
    print(f"score {share}: {detected} of {counted} noticed, {missed} not; {seconds / 60:.0f} min")
