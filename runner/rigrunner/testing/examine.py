"""Runs checks: each in time, and the crash of one is a failure of that one alone."""

from __future__ import annotations

import threading
import traceback
from typing import TYPE_CHECKING

from rigrunner.api.errors import MissingPackageError, PluginError
from rigrunner.testing.check import Finding, Nonconformity, NotApplicable, State

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from rigrunner.testing.check import AnyCheck
    from rigrunner.testing.subject import Subject

LONGEST_S = 120.0
"""A check that takes longer is given up as hanging."""
RELEASE_S = 30.0
"""So long what it left behind may take to be made safe and closed."""


def examine(subject: Subject, checks: Iterable[AnyCheck]) -> Iterator[Finding]:
    """Yield what each check found, one after the other."""
    for check in checks:
        yield examine_one(subject, check)


def examine_one(subject: Subject, check: AnyCheck, longest_s: float = LONGEST_S) -> Finding:
    """Return what a check found; whatever the plugin does, it comes back.

    Raises MissingPackageError where what the plugin needs is not installed: that says nothing of
    the plugin.
    """
    try:
        raised = _in_time(lambda: check.work(subject), longest_s)
    finally:
        _in_time(subject.release, RELEASE_S)
    match raised:
        case None:
            return Finding(check, State.PASS)
        case MissingPackageError():
            raise raised
        case NotApplicable():
            return Finding(check, State.NOT_APPLICABLE, str(raised))
        case Nonconformity():
            return Finding(check, State.FAIL, str(raised))
        case PluginError():  # already in words, and its hint is to come here
            return Finding(check, State.FAIL, raised.message)
    return Finding(check, State.FAIL, _crash(raised))


def conform(subject: Subject, check: AnyCheck) -> str:
    """Raise AssertionError unless the check is met; return why it does not apply, else nothing.

    For a test of your own: `assert not conform(subject, check)`, or skip with the reason.
    """
    finding = examine_one(subject, check)
    if finding.state is State.FAIL:
        raise Nonconformity(f"{check.holds}\nfound: {finding.text}\nmend: {check.mend}")
    return finding.text


def _in_time(work: Callable[[], None], longest_s: float) -> Exception | None:
    """Return what the work raises, a Nonconformity if it does not end in time, or None.

    In a thread of its own, so that what breaks off the wait is never taken for the work's error.
    """
    raised: list[Exception] = []

    def run() -> None:
        try:
            work()
        except Exception as error:  # noqa: BLE001  (a stranger's plugin may raise anything)
            raised.append(error)
        except BaseException as error:  # noqa: BLE001  (it would end this thread alone, unseen)
            raised.append(Nonconformity(_crash(error)))

    thread = threading.Thread(target=run, name="rigrunner check", daemon=True)
    thread.start()
    thread.join(longest_s)
    if thread.is_alive():
        return Nonconformity(f"it did not come back within {longest_s:g} s")
    return raised[0] if raised else None


def _crash(error: BaseException) -> str:
    """Return the error with the place in the code that raised it."""
    frames = traceback.extract_tb(error.__traceback__)
    place = f" at {frames[-1].filename}:{frames[-1].lineno}" if frames else ""
    return f"{type(error).__name__}: {error}{place}"
