"""`rigrunner queue`: the queue of specimens."""

from __future__ import annotations

from rigrunner.cli.lazy import lazy_group

SUMMARIES = {
    "list": "List the entries of the queue.",
    "add": "Add specimens to the queue.",
    "next": "Run the next specimen of the queue.",
    "move": "Move an entry in front of another one.",
    "hold": "Hold an entry until it is released.",
    "release": "Release an entry that is proposed or held.",
    "skip": "Skip an entry, or close one whose run was interrupted.",
    "repeat": "Test the specimen of an entry again.",
    "clear": "Remove finished entries.",
}

command = lazy_group(
    "queue",
    __name__,
    SUMMARIES,
    """Queue specimens and run them one after the other.

Each station has a queue: a file queue-STATION.json in the folder of runs. The panel shows and runs
the same queues.""",
)
