"""Runs the tests of one mutant in a separate process, without leaving files behind.

The change exists only in the memory of that process; temporary files are removed with its folder. A
changed function replaces the original in a process that has collected all tests, which takes little
time beside the tests themselves. Changes of a module or a class itself are tried in a process that
has not yet imported the sources.
"""

from __future__ import annotations

import gc
import inspect
import os
import select
import shutil
import signal
import sys
import tempfile
import time
import traceback
from collections import defaultdict
from contextlib import suppress
from dataclasses import dataclass, replace
from importlib.abc import MetaPathFinder
from importlib.machinery import SourceFileLoader
from importlib.util import spec_from_file_location
from math import inf
from pathlib import Path
from types import CodeType, FunctionType
from typing import TYPE_CHECKING

import psutil
import pytest

if TYPE_CHECKING:
    import ast
    from collections.abc import Callable, Sequence
    from importlib.machinery import ModuleSpec

    from mutation.record import RecordedTest

KILLED, HUNG, DIED, SURVIVED, UNTESTED = "killed", "hung", "died", "survived", "no test runs it"
_POLL_S = 0.1
_OUTPUT = "output"
"""The file with the output of a process."""


@dataclass(frozen=True)
class Verdict:
    """The outcome of a mutant, and the test that decided it."""

    outcome: str
    by: str = ""
    tests: int = 0
    output: str = ""
    """The output of its process."""

    @property
    def is_found(self) -> bool:
        """Whether a test detected the change."""
        return self.outcome in {KILLED, HUNG, DIED}


@dataclass(frozen=True)
class Patience:
    """The time limit of a test: a multiple of its recorded time, plus some seconds.

    An endless loop is detected by the processor time of the test, which does not depend on the load
    of the machine. A test that waits uses none; it has ten times the seconds by the clock.
    """

    times: float
    more_s: float
    between_s: float = 300.0
    """For the collection of tests, and for the time after the last."""

    def busy_s(self, test: RecordedTest) -> float:
        """Return the maximum processor time of a test."""
        return self.times * test.seconds + self.more_s

    def waiting_s(self, test: RecordedTest) -> float:
        """Return the maximum time of a test by the clock."""
        return self.times * test.seconds + 10.0 * self.more_s


@dataclass(frozen=True)
class Change:
    """A module, its file, and its changed tree."""

    module: str
    path: Path
    tree: ast.Module

    def code(self) -> CodeType:
        """Return the code of the changed module."""
        return compile(self.tree, str(self.path), "exec", dont_inherit=True)

    def functions(self) -> list[tuple[CodeType, CodeType]] | None:
        """Return the functions that differ, old and new; None if other code differs too."""
        source = self.path.read_bytes()
        return _differences(compile(source, str(self.path), "exec", dont_inherit=True), self.code())


def _differences(old: CodeType, new: CodeType) -> list[tuple[CodeType, CodeType]] | None:
    changed: list[tuple[CodeType, CodeType]] = []
    if old.co_code != new.co_code or len(old.co_consts) != len(new.co_consts):
        return None
    for old_const, new_const in zip(old.co_consts, new.co_consts, strict=True):
        if not isinstance(old_const, CodeType) or not isinstance(new_const, CodeType):
            if old_const != new_const or type(old_const) is not type(new_const):
                return None
        elif old_const.co_flags & inspect.CO_OPTIMIZED:
            if old_const != new_const:
                changed.append((old_const, new_const))
        elif (nested := _differences(old_const, new_const)) is None:  # the body of a class
            return None
        else:
            changed += nested
    return changed if old.co_names == new.co_names else None


class _ChangedLoader(SourceFileLoader):
    def __init__(self, change: Change) -> None:
        super().__init__(change.module, str(change.path))
        self._change = change

    def get_code(self, fullname: str) -> CodeType:  # noqa: ARG002  (a loader of one module)
        return self._change.code()


class _Finder(MetaPathFinder):
    """Finds the changed module instead of its file."""

    def __init__(self, change: Change) -> None:
        self._change = change

    def find_spec(self, name: str, *_: object) -> ModuleSpec | None:
        if name != self._change.module:
            return None
        path = self._change.path
        folder = [str(path.parent)] if path.name == "__init__.py" else None
        return spec_from_file_location(
            name, path, loader=_ChangedLoader(self._change), submodule_search_locations=folder
        )


class _Reporting:
    """A pytest plugin that reports which test runs, and whether it failed."""

    report: Callable[[str], None]

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        self.report(f"begun {nodeid}")

    def pytest_runtest_logfinish(self, nodeid: str) -> None:
        self.report(f"ended {nodeid}")

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed:
            self.report(f"failed {report.nodeid}")


class _Selection(_Reporting):
    """Runs the chosen tests in their order."""

    def __init__(self, names: Sequence[str], report: Callable[[str], None]) -> None:
        self._order = {name: number for number, name in enumerate(names)}
        self.report = report

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        items[:] = [item for item in items if item.nodeid in self._order]
        items.sort(key=lambda item: self._order[item.nodeid])


def try_module(change: Change, tests: Sequence[RecordedTest], patience: Patience) -> Verdict:
    """Run the tests until one fails, with the sources imported again."""
    names = [test.name for test in tests]

    def work(report: Callable[[str], None], folder: Path) -> int:
        sys.dont_write_bytecode = True
        sys.meta_path.insert(0, _Finder(change))
        files = dict.fromkeys(name.split("::")[0] for name in names)
        options = [
            "-x",
            "-q",
            "-s",
            "-n0",
            "-p",
            "no:cacheprovider",
            f"--basetemp={folder / 'pytest'}",
        ]
        return int(pytest.main([*options, *files], plugins=[_Selection(names, report)]))

    return _run_in_child(work, tests, patience)


class Collected(_Reporting):
    """A pytest plugin that collects all tests and calls `use`, which runs some of them."""

    def __init__(self, use: Callable[[Collected], None]) -> None:
        self._use = use
        self._items: dict[str, pytest.Item] = {}
        self._functions: dict[tuple[str, str, int], list[FunctionType]] = defaultdict(list)

    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        """Find all functions, and call `use`."""
        self._items = {item.nodeid: item for item in session.items}
        gc.unfreeze()
        for item in gc.get_objects():
            if isinstance(item, FunctionType):
                self._functions[_location(item.__code__)].append(item)
        gc.freeze()
        self._use(self)
        return True

    def try_functions(
        self,
        changed: Sequence[tuple[CodeType, CodeType]],
        tests: Sequence[RecordedTest],
        patience: Patience,
    ) -> Verdict:
        """Run the tests until one fails, with changed functions."""
        if not all(self._functions[_location(old)] for old, _ in changed):
            return Verdict(UNTESTED)
        chosen = [self._items[test.name] for test in tests if test.name in self._items]

        def work(report: Callable[[str], None], _: Path) -> int:
            self.report = report
            for old, new in changed:
                for function in self._functions[_location(old)]:
                    function.__code__ = new
            for item, following in zip(chosen, [*chosen[1:], None], strict=True):
                item.ihook.pytest_runtest_protocol(item=item, nextitem=following)
            return 0

        return _run_in_child(work, tests, patience)


def _location(code: CodeType) -> tuple[str, str, int]:
    return code.co_filename, code.co_qualname, code.co_firstlineno


def _run_in_child(
    work: Callable[[Callable[[str], None], Path], int],
    tests: Sequence[RecordedTest],
    patience: Patience,
) -> Verdict:
    if not tests:
        return Verdict(UNTESTED)
    folder = Path(tempfile.mkdtemp(prefix="mutant-"))
    read_end, write_end = os.pipe()
    sys.stdout.flush()
    child = os.fork()
    if child == 0:
        os.close(read_end)
        _child_main(work, folder, write_end)
    os.close(write_end)
    try:
        verdict = _watch(child, read_end, tests, patience)
        output = (folder / _OUTPUT).read_text(encoding="utf-8", errors="replace")
        return replace(verdict, output=output)
    finally:
        os.close(read_end)
        shutil.rmtree(folder, ignore_errors=True)


def _child_main(
    work: Callable[[Callable[[str], None], Path], int], folder: Path, write_end: int
) -> None:
    os.setsid()  # so that its threads and programs can be ended together
    status = 70
    try:
        os.environ.update(TMPDIR=str(folder), RIGRUNNER_LOCKS=str(folder), HOME=str(folder))
        tempfile.tempdir = None
        output = os.open(folder / _OUTPUT, os.O_RDWR | os.O_CREAT)
        for number, file in enumerate((os.open(os.devnull, os.O_RDONLY), output, output)):
            os.dup2(file, number)
        status = work(lambda text: os.write(write_end, f"{text}\n".encode()) and None, folder)
    except BaseException:  # noqa: BLE001  (a mutant may raise anything)
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)


def _watch(child: int, read_end: int, tests: Sequence[RecordedTest], patience: Patience) -> Verdict:
    """Return the verdict of the child; end it when a test fails or takes too long."""
    tests_by_name = {test.name: test for test in tests}
    process = psutil.Process(child)
    test, unfinished, begun = "", b"", set[str]()
    deadline_s, busy_deadline_s = time.monotonic() + patience.between_s, inf
    while True:
        ready, _, _ = select.select([read_end], [], [], _POLL_S)
        if not ready:
            if time.monotonic() < deadline_s and _busy_s(process) < busy_deadline_s:
                continue
            _end(child, within_s=0.0)
            return Verdict(HUNG, test, len(begun))
        piece = os.read(read_end, 65536)
        if not piece:
            break
        *lines, unfinished = (unfinished + piece).split(b"\n")
        for line in lines:
            kind, _, name = line.decode().partition(" ")
            if kind == "failed":
                _end(child, within_s=0.0)
                return Verdict(KILLED, name, len(begun))
            test = name
            begun.add(name)
            deadline_s, busy_deadline_s = time.monotonic() + patience.between_s, inf
            if kind == "begun":
                deadline_s = time.monotonic() + patience.waiting_s(tests_by_name[name])
                busy_deadline_s = _busy_s(process) + patience.busy_s(tests_by_name[name])
    code = _end(child, within_s=1.0)
    if code == 0 and len(begun) == len(tests):
        return Verdict(SURVIVED, "", len(begun))
    return Verdict(DIED, test, len(begun))


def _busy_s(process: psutil.Process) -> float:
    times = process.cpu_times()
    return float(times.user + times.system)


def _end(child: int, *, within_s: float) -> int:
    """End a process and all that it started; return its exit code, negative for a signal."""
    deadline_s = time.monotonic() + within_s
    ended_pid, status = os.waitpid(child, os.WNOHANG)
    while not ended_pid and time.monotonic() < deadline_s:
        time.sleep(0.01)
        ended_pid, status = os.waitpid(child, os.WNOHANG)
    with suppress(ProcessLookupError):
        os.killpg(child, signal.SIGKILL)
    if not ended_pid:
        _, status = os.waitpid(child, 0)
    return os.waitstatus_to_exitcode(status)
