"""Messages of the guardian on the terminal of the run."""

from __future__ import annotations

import os
from contextlib import suppress


def say(text: str) -> None:
    """Write a line to stderr, unbuffered; drop it if the terminal was closed."""
    with suppress(OSError):
        os.write(2, f"\nguardian: {text}\n".encode(errors="replace"))
