"""Records which tests run which lines of the sources, and how long each takes."""

from __future__ import annotations

import sys
import threading
import time
from collections import defaultdict
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

import pytest

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Iterable

Lines = dict[str, set[int]]
"""Line numbers by file."""


@dataclass(frozen=True)
class RecordedTest:
    """A test that passed, with its time and its lines."""

    name: str
    seconds: float
    lines: Lines

    def runs(self, file: str, first: int, last: int) -> bool:
        """Return whether the test runs one of these lines."""
        return any(first <= line <= last for line in self.lines.get(file, ()))


class Recorder:
    """A pytest plugin that records lines; those of a shared fixture count for all its users."""

    def __init__(self, files: Iterable[str]) -> None:
        self._files = frozenset(files)
        self._lines: dict[str, Lines] = defaultdict(lambda: defaultdict(set))
        self._current_lines = self._lines[""]
        self._seconds: dict[str, float] = defaultdict(float)
        self._fixtures: dict[str, set[str]] = {}
        self._fixture_s: dict[str, float] = {}
        self._failed: set[str] = set()

    def __enter__(self) -> Self:
        threading.settrace(self._trace_calls)
        sys.settrace(self._trace_calls)
        return self

    def __exit__(self, *_: object) -> None:
        sys.settrace(None)
        threading.settrace(None)  # type: ignore[arg-type]

    def recorded(self) -> list[RecordedTest]:
        """Return the tests that passed."""
        tests = []
        for name in self._seconds.keys() - self._failed:
            lines: Lines = defaultdict(set)
            shared = self._fixtures.get(name, set())
            for owner in {name, *shared}:
                for file, numbers in self._lines.get(owner, {}).items():
                    lines[file] |= numbers
            # A shared fixture is made by the first of its users to run.
            fixtures_s = sum(self._fixture_s.get(fixture, 0.0) for fixture in shared)
            tests.append(RecordedTest(name, self._seconds[name] + fixtures_s, dict(lines)))
        return sorted(tests, key=lambda test: (test.seconds, test.name))

    def _trace_calls(self, frame: Any, _event: str, _argument: object) -> Callable[..., Any] | None:
        file = frame.f_code.co_filename
        if file not in self._files:
            return None

        def trace_lines(frame: Any, event: str, _argument: object) -> Callable[..., Any]:
            if event == "line":
                self._current_lines[file].add(frame.f_lineno)
            return trace_lines

        return trace_lines

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Generator[None, object, object]:
        """Record the lines of this test."""
        self._current_lines = self._lines[item.nodeid]
        fixture_info = getattr(item, "_fixtureinfo", None)
        self._fixtures[item.nodeid] = {
            _name(fixture)
            for definitions in (fixture_info.name2fixturedefs if fixture_info else {}).values()
            for fixture in definitions
            if fixture.scope != "function"
        }
        sys.settrace(self._trace_calls)  # a test may have reset it
        try:
            return (yield)
        finally:
            self._current_lines = self._lines[""]

    @pytest.hookimpl(wrapper=True)
    def pytest_fixture_setup(
        self, fixturedef: pytest.FixtureDef[Any]
    ) -> Generator[None, object, object]:
        """Record the lines of a fixture that several tests share."""
        lines_before, began_s = self._current_lines, time.monotonic()
        if fixturedef.scope != "function":
            self._current_lines = self._lines[_name(fixturedef)]
        try:
            return (yield)
        finally:
            self._current_lines = lines_before
            if fixturedef.scope != "function":
                self._fixture_s[_name(fixturedef)] = time.monotonic() - began_s

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Add the time, and leave out tests that did not pass."""
        self._seconds[report.nodeid] += report.duration
        if report.outcome != "passed" or hasattr(report, "wasxfail"):
            self._failed.add(report.nodeid)


def _name(fixture: pytest.FixtureDef[Any]) -> str:
    return f"fixture {fixture.baseid}::{fixture.argname}"


def record(files: Iterable[str], arguments: list[str]) -> list[RecordedTest]:
    """Run the tests once and return them, fastest first."""
    with Recorder(files) as recorder:
        pytest.main([*arguments, "-q", "--no-header"], plugins=[recorder])
    return recorder.recorded()
