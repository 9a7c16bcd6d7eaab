"""A Dask cluster of processes on this machine, for as long as a test lasts."""

from __future__ import annotations

import time
from contextlib import contextmanager, suppress

import pytest


@contextmanager
def two_workers(workers=2):
    """Run a scheduler with worker processes; dead ones are given up after a short time-out."""
    dask, distributed = pytest.importorskip("dask"), pytest.importorskip("distributed")
    patience = {"distributed.comm.timeouts.connect": "2s"}
    with (
        dask.config.set(patience),
        distributed.LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            dashboard_address="127.0.0.1:0",
            host="127.0.0.1",
        ) as cluster,
    ):
        yield cluster
        if workers and cluster.status is distributed.Status.running:
            with suppress(TimeoutError):  # or closing fails while a worker restarts
                cluster.wait_for_workers(workers, timeout=60)


def busy_pid(address):
    """Return the process id of a worker that is processing an item."""
    import distributed  # noqa: PLC0415  (an extra)

    with distributed.Client(address, set_as_default=False) as client:
        for _ in range(500):
            for worker, keys in client.processing().items():
                if keys:
                    return client.run(_pid, workers=[worker])[worker]
            time.sleep(0.01)
    raise AssertionError("no worker was at work")


def _pid():
    import os  # noqa: PLC0415  (sent to a worker as it is)

    return os.getpid()
