"""The queue of specimens in a file that survives a crash."""

from rigrunner.queue.entries import Draft
from rigrunner.queue.intake import accepted_inputs, list_text, read_list
from rigrunner.queue.store import Queue
from rigrunner.queue.tested import allowed

__all__ = ["Draft", "Queue", "accepted_inputs", "allowed", "list_text", "read_list"]
