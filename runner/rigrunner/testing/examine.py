"""Runs checks: each in time, and the crash of one is a failure of that one alone."""

from __future__ import annotations

import threading
import traceback
from typing import TYPE_CHECKING

from rigrunner.testing.check import Finding, Nonconformity, NotApplicable, State

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from rigrunner.testing.check import AnyCheck
    from rigrunner.testing.subject import Subject

LONGEST_S = 120.0
"""A check that takes longer is given up as hanging."""


def examine(subject: Subject, checks: Iterable[AnyCheck]) -> Iterator[Finding]:
    """Yield what each check found, one after the other."""
    for check in checks:
        yield examine_one(subject, check)


def examine_one(subject: Subject, check: AnyCheck, longest_s: float = LONGEST_S) -> Finding:
    """Return what a check found; whatever the plugin does, it comes back."""
    try:
        hangs = _in_time(lambda: check.work(subject), longest_s)
    except NotApplicable as reason:
        return Finding(check, State.NOT_APPLICABLE, str(reason))
    except Nonconformity as found:
        return Finding(check, State.FAIL, str(found))
    except Exception as error:  # noqa: BLE001  (a stranger's plugin may raise anything)
        return Finding(check, State.FAIL, _crash(error))
    finally:
        subject.release()
    if hangs:
        return Finding(check, State.FAIL, f"it did not come back within {longest_s:g} s")
    return Finding(check, State.PASS)


def conform(subject: Subject, check: AnyCheck) -> str:
    """Raise AssertionError unless the check is met; return why it does not apply, else nothing.

    For a test of your own: `assert not conform(subject, check)`, or skip with the reason.
    """
    finding = examine_one(subject, check)
    if finding.state is State.FAIL:
        raise Nonconformity(f"{check.holds}\nfound: {finding.text}\nmend: {check.mend}")
    return finding.text


def _in_time(work: Callable[[], None], longest_s: float) -> bool:
    """Return True if the work did not end in time; raise what it raises."""
    raised: list[Exception] = []

    def run() -> None:
        try:
            work()
        except Exception as error:  # noqa: BLE001  (raised below, in the caller's thread)
            raised.append(error)

    thread = threading.Thread(target=run, name="rigrunner check", daemon=True)
    thread.start()
    thread.join(longest_s)
    if raised:
        raise raised[0]
    return thread.is_alive()


def _crash(error: Exception) -> str:
    """Return the error with the place in the code that raised it."""
    frames = traceback.extract_tb(error.__traceback__)
    place = f" at {frames[-1].filename}:{frames[-1].lineno}" if frames else ""
    return f"{type(error).__name__}: {error}{place}"
