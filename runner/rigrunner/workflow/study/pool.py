"""Examines the cases of a study in several processes, with progress, and can be stopped."""

from __future__ import annotations

import signal
from multiprocessing import TimeoutError, get_context  # noqa: A004  (its own, not the built-in)
from typing import TYPE_CHECKING, TypeVar

from rigrunner.api.errors import AbortedError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from multiprocessing.pool import IMapIterator

    from rigrunner.api.devices import StopToken

Case = TypeVar("Case")
Finding = TypeVar("Finding")

PATIENCE_S = 0.5
"""Between two looks at the stop token."""


def examined(
    examine: Callable[[Case], Finding],
    wanted: Sequence[Case],
    *,
    jobs: int,
    stop: StopToken,
    progress: Callable[[int, int], None],
) -> list[Finding]:
    """Return the finding of every case, in order, whatever the number of processes.

    `examine` is a function of a module, and its findings follow from the case alone. `progress` is
    told how many of how many are done. Raises AbortedError once the token is set.
    """
    found: list[Finding] = []
    for finding in _findings(examine, wanted, jobs, stop):
        found.append(finding)
        progress(len(found), len(wanted))
        if stop.is_set():
            raise AbortedError(f"the study was stopped after {len(found)} of {len(wanted)} rigs")
    return found


def _findings(
    examine: Callable[[Case], Finding], wanted: Sequence[Case], jobs: int, stop: StopToken
) -> Iterator[Finding]:
    if jobs == 1:
        yield from map(examine, wanted)
        return
    # Leaving the context ends the processes at once, whatever they are at: nothing is lost by it.
    with get_context("spawn").Pool(jobs, _leave_interrupts) as pool:
        results = pool.imap(examine, wanted)
        for _ in wanted:
            yield _awaited(results, stop)


def _awaited(results: IMapIterator[Finding], stop: StopToken) -> Finding:
    """Return the next finding; a signal may have ended the process that was to find it."""
    while True:
        try:
            return results.next(PATIENCE_S)
        except TimeoutError:
            if stop.is_set():
                raise AbortedError("the study was stopped") from None


def _leave_interrupts() -> None:
    """Ctrl-C goes to the process that began the study, which ends the others."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
