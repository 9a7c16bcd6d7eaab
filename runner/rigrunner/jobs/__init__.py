"""One task over many items: in this process, on all cores, or on a cluster.

The outcomes come as they are ready, each item's once. What fails is an outcome as well, so that it
ends nothing; a journal keeps what is done, so that what was interrupted goes on.
"""

from rigrunner.jobs.cluster import Cluster
from rigrunner.jobs.done import Done, Workers
from rigrunner.jobs.here import InProcess
from rigrunner.jobs.journal import Journal, discard, journal
from rigrunner.jobs.processes import Processes, usable_cores

__all__ = [
    "Cluster",
    "Done",
    "InProcess",
    "Journal",
    "Processes",
    "Workers",
    "discard",
    "journal",
    "usable_cores",
]
