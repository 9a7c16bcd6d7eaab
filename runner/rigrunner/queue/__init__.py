"""The queue of specimens in a file that survives a crash."""

from rigrunner.queue.entries import SPECIMEN, Draft
from rigrunner.queue.intake import accepted_inputs, list_text, read_list
from rigrunner.queue.store import Queue
from rigrunner.queue.tested import tested_before

__all__ = [
    "SPECIMEN",
    "Draft",
    "Queue",
    "accepted_inputs",
    "list_text",
    "read_list",
    "tested_before",
]
