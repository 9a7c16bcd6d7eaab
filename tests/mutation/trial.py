"""One mutant against its tests, in a process of its own that leaves nothing behind.

The change exists in the memory of that process alone; temporary files go with its folder. A changed
function is put in the place of the original in a process that has collected all tests, which takes
little beside the tests themselves. What changes a module or a class itself is tried in a process
that has imported nothing of the sources as yet.
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
_LOOK_EVERY_S = 0.1
_OUTPUT = "output"
"""The file of what a process prints."""


@dataclass(frozen=True)
class Verdict:
    """The outcome of a mutant, and the test that decided it."""

    outcome: str
    by: str = ""
    tests: int = 0
    output: str = ""
    """What its process printed."""

    @property
    def is_found(self) -> bool:
        """Whether a test noticed the change."""
        return self.outcome in {KILLED, HUNG, DIED}


@dataclass(frozen=True)
class Patience:
    """When a test takes so long that it has failed: by its time, and so many seconds beyond.

    A loop without an end is found by the processor time of the test, which does not depend on what
    else the machine does. One that waits uses none: the clock gives it ten times the seconds.
    """

    times: float
    more_s: float
    between_s: float = 300.0
    """For collecting tests, and for what follows upon the last."""

    def busy_s(self, test: RecordedTest) -> float:
        """Return how much processor time a test may take."""
        return self.times * test.seconds + self.more_s

    def waiting_s(self, test: RecordedTest) -> float:
        """Return how long a test may take by the clock."""
        return self.times * test.seconds + 10.0 * self.more_s


@dataclass(frozen=True)
class Change:
    """A module, the file that it is in, and the tree that it is made of instead."""

    module: str
    path: Path
    tree: ast.Module

    def code(self) -> CodeType:
        """Return what the module is made of."""
        return compile(self.tree, str(self.path), "exec", dont_inherit=True)

    def functions(self) -> list[tuple[CodeType, CodeType]] | None:
        """Return the functions that differ, old and new; None where more than functions does."""
        source = self.path.read_bytes()
        return _differing(compile(source, str(self.path), "exec", dont_inherit=True), self.code())


def _differing(old: CodeType, new: CodeType) -> list[tuple[CodeType, CodeType]] | None:
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
        elif (inside := _differing(old_const, new_const)) is None:  # the body of a class
            return None
        else:
            changed += inside
    return changed if old.co_names == new.co_names else None


class _ChangedLoader(SourceFileLoader):
    def __init__(self, change: Change) -> None:
        super().__init__(change.module, str(change.path))
        self._change = change

    def get_code(self, fullname: str) -> CodeType:  # noqa: ARG002  (the one that it was made for)
        return self._change.code()


class _Finder(MetaPathFinder):
    """Finds the changed module before its file is found."""

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
    """A plugin of pytest that tells which test is run, and whether it failed."""

    tell: Callable[[str], None]

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        self.tell(f"begun {nodeid}")

    def pytest_runtest_logfinish(self, nodeid: str) -> None:
        self.tell(f"ended {nodeid}")

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed:
            self.tell(f"failed {report.nodeid}")


class _Selection(_Reporting):
    """Runs the chosen tests in their order."""

    def __init__(self, names: Sequence[str], tell: Callable[[str], None]) -> None:
        self._place = {name: number for number, name in enumerate(names)}
        self.tell = tell

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        items[:] = [item for item in items if item.nodeid in self._place]
        items.sort(key=lambda item: self._place[item.nodeid])


def try_anew(change: Change, tests: Sequence[RecordedTest], patience: Patience) -> Verdict:
    """Run the tests until one fails, with the sources imported again."""
    names = [test.name for test in tests]

    def work(tell: Callable[[str], None], folder: Path) -> int:
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
        return int(pytest.main([*options, *files], plugins=[_Selection(names, tell)]))

    return _in_child(work, tests, patience)


class Collected(_Reporting):
    """A plugin of pytest that collects all tests, and leaves it to `use` which of them are run."""

    def __init__(self, use: Callable[[Collected], None]) -> None:
        self._use = use
        self._items: dict[str, pytest.Item] = {}
        self._functions: dict[tuple[str, str, int], list[FunctionType]] = defaultdict(list)

    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        """Look up what is there, and hand over."""
        self._items = {item.nodeid: item for item in session.items}
        gc.unfreeze()
        for thing in gc.get_objects():
            if isinstance(thing, FunctionType):
                self._functions[_place(thing.__code__)].append(thing)
        gc.freeze()
        self._use(self)
        return True

    def try_functions(
        self,
        changed: Sequence[tuple[CodeType, CodeType]],
        tests: Sequence[RecordedTest],
        patience: Patience,
    ) -> Verdict:
        """Run the tests until one fails, with other functions in the place of some."""
        if not all(self._functions[_place(old)] for old, _ in changed):
            return Verdict(UNTESTED)
        chosen = [self._items[test.name] for test in tests if test.name in self._items]

        def work(tell: Callable[[str], None], _: Path) -> int:
            self.tell = tell
            for old, new in changed:
                for function in self._functions[_place(old)]:
                    function.__code__ = new
            for item, following in zip(chosen, [*chosen[1:], None], strict=True):
                item.ihook.pytest_runtest_protocol(item=item, nextitem=following)
            return 0

        return _in_child(work, tests, patience)


def _place(code: CodeType) -> tuple[str, str, int]:
    return code.co_filename, code.co_qualname, code.co_firstlineno


def _in_child(
    work: Callable[[Callable[[str], None], Path], int],
    tests: Sequence[RecordedTest],
    patience: Patience,
) -> Verdict:
    if not tests:
        return Verdict(UNTESTED)
    folder = Path(tempfile.mkdtemp(prefix="mutant-"))
    reads, writes = os.pipe()
    sys.stdout.flush()
    child = os.fork()
    if child == 0:
        os.close(reads)
        _be_child(work, folder, writes)
    os.close(writes)
    try:
        verdict = _watch(child, reads, tests, patience)
        output = (folder / _OUTPUT).read_text(encoding="utf-8", errors="replace")
        return replace(verdict, output=output)
    finally:
        os.close(reads)
        shutil.rmtree(folder, ignore_errors=True)


def _be_child(
    work: Callable[[Callable[[str], None], Path], int], folder: Path, writes: int
) -> None:
    os.setsid()  # so that its threads and programs end with it
    status = 70
    try:
        os.environ.update(TMPDIR=str(folder), RIGRUNNER_LOCKS=str(folder), HOME=str(folder))
        tempfile.tempdir = None
        output = os.open(folder / _OUTPUT, os.O_RDWR | os.O_CREAT)
        for number, file in enumerate((os.open(os.devnull, os.O_RDONLY), output, output)):
            os.dup2(file, number)
        status = work(lambda text: os.write(writes, f"{text}\n".encode()) and None, folder)
    except BaseException:  # noqa: BLE001  (a mutant may raise anything)
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)


def _watch(child: int, reads: int, tests: Sequence[RecordedTest], patience: Patience) -> Verdict:
    """Return what the child says; end it once a test failed or takes too long."""
    tests_by_name = {test.name: test for test in tests}
    process = psutil.Process(child)
    test, unfinished, began = "", b"", set[str]()
    until_s, until_busy_s = time.monotonic() + patience.between_s, inf
    while True:
        ready, _, _ = select.select([reads], [], [], _LOOK_EVERY_S)
        if not ready:
            if time.monotonic() < until_s and _busy_s(process) < until_busy_s:
                continue
            _end(child, within_s=0.0)
            return Verdict(HUNG, test, len(began))
        piece = os.read(reads, 65536)
        if not piece:
            break
        *lines, unfinished = (unfinished + piece).split(b"\n")
        for line in lines:
            kind, _, name = line.decode().partition(" ")
            if kind == "failed":
                _end(child, within_s=0.0)
                return Verdict(KILLED, name, len(began))
            test = name
            began.add(name)
            until_s, until_busy_s = time.monotonic() + patience.between_s, inf
            if kind == "begun":
                until_s = time.monotonic() + patience.waiting_s(tests_by_name[name])
                until_busy_s = _busy_s(process) + patience.busy_s(tests_by_name[name])
    code = _end(child, within_s=1.0)
    if code == 0 and len(began) == len(tests):
        return Verdict(SURVIVED, "", len(began))
    return Verdict(DIED, test, len(began))


def _busy_s(process: psutil.Process) -> float:
    times = process.cpu_times()
    return float(times.user + times.system)


def _end(child: int, *, within_s: float) -> int:
    """End a process and all that it started; return its exit code, negative for a signal."""
    until_s = time.monotonic() + within_s
    ended_pid, status = os.waitpid(child, os.WNOHANG)
    while not ended_pid and time.monotonic() < until_s:
        time.sleep(0.01)
        ended_pid, status = os.waitpid(child, os.WNOHANG)
    with suppress(ProcessLookupError):
        os.killpg(child, signal.SIGKILL)
    if not ended_pid:
        _, status = os.waitpid(child, 0)
    return os.waitstatus_to_exitcode(status)
