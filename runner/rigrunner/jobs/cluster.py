"""Process the items on a Dask cluster: many machines, or several processes of one."""

from __future__ import annotations

import asyncio
from collections import deque
from contextlib import contextmanager
from dataclasses import dataclass
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any

from rigrunner.api.errors import DataError, MissingPackageError, UsageError
from rigrunner.jobs.done import Answer, Done, Item, Value, attempt

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from distributed import Client, Future

    from rigrunner.api.devices import StopToken

PATIENCE_S = 0.5
"""Time between two checks of the stop token."""

AHEAD = 1000
"""How many items the scheduler has at a time: enough for a large cluster, and a small list."""


@dataclass(frozen=True)
class Cluster:
    """The workers of a Dask scheduler at an address such as tcp://10.0.0.5:8786.

    If a worker dies, another one processes its item, as often as the scheduler allows. Workers run
    the code that they are sent, so they belong on a trusted network, or behind tls://.
    """

    address: str
    patience_s: int = 10
    """How long the scheduler may take to answer."""

    def outcomes(
        self, task: Callable[[Item], Value], items: Sequence[Item], stop: StopToken
    ) -> Iterator[Done[Item, Value]]:
        """Yield the outcome of each item; see `Workers`.

        Raises UsageError if there is no cluster at the address, and DataError if it is lost.
        """
        with _connected(self) as client:
            scheduled = _Scheduled(client, task, items)
            while not stop.is_set() and scheduled.is_busy():
                for place, answer in scheduled.answers():
                    yield Done(place, items[place], answer)


class _Scheduled:
    """The items that the scheduler has.

    The scheduler blames the death of a worker on each item that the worker had. So an item with too
    many deaths is tried again alone: a death then is its own fault.
    """

    def __init__(self, client: Client, task: Callable[[Any], Any], items: Sequence[Any]) -> None:
        self._client = client
        self._task = task
        self._items = items
        self._waiting = deque(range(len(items)))
        self._blamed: deque[int] = deque()
        self._places: dict[object, int] = {}
        self._ready: SimpleQueue[Future[Any]] = SimpleQueue()
        self._alone = False

    def is_busy(self) -> bool:
        """Send further items to the scheduler; return whether any is unfinished."""
        while self._waiting and len(self._places) < AHEAD:
            self._submit(self._waiting.popleft())
        if self._blamed and not self._places:
            self._alone = True
            self._submit(self._blamed.popleft())
        return bool(self._places)

    def answers(self) -> Iterator[tuple[int, Answer[Any]]]:
        """Yield the outcome of the next item, if one is ready soon."""
        try:
            future = self._ready.get(timeout=PATIENCE_S)
        except Empty:
            return
        place = self._places.pop(future.key)
        answer = _answer(future)
        if answer is None and not self._alone:
            self._blamed.append(place)
        else:
            yield place, answer or Answer(None, "each worker of the cluster that began it died")

    def _submit(self, place: int) -> None:
        # Not pure, or equal items would be one key, and one answer for all of them.
        future = self._client.submit(attempt, self._task, self._items[place], pure=False)
        self._places[future.key] = place
        future.add_done_callback(self._ready.put)


def _answer(future: Future[Any]) -> Answer[Any] | None:
    """Return the answer, or None if too many workers died."""
    import distributed.client  # noqa: PLC0415  (heavy)

    try:
        answer: Answer[Any] = future.result()
    except distributed.KilledWorker:
        return None
    except distributed.client.FutureCancelledError as error:
        raise DataError(
            "the scheduler of the cluster is gone",
            hint="finished work is kept: the same command continues with the rest",
        ) from error
    return answer


@contextmanager
def _connected(cluster: Cluster) -> Iterator[Client]:
    try:
        from distributed import Client  # noqa: PLC0415  (heavy, and needed for clusters alone)
    except ImportError as error:
        raise MissingPackageError(
            "a cluster needs the package 'distributed'", hint="pip install 'rigrunner[dask]'"
        ) from error
    try:
        # First: a client without a scheduler is half made, and delays the end of the program.
        asyncio.run(_reach(cluster))
        client = Client(cluster.address, timeout=cluster.patience_s, set_as_default=False)
    except (OSError, ValueError) as error:
        raise UsageError(
            f"no Dask scheduler answers at '{cluster.address}'",
            hint="'dask scheduler' prints its address, such as tcp://10.0.0.5:8786",
        ) from error
    with client:
        if not client.scheduler_info()["workers"]:
            raise UsageError(
                f"the cluster at '{cluster.address}' has no worker",
                hint=f"start one on each machine: 'dask worker {cluster.address}'",
            )
        yield client


async def _reach(cluster: Cluster) -> None:
    import distributed.comm.core  # noqa: PLC0415  (heavy)

    security = distributed.Security().get_connection_args("client")
    comm = await distributed.comm.core.connect(
        cluster.address, timeout=cluster.patience_s, **security
    )
    await comm.close()
