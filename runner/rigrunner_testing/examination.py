"""Run checks, each with a time limit; skip those that an earlier failure decides."""

from __future__ import annotations

import sys
import threading
import traceback
from dataclasses import replace
from typing import TYPE_CHECKING

from rigrunner.api.errors import MissingPackageError, RigrunnerError
from rigrunner.registry import culprit, whereabouts
from rigrunner_testing.check import Finding, Nonconformity, NotApplicable, State

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from rigrunner_testing.check import AnyCheck
    from rigrunner_testing.subjects import Subject

LONGEST_S = 120.0
"""A check that takes longer is abandoned as hanging."""
RELEASE_S = 30.0
"""Time limit for making safe and closing what it left open."""


def examine(
    subject: Subject, checks: Iterable[AnyCheck], longest_s: float = LONGEST_S
) -> Iterator[Finding]:
    """Yield the result of each check, one after the other.

    One mistake of the plugin is one failure: a check that requires a failed one is not judged, nor
    one that fails in the same way.
    """
    causes: dict[str, str] = {}  # by check that failed or was not judged, the one that failed first
    failures: dict[str, str] = {}  # by text of the failure, the check that failed first
    for check in checks:
        always = check.always and not subject.simulated
        cause = next((causes[needed] for needed in check.needs if needed in causes), "")
        if cause and not always:
            causes[check.name] = cause
            yield Finding(check, State.NOT_JUDGED, f"it needs what '{cause}' demands")
            continue
        finding = examine_one(subject, check, longest_s)
        if finding.state is State.FAIL:
            cause = failures.setdefault(finding.text, check.name)
            causes[check.name] = cause
            if cause != check.name and not always:
                text = f"it fails as '{cause}' does"
                finding = replace(finding, state=State.NOT_JUDGED, text=text, fix="")
        yield finding


def examine_one(subject: Subject, check: AnyCheck, longest_s: float = LONGEST_S) -> Finding:
    """Return the result of a check; it returns whatever the plugin does.

    Raises MissingPackageError if a package that the plugin needs is not installed, which says
    nothing about the plugin.
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
            return Finding(check, State.FAIL, str(raised), raised.fix or check.fix)
        case RigrunnerError():  # its message is for users, and has a hint
            return Finding(check, State.FAIL, raised.message, useful_hint(raised) or check.fix)
    place = culprit(raised)
    return Finding(check, State.FAIL, _crash(raised), f"correct {place}" if place else check.fix)


def conform(subject: Subject, check: AnyCheck) -> str:
    """Raise AssertionError unless the check passes; return why it does not apply, else ''.

    For a test of your own: `assert not conform(subject, check)`, or skip with the reason.
    """
    finding = examine_one(subject, check)
    if finding.state is State.FAIL:
        raise Nonconformity(f"{check.holds}\nfound: {finding.text}\nfix: {finding.fix}")
    return finding.text


def useful_hint(error: RigrunnerError) -> str:
    """Return an error's hint, unless it refers to these very checks."""
    return "" if "check-plugin" in error.hint else error.hint


def _in_time(work: Callable[[], None], longest_s: float) -> Exception | None:
    """Return the exception of a call, a Nonconformity if it does not end in time, or None.

    It runs in a thread, so that an interruption of the wait is not taken for its error.
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
    if not thread.is_alive():
        return raised[0] if raised else None
    frame = sys._current_frames().get(thread.ident or 0)  # noqa: SLF001  (Python's own way)
    place = whereabouts(frame) if frame else ""
    waits = f": it waits in {place}" if place else ""
    fix = f"wait no longer than its time-out in {place}" if place else ""
    return Nonconformity(f"it did not come back within {longest_s:g} s{waits}", fix=fix)


def _crash(error: BaseException) -> str:
    """Return the error with its place in the plugin's code, or else where it was raised."""
    frames = traceback.extract_tb(error.__traceback__)
    innermost = f"{frames[-1].filename}:{frames[-1].lineno}" if frames else ""
    place = culprit(error) or innermost
    return f"{type(error).__name__}: {error}{f' at {place}' if place else ''}"
