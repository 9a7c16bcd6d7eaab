"""Shared by commands over many items: options of workers, and progress."""

from __future__ import annotations

import sys
import time
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import click

from rigrunner.api.errors import UsageError
from rigrunner.cli.durations import clock_text
from rigrunner.cli.output import message

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from rigrunner.jobs import Workers

    Progress = Callable[[int, int], None]

LINES = 20
"""Lines of progress, if there is no terminal for a bar."""


def worker_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options that select the workers."""
    jobs = click.option(
        "--jobs",
        type=click.IntRange(min=1),
        help="Processes to use; by default one per core.",
    )
    dask = click.option(
        "--dask",
        metavar="ADDRESS",
        help="Use the workers of this Dask scheduler instead, such as tcp://10.0.0.5:8786.",
    )
    return jobs(dask(command))


def workers_for(jobs: int | None, dask: str | None) -> Workers:
    """Return the workers; raise UsageError if two kinds are given."""
    from rigrunner.jobs import Cluster, Processes, usable_cores  # noqa: PLC0415  (not for help)

    if dask is None:
        return Processes(jobs or usable_cores())
    if jobs is not None:
        raise UsageError(
            "--jobs and --dask exclude each other",
            hint="a cluster has as many processes as its workers: 'dask worker --nworkers N'",
        )
    return Cluster(dask)


@contextmanager
def shown_count(noun: str) -> Iterator[Progress]:
    """Yield a function that shows how many are done, and the time left: as a bar, or as lines."""
    if not sys.stderr.isatty():
        yield CountedLines(noun)
        return
    from rigrunner.cli.progress import new_bar  # noqa: PLC0415  (not for help)

    with new_bar() as bar:
        task = bar.add_task(noun, total=None, step="")

        def move(done: int, of: int) -> None:
            bar.update(task, completed=done, total=of, step=f"{done} of {of} {noun}")

        yield move


class CountedLines:
    """Prints a line now and then, with the time left at the present rate."""

    def __init__(self, noun: str, now: Callable[[], float] = time.monotonic) -> None:
        self._noun = noun
        self._now = now
        self._before: int | None = None
        self._began_s = 0.0

    def __call__(self, done: int, of: int) -> None:
        """Take how many are done of how many; the first call says how many were done before."""
        if self._before is None:
            self._before, self._began_s = done, self._now()
            if done:
                message(f"{done} of {of} {self._noun} were done before")
            return
        if done * LINES // of > (done - 1) * LINES // of:
            new, time_left = done - self._before, ""
            if new and done < of:
                left_s = (of - done) * (self._now() - self._began_s) / new
                time_left = f", {clock_text(left_s)} left"
            message(f"{done} of {of} {self._noun}{time_left}")
