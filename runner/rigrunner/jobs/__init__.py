"""Apply one task to many items: in this process, on all cores, or on a cluster.

Outcomes come as they are ready, one for each item. A failed item is an outcome too, so the others
continue. A journal keeps finished items, so that interrupted work can be resumed.
"""

from rigrunner.jobs.cluster import Cluster
from rigrunner.jobs.done import Done, InProcess, Workers
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
